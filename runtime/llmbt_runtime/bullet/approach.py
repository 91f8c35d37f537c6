"""Whether and how the hand gets at a thing: grasps, sweeps of the hand, free spots.

A second, kinematic client mirrors the physics: bodies are set where they are, the arm where it would be, and Bullet's
distance queries say what would touch. Nothing is ever stepped in it. Poses of the tip are in the frame of the robot's
base, everything else is in the world.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import MAX_GRASP_M, Body, Scene, ScenePlace
from llmbt_runtime.bullet.bodies import BodyState, Extent, lying_at
from llmbt_runtime.bullet.client import BulletClient
from llmbt_runtime.bullet.kinematics import TipPose, central_yaw, solve_one
from llmbt_runtime.bullet.robot import FINGERS, MAX_OPENING_M, load_panda
from llmbt_runtime.bullet.scene_builder import add_bodies, add_fixtures

__all__ = ["Approach", "BaseFrame", "Carried", "Grasp", "Verdict"]

PREGRASP_M = 0.09
"""The hand comes straight down from at least this far above a grasp."""
FINGER_BELOW_TIP_M = 0.0115
_SWEEP_M = (0.0, 0.02, 0.05, PREGRASP_M)
_GRASP_DEPTH_M = 0.03
_HIGHER_M, _LEAST_DEPTH_M = 0.009, 0.012
"""Where a step is in the way of the palm, a thing is taken this much higher, if that is not too near its top."""
_OPEN_BESIDE_M = (0.010, 0.005)
"""How far the fingers are open beside a thing on either side; the second in tight places."""
_RELEASE_BESIDE_M = 0.006
_MARGIN_M = 0.0015
_FIRST_MOVING_LINK = 2
_TILT_LIMIT = math.sin(math.radians(40))
_FAR: Vec3 = (90.0, 90.0, 0.0)
_SPOT_STEP_M = 0.02
_SPOT_GAP_M, _SPOT_GAP_TILTED_M = 0.055, 0.025
_SPOT_FIXTURE_GAP_M = 0.09
_SPOT_TRIES = 16
_MIN_REACH_M, _MAX_REACH_M = 0.30, 0.74


@dataclass(frozen=True, slots=True)
class BaseFrame:
    """The frame of the robot's base in the world."""

    xyz_m: Vec3
    yaw_rad: float

    def to_base(self, x: float, y: float, z: float, yaw: float) -> TipPose:
        """A tip pose of the world in the frame of the base."""
        dx, dy = x - self.xyz_m[0], y - self.xyz_m[1]
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return (c * dx + s * dy, -s * dx + c * dy, z - self.xyz_m[2], yaw - self.yaw_rad)

    def to_world(self, pose: TipPose) -> TipPose:
        """A tip pose in the frame of the base, in the world."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x, y, z, yaw = pose
        return (
            self.xyz_m[0] + c * x - s * y,
            self.xyz_m[1] + s * x + c * y,
            z + self.xyz_m[2],
            yaw + self.yaw_rad,
        )


@dataclass(frozen=True, slots=True)
class Grasp:
    """Where the tip goes (base frame), how wide the fingers open before and how wide the thing is between them."""

    tip: TipPose
    opening_m: float
    width_m: float


@dataclass(frozen=True, slots=True)
class Carried:
    """How a held thing sits in the hand: its centre seen from the tip, in the hand's yaw frame, and its turn.

    A tilted one will fall over when it is let go.
    """

    id: str
    along_m: float
    across_m: float
    below_m: float
    bottom_below_tip_m: float
    turn_rad: float
    width_m: float
    tilted: bool = False


@dataclass(frozen=True, slots=True)
class Verdict:
    """A grasp or a place to let go, or why there is none: out of reach, a fixture, or the body `blocker`.

    `options` are the sets of bodies that would have to go, one for each way that fixtures leave open.
    """

    grasp: Grasp | None = None
    blocker: str | None = None
    reachable: bool = True
    options: tuple[tuple[str, ...], ...] = ()


class Approach:
    """The kinematic shadow of a scene."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.frame = BaseFrame(scene.robot_xyz_m, scene.robot_yaw_rad)
        self.client = client = BulletClient()
        self._fixtures = add_fixtures(client, scene)
        self._robot = load_panda(client, scene.robot_xyz_m, scene.robot_yaw_rad, visible=False)
        self._bodies = add_bodies(client, scene)
        self._kinds: dict[str, Body] = {b.id: b for b in (*scene.objects, *scene.obstacles)}
        self._here: dict[str, BodyState] = {}
        for id_ in self._bodies:
            self._away(id_)

    def _away(self, id_: str) -> None:
        index = list(self._bodies).index(id_)
        self.client.resetBasePositionAndOrientation(
            self._bodies[id_], (_FAR[0] + index, _FAR[1], _FAR[2]), (0, 0, 0, 1)
        )
        self._here.pop(id_, None)

    def _set(self, id_: str, state: BodyState) -> None:
        self.client.resetBasePositionAndOrientation(self._bodies[id_], state.xyz, state.quat)
        self._here[id_] = state

    def mirror(self, states: Mapping[str, BodyState], without: str | None = None) -> None:
        """Set the bodies where they are; `without` (the held one) and what is out of play are taken away."""
        for id_ in self._bodies:
            state = states.get(id_) if id_ != without else None
            if state is None:
                if id_ in self._here:
                    self._away(id_)
            elif (known := self._here.get(id_)) is None or known.xyz != state.xyz or known.quat != state.quat:
                self._set(id_, state)

    # ------------------------------------------------------------------ the hand

    def _pose_arm(self, tip: TipPose, opening_m: float) -> bool:
        q = solve_one(tip)
        if q is None:
            return False
        client = self.client
        for j, value in enumerate(q.tolist()):
            client.resetJointState(self._robot, j, value)
        for j in FINGERS:
            client.resetJointState(self._robot, j, opening_m / 2)
        return True

    def _arm_hits(self, without: str | None) -> tuple[bool, tuple[str, ...]]:
        """Whether the arm as posed touches a fixture, and which bodies it touches."""
        client, robot = self.client, self._robot
        reach = 0.25
        hits: list[str] = []
        tip = client.getLinkState(robot, 11, computeForwardKinematics=1)[4]
        for id_, state in self._here.items():
            if id_ == without or math.hypot(state.xyz[0] - tip[0], state.xyz[1] - tip[1]) > reach:
                continue
            if any(
                c[3] >= _FIRST_MOVING_LINK
                for c in client.getClosestPoints(robot, self._bodies[id_], distance=_MARGIN_M)
            ):
                hits.append(id_)
        fixture = any(
            c[3] >= _FIRST_MOVING_LINK
            for body in self._fixtures.values()
            for c in client.getClosestPoints(robot, body, distance=_MARGIN_M)
        )
        return fixture, tuple(hits)

    def _sweep(self, tip: TipPose, opening_m: float, without: str) -> tuple[bool, bool, tuple[str, ...]]:
        """Reachable, free of fixtures, and the bodies in the way of a hand that comes straight down to `tip`."""
        hits: list[str] = []
        for up in _SWEEP_M:
            if not self._pose_arm((tip[0], tip[1], tip[2] + up, tip[3]), opening_m):
                return False, False, ()
            fixture, found = self._arm_hits(without)
            if fixture:
                return True, False, ()
            hits += [f for f in found if f not in hits]
        return True, True, tuple(hits)

    def grasps(self, body: Body, state: BodyState) -> list[Grasp]:
        """The ways to take a thing from above with its faces between the fingers, the handiest first."""
        ext = state.extent
        deepest = min(ext.half[2], _GRASP_DEPTH_M)
        depths = (deepest, max(deepest - _HIGHER_M, _LEAST_DEPTH_M))
        found: list[tuple[tuple[float, ...], Grasp]] = []
        square = [(0, *axis) for axis in _finger_axes(body, state)]
        askew = [(1, *axis) for axis in _askew_axes(body, state)]
        for (turns, yaw, width), depth, beside in itertools.product(square + askew, depths, _OPEN_BESIDE_M):
            if width > MAX_GRASP_M:
                continue
            z = max(ext.top_m - depth, ext.bottom_m + FINGER_BELOW_TIP_M + 0.001)
            x, y, zb, yb = self.frame.to_base(*state.xyz[:2], z, yaw)
            yb = central_yaw(x, y, yb)
            twist = abs(yb - (math.pi / 2 + math.atan2(y, x)))
            opening = min(MAX_OPENING_M, width + 2 * beside)
            found.append(((turns, -beside, -round(depth, 4), round(twist, 3)), Grasp((x, y, zb, yb), opening, width)))
        return [g for _, g in sorted(found, key=lambda f: f[0])]

    def grasp(self, id_: str) -> Verdict:
        """The handiest grasp of a mirrored body that nothing is in the way of; else what is."""
        options: list[tuple[str, ...]] = []
        for g in self.grasps(self._kinds[id_], self._here[id_]):
            reach, fixtures, hits = self._sweep(g.tip, g.opening_m, id_)
            if reach and fixtures and not hits:
                return Verdict(g)
            if reach and fixtures and hits not in options:
                options.append(hits)
        return Verdict(None, self.blocker(id_, options), bool(options), tuple(options))

    def blocker(self, id_: str, options: Iterable[tuple[str, ...]], clear: frozenset[str] = frozenset()) -> str | None:
        """Which body to move so that a mirrored one can be taken: of the way that the fewest bodies bar, best ones in
        `clear`, the nearest; those that are clear first."""
        xyz = self._here[id_].xyz

        def cost(hits: tuple[str, ...]) -> tuple[int, int, float, tuple[str, ...]]:
            far = min(math.dist(self._here[b].xyz, xyz) for b in hits)
            return sum(b not in clear for b in hits), len(hits), round(far, 4), hits

        best = min((o for o in options if o), key=cost, default=())
        return min(best, key=lambda b: (b not in clear, round(math.dist(self._here[b].xyz, xyz), 4), b), default=None)

    # ------------------------------------------------------------------ letting go

    def tip_for(self, carried: Carried, x: float, y: float, bottom_m: float, yaw: float) -> TipPose:
        """Where the tip must be (base frame) for a held thing's centre to be over (x, y), its bottom at a height, and
        the fingers opening along `yaw`."""
        c, s = math.cos(yaw), math.sin(yaw)
        tx = x - (c * carried.along_m - s * carried.across_m)
        ty = y - (s * carried.along_m + c * carried.across_m)
        bx, by, bz, byaw = self.frame.to_base(tx, ty, bottom_m + carried.bottom_below_tip_m, yaw)
        return (bx, by, bz, central_yaw(bx, by, byaw))

    def let_go(self, carried: Carried, x: float, y: float, bottom_m: float, yaws: Sequence[float]) -> Verdict:
        """How to put a held thing down at a spot: the first of the yaws with nothing in the way."""
        body = self._kinds[carried.id]
        opening = min(MAX_OPENING_M, carried.width_m + 2 * _RELEASE_BESIDE_M)
        blockers: dict[str, None] = {}
        reachable = False
        for yaw in yaws:
            tip = self.tip_for(carried, x, y, bottom_m, yaw)
            reach, fixtures, hits = self._sweep(tip, opening, carried.id)
            if not (reach and fixtures):
                continue
            reachable = True
            lying = self._lying(body, carried, x, y, bottom_m, yaw)
            if not hits and not lying:
                return Verdict(Grasp(tip, opening, carried.width_m))
            blockers.update(dict.fromkeys((*lying, *hits)))
        return Verdict(None, next(iter(blockers), None), reachable)

    def _lying(self, body: Body, carried: Carried, x: float, y: float, bottom_m: float, yaw: float) -> tuple[str, ...]:
        """The bodies that a thing put down at a spot would reach into."""
        state = self._put_down(body, carried, x, y, bottom_m, yaw)
        self._set(body.id, state)
        hits = tuple(
            id_
            for id_ in self._here
            if id_ != body.id and self.client.getClosestPoints(self._bodies[body.id], self._bodies[id_], distance=0.001)
        )
        self._away(body.id)
        return hits

    @staticmethod
    def _put_down(body: Body, carried: Carried, x: float, y: float, bottom_m: float, yaw: float) -> BodyState:
        z = bottom_m + carried.bottom_below_tip_m - carried.below_m
        return lying_at(body, (x, y, z + 0.001), yaw + carried.turn_rad)

    def fits(self, id_: str, state: BodyState) -> bool:
        """Whether a body could be at a pose without reaching into a mirrored body or a fixture."""
        known = self._here.get(id_)
        self._set(id_, state)
        solids = [self._bodies[o] for o in self._here if o != id_] + list(self._fixtures.values())
        free = not any(
            c[8] < -0.0005
            for body in solids
            for c in self.client.getClosestPoints(self._bodies[id_], body, distance=0.0)
        )
        if known is not None:
            self._set(id_, known)
        else:
            self._away(id_)
        return free

    # ------------------------------------------------------------------ free spots

    def spots(
        self, place: ScenePlace, half_m: float, keep_off: Iterable[Extent], gap_m: float = _SPOT_GAP_M
    ) -> list[tuple[float, float]]:
        """Where in a region a thing of half-width `half_m` would lie apart from everything, the roomiest first."""
        if place.surface_m is None:
            return []
        px, py, pz = place.surface_m
        rx, ry = place.size_m[0] / 2 - half_m - 0.005, place.size_m[1] / 2 - half_m - 0.005
        if rx < 0 or ry < 0:
            return []
        xs = np.linspace(-rx, rx, max(1, int(2 * rx / _SPOT_STEP_M) + 1)) + px if rx > 0 else np.array([px])
        ys = np.linspace(-ry, ry, max(1, int(2 * ry / _SPOT_STEP_M) + 1)) + py if ry > 0 else np.array([py])
        gx, gy = (a.ravel() for a in np.meshgrid(xs, ys, indexing="ij"))
        bx, by = gx - self.frame.xyz_m[0], gy - self.frame.xyz_m[1]
        away = np.hypot(bx, by)
        ok = (away >= _MIN_REACH_M) & (away <= _MAX_REACH_M)
        ok &= np.abs(np.arctan2(by, bx) - self.frame.yaw_rad) < math.radians(150)
        for f in self.scene.fixtures:
            if f.top_m > pz + 0.005:
                gap = np.maximum(np.abs(gx - f.xyz_m[0]) - f.size_m[0] / 2, np.abs(gy - f.xyz_m[1]) - f.size_m[1] / 2)
                ok &= gap >= half_m + _SPOT_FIXTURE_GAP_M
        room = np.full(len(gx), 0.12)
        for e in keep_off:
            gap = np.maximum(np.abs(gx - e.centre[0]) - e.half[0], np.abs(gy - e.centre[1]) - e.half[1])
            room = np.minimum(room, gap - half_m)
        ok &= room >= gap_m
        index = np.flatnonzero(ok)
        order = np.lexsort((gy[index], gx[index], np.round(away[index], 3), -np.round(room[index], 3)))
        return [(float(gx[i]), float(gy[i])) for i in index[order]]

    def spot(
        self, carried: Carried, place: ScenePlace, yaws: Sequence[float], avoid: str | None = None
    ) -> tuple[tuple[float, float], Verdict] | None:
        """A spot in a region where a held thing can be put down and taken up again, and blocks nothing.

        `avoid` is a body that must be clear afterwards, the one for whose sake the thing is moved.
        """
        body, surface = self._kinds[carried.id], place.surface_m
        if surface is None:
            return None
        keep_off = [s.extent for s in self._here.values()]
        half = math.hypot(*body.size_m[:2]) / 2 if _turned(yaws) else max(body.size_m[:2]) / 2
        spots = self.spots(place, half, keep_off)
        if carried.tilted:  # room to fall over, where there is any
            wide = self.spots(place, math.hypot(*body.size_m) / 2, keep_off, _SPOT_GAP_TILTED_M)
            spots = wide or spots
        before = {id_: self.grasp(id_) for id_ in sorted(self._here)}
        for x, y in spots[:_SPOT_TRIES]:
            verdict = self.let_go(carried, x, y, surface[2], yaws)
            if verdict.grasp is None:
                continue
            if self._leaves_clear(carried, (x, y), surface[2], verdict.grasp, before, avoid):
                return (x, y), verdict
        return None

    def _leaves_clear(
        self,
        carried: Carried,
        at: tuple[float, float],
        bottom_m: float,
        how: Grasp,
        before: Mapping[str, Verdict],
        avoid: str | None,
    ) -> bool:
        """Whether everything that could be taken still can be with the carried thing lying at a spot."""
        near = [id_ for id_, s in self._here.items() if math.hypot(s.xyz[0] - at[0], s.xyz[1] - at[1]) < 0.25]
        body = self._kinds[carried.id]
        self._set(body.id, self._put_down(body, carried, *at, bottom_m, how.tip[3] + self.frame.yaw_rad))
        try:
            wanted = [id_ for id_ in near if before[id_].grasp is not None or id_ == avoid]
            return all(self.grasp(id_).grasp is not None for id_ in (carried.id, *wanted))
        finally:
            self._away(carried.id)

    def close(self) -> None:
        """Disconnect."""
        self.client.close()


