"""Whether and how the hand gets at a thing: sweeps of the hand past everything else.

A second, kinematic client mirrors the physics: bodies are set where they are, the arm where it would be, and Bullet's
distance queries say what would touch. Nothing is ever stepped in it. Poses of the tip are in the frame of the robot's
base, everything else is in the world.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Body, ScenePlace
from llmbt_runtime.bullet.bodies import BodyState
from llmbt_runtime.bullet.client import BulletClient
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.grasping import Carried, Grasp, Verdict, grasps_of, held_state, put_down_state, tip_for
from llmbt_runtime.bullet.kinematics import TipPose, central_yaw, solve_one, tip_of
from llmbt_runtime.bullet.robot import MAX_OPENING_M, load_robot
from llmbt_runtime.bullet.scene_builder import add_bodies, add_fixtures
from llmbt_runtime.bullet.spots import SPOT_GAP_TILTED_M, free_spots
from llmbt_runtime.bullet.stage import Stage

__all__ = ["Approach"]

Array = NDArray[np.float64]

PREGRASP_M = 0.09
"""The hand comes straight down from at least this far above a grasp."""
_SWEEP_M = (0.0, 0.02, 0.05, PREGRASP_M)
_RELEASE_BESIDE_M = 0.006
_MARGIN_M = 0.0015
_PLANNED_MARGIN_M = 0.006
_NEAR_HAND_M = 0.25
_FAR: Vec3 = (90.0, 90.0, 0.0)
_SPOT_TRIES = 16
_LONG_M = 0.01


class Approach:
    """The kinematic shadow of a scene."""

    def __init__(self, stage: Stage) -> None:
        self.stage, scene = stage, stage.scene
        self.frame = BasePose.of_scene(scene)
        self.client = client = BulletClient()
        self._fixtures = add_fixtures(client, scene)
        self._robot = load_robot(client, scene, visible=False)
        self._bodies = add_bodies(client, scene)
        self._kinds: dict[str, Body] = {b.id: b for b in (*scene.objects, *scene.obstacles)}
        self._here: dict[str, BodyState] = {}
        for id_ in self._bodies:
            self._away(id_)

    def stand_at(self, at: BasePose) -> None:
        """Where the robot's base is. Nothing happens to one that is bolted down."""
        if self._robot.joints.base and at != self.frame:
            self._robot.stand_at(self.client, at)
            self.frame = at

    @contextmanager
    def standing_at(self, at: BasePose) -> Iterator[None]:
        """As `stand_at`, for a while."""
        before = self.frame
        self.stand_at(at)
        try:
            yield
        finally:
            self.stand_at(before)

    def move_fixtures(self) -> None:
        """Set the fixtures where the stage has them now."""
        for f in self.stage.scene.fixtures:
            self.client.resetBasePositionAndOrientation(self._fixtures[f.id], f.xyz_m, (0, 0, 0, 1))

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
        self._pose_joints(q, opening_m)
        return True

    def _pose_joints(self, q: Array, opening_m: float) -> None:
        client, robot = self.client, self._robot
        for j, value in zip(robot.joints.arm, q.tolist(), strict=True):
            client.resetJointState(robot.body, j, value)
        for j in robot.joints.fingers:
            client.resetJointState(robot.body, j, opening_m / 2)

    def touches(self, q: Array, opening_m: float) -> bool:
        """Whether the arm at some joint angles touches a fixture or a mirrored body."""
        self._pose_joints(q, opening_m)
        fixture, bodies = self._arm_hits(None)
        return fixture or bool(bodies)

    def _arm_hits(self, without: str | None) -> tuple[bool, tuple[str, ...]]:
        """Whether the arm as posed touches a fixture, and which bodies it touches."""
        client, robot = self.client, self._robot.body
        first = self._robot.joints.first_moving_link
        hits: list[str] = []
        tip = client.getLinkState(robot, self._robot.joints.tip, computeForwardKinematics=1)[4]
        for id_, state in self._here.items():
            if id_ == without or math.hypot(state.xyz[0] - tip[0], state.xyz[1] - tip[1]) > _NEAR_HAND_M + _beyond(
                state
            ):
                continue
            if any(c[3] >= first for c in client.getClosestPoints(robot, self._bodies[id_], distance=_MARGIN_M)):
                hits.append(id_)
        return self._touches_fixture(), tuple(hits)

    def free_along(self, joints: Iterable[Array], opening_m: float, carried: Carried | None) -> bool:
        """Whether the arm, with what it holds, keeps a margin from everything at each of some joint angles."""
        return all(self.is_free(q, opening_m, carried) for q in joints)

    def is_free(self, q: Array, opening_m: float, carried: Carried | None) -> bool:
        """Whether the arm at some joint angles, with what it holds, keeps a margin from everything."""
        self._pose_joints(q, opening_m)
        robot, first = self._robot.body, self._robot.joints.first_moving_link
        others = [*self._fixtures.values(), *(self._bodies[id_] for id_ in self._here)]
        near = (self.client.getClosestPoints(robot, body, distance=_PLANNED_MARGIN_M) for body in others)
        if any(c[3] >= first for points in near for c in points):
            return False
        if carried is None:
            return True
        body = self._kinds[carried.id]
        self._set(body.id, held_state(self.frame, body, carried, tip_of(q)))
        held, stand = self._bodies[body.id], range(first)
        touches = any(self.client.getClosestPoints(held, b, distance=_PLANNED_MARGIN_M) for b in others)
        stood_on = any(c[4] in stand for c in self.client.getClosestPoints(held, robot, distance=_PLANNED_MARGIN_M))
        self._away(body.id)
        return not touches and not stood_on

    def _touches_fixture(self) -> bool:
        robot, first = self._robot.body, self._robot.joints.first_moving_link
        return any(
            c[3] >= first
            for body in self._fixtures.values()
            for c in self.client.getClosestPoints(robot, body, distance=_MARGIN_M)
        )

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

    def reaches(self, at: BasePose, points: Iterable[Vec3]) -> bool:
        """Whether from a pose of the base the hand comes to all points (world), and no fixture is in the way."""
        with self.standing_at(at):
            for x, y, z in points:
                tip = self.frame.to_base(x, y, z, 0.0)
                along = (*tip[:3], central_yaw(tip[0], tip[1], math.pi / 2 + math.atan2(tip[1], tip[0])))
                if not self._pose_arm(along, MAX_OPENING_M) or self._touches_fixture():
                    return False
        return True

    def grasp(self, id_: str) -> Verdict:
        """The handiest grasp of a mirrored body that nothing is in the way of; else what is."""
        options: list[tuple[str, ...]] = []
        for g in grasps_of(self.frame, self._kinds[id_], self._here[id_]):
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

    def let_go(self, carried: Carried, x: float, y: float, bottom_m: float, yaws: Sequence[float]) -> Verdict:
        """How to put a held thing down at a spot: the first of the yaws with nothing in the way."""
        body = self._kinds[carried.id]
        opening = min(MAX_OPENING_M, carried.width_m + 2 * _RELEASE_BESIDE_M)
        blockers: dict[str, None] = {}
        reachable = False
        for yaw in yaws:
            tip = tip_for(self.frame, carried, x, y, bottom_m, yaw)
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
        state = put_down_state(body, carried, x, y, bottom_m, yaw)
        self._set(body.id, state)
        hits = tuple(
            id_
            for id_ in self._here
            if id_ != body.id and self.client.getClosestPoints(self._bodies[body.id], self._bodies[id_], distance=0.001)
        )
        self._away(body.id)
        return hits

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

    def spot(
        self, carried: Carried, place: ScenePlace, yaws: Sequence[float], avoid: str | None = None
    ) -> tuple[tuple[float, float], Verdict] | None:
        """A spot in a region where a held thing can be put down and taken up again, and blocks nothing.

        `avoid` is a body that must be clear afterwards, the one for whose sake the thing is moved.
        """
        surface = place.surface_m
        if surface is None:
            return None
        before = {id_: self.grasp(id_) for id_ in sorted(self._here)}
        for x, y, turns in self._spots(carried, place, yaws):
            verdict = self.let_go(carried, x, y, surface[2], turns)
            if verdict.grasp is None:
                continue
            if self._leaves_clear(carried, (x, y), surface[2], verdict.grasp, before, avoid):
                return (x, y), verdict
        return None

    def _spots(
        self, carried: Carried, place: ScenePlace, yaws: Sequence[float]
    ) -> Iterator[tuple[float, float, Sequence[float]]]:
        """Roomy spots for a held thing, each with the yaws that it has room in: of a long one, one at a time."""
        body = self._kinds[carried.id]
        keep_off, fixtures = [s.extent for s in self._here.values()], self.stage.scene.fixtures
        halves = [put_down_state(body, carried, 0.0, 0.0, 0.0, yaw).extent.half[:2] for yaw in yaws]
        widest = max(max(h) for h in halves)
        if widest - min(min(h) for h in halves) > _LONG_M and not carried.tilted:
            for yaw, half in zip(yaws, halves, strict=True):
                spots = free_spots(place, half, keep_off, fixtures, self.frame)
                yield from ((x, y, [yaw]) for x, y in self._packed(place, spots)[:_SPOT_TRIES])
            return
        spots = free_spots(place, (widest, widest), keep_off, fixtures, self.frame)
        if carried.tilted:  # room to fall over, where there is any
            fallen = math.hypot(*body.size_m) / 2
            spots = free_spots(place, (fallen, fallen), keep_off, fixtures, self.frame, SPOT_GAP_TILTED_M) or spots
        yield from ((x, y, yaws) for x, y in self._packed(place, spots)[:_SPOT_TRIES])

    def _packed(self, place: ScenePlace, spots: list[tuple[float, float]]) -> list[tuple[float, float]]:
        """Spots in the order in which a small region holds the most: a robot that drives fills it from the corners.

        What is no place of the scene is used in its middle.
        """
        if not self._robot.joints.base or place.surface_m is None:
            return spots
        x, y, _ = place.surface_m
        if all(p.id != place.id for p in self.stage.scene.places):
            return sorted(spots, key=lambda p: round(math.hypot(p[0] - x, p[1] - y), 3))
        return sorted(spots, key=lambda p: -round(abs(p[0] - x) / place.size_m[0] + abs(p[1] - y) / place.size_m[1], 2))

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
        self._set(body.id, put_down_state(body, carried, *at, bottom_m, how.tip[3] + self.frame.yaw_rad))
        try:
            wanted = [id_ for id_ in near if before[id_].grasp is not None or id_ == avoid]
            return all(self.grasp(id_).grasp is not None for id_ in (carried.id, *wanted))
        finally:
            self._away(carried.id)

    def close(self) -> None:
        """Disconnect."""
        self.client.close()


def _beyond(state: BodyState) -> float:
    """How far a large thing reaches beyond what a small one does."""
    return max(0.0, max(state.extent.half[:2]) - 0.1)