def _turned(yaws: Sequence[float]) -> bool:
    return any(abs(math.sin(2 * y)) > 0.05 for y in yaws)


def _finger_axes(body: Body, state: BodyState) -> list[tuple[float, float]]:
    """Yaws (world) along which the fingers may close on a thing, and its width there."""
    columns = [tuple(row[i] for row in state.axes) for i in (0, 1, 2)]
    sx, sy, sz = body.size_m
    if body.shape == "sphere":
        return [(k * math.pi / 4, sx) for k in range(4)]
    if body.shape == "cylinder":
        u = columns[2]
        if abs(u[2]) > 0.7:
            return [(k * math.pi / 4, sx) for k in range(4)]
        return [(math.atan2(u[1], u[0]) + math.pi / 2, sx)]
    flat = [
        (abs(c[2]), math.atan2(c[1], c[0]), size)
        for c, size in zip(columns, (sx, sy, sz), strict=True)
        if abs(c[2]) < _TILT_LIMIT
    ]
    return [(yaw, size) for _, yaw, size in sorted(flat, key=lambda f: round(f[0], 4))]


def _askew_axes(body: Body, state: BodyState) -> list[tuple[float, float]]:
    """Yaws for a box that its faces offer no grasp of, and the box's extent there.

    An upright one that stands askew, as against the riser of a step, is turned flush by the fingers as they close along
    the world's axes, or held by its corners. One that leans somewhere is taken as it comes.
    """
    if body.shape in ("cylinder", "sphere"):
        return []
    yaws = [0.0, math.pi / 2] if state.upright(body.shape) else [k * math.pi / 8 for k in range(8)]
    return [(yaw, _width_along(body, state, yaw)) for yaw in yaws]


def _width_along(body: Body, state: BodyState, yaw: float) -> float:
    """The extent of a box along a horizontal direction."""
    c, s = math.cos(yaw), math.sin(yaw)
    x, y, _ = state.axes
    return sum(abs(c * x[i] + s * y[i]) * body.size_m[i] for i in (0, 1, 2))
