"""The skills of the arm: generators that are resumed once a tick, after the physics, with what was sensed in it.

A skill ends by returning, or by raising SkillError with a reason. It may be closed between any two ticks outside a
contact phase; the arm then brakes on its path. Every skill starts from wherever the arm is.

Reasons: not_holding, not_approachable, moved_since_seen, missed, not_lifted, ik_unreachable, tracking_error,
spot_occupied, blocked, no_free_buffer, dropped_on_the_way, unstable_after_release, held_askew,
hand_not_empty, not_let_go.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field

import numpy as np

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.scene import Scene, ScenePlace
from llmbt_runtime.bullet.approach import FINGER_BELOW_TIP_M, Approach, Carried, Grasp, Verdict
from llmbt_runtime.bullet.bench import Bench
from llmbt_runtime.bullet.bodies import BodyState
from llmbt_runtime.bullet.kinematics import TipPose, central_yaw, solve_one
from llmbt_runtime.bullet.motion import plan_line
from llmbt_runtime.bullet.reporting import Reporter
from llmbt_runtime.bullet.robot import MAX_OPENING_M

__all__ = ["Skill", "SkillError", "Skills"]

Skill = Generator[None, None, None]

TRACKING_LIMIT_RAD = 0.02
_SILENT_BLOCK_RAD = 0.08
_FREE_SPEED, _FREE_ACCELERATION = 1.9, 7.0
_CARRY_SPEED, _CARRY_ACCELERATION = 1.6, 5.0
_FINE_SPEED, _FINE_ACCELERATION = 0.9, 4.0
_LIFT_M = 0.06
_CLEARANCE_M = 0.03
_CORRIDOR_M = 0.13
_HEADROOM_M = 0.04
_LET_GO_ABOVE_M = 0.0015
_CLOSE_TICKS = 9
_SETTLE_TICKS = 15
_WALL_GAP_M = 0.012
_ASKEW = math.sin(math.radians(14))
_REPLAN_M = 0.004
_REPLANS = 4


class SkillError(Exception):
    """A skill cannot go on. `blocker` is the body in the way, where there is one."""

    def __init__(self, reason: str, blocker: str | None = None) -> None:
        super().__init__(reason)
        self.reason, self.blocker = reason, blocker


@dataclass
class Skills:
    """What the skills act on. `facts` gives the settled facts of the last tick; `transferring` is the thing that is
    being carried over, while it is."""

    scene: Scene
    bench: Bench
    approach: Approach
    reporter: Reporter
    facts: Callable[[], Facts]
    carried: Carried | None = field(default=None)
    transferring: str | None = field(default=None)

    def skill(self, action: ActionCall) -> Skill:
        """The skill for an action of the library. ValueError where there is none."""
        match action.name, action.args:
            case "pick", (o, p):
                return self.pick(o, p)
            case (("place" | "put_down"), (o, p)):
                return self.place(o, p)
            case "move_aside", (o, p, region):
                return self.transfer(o, p, region)
            case "clear_away", (b, o, p, region):
                return self.transfer(b, p, region, for_=o)
            case "clear_place", (o, p, _, region):
                return self.transfer(o, p, region)
            case "release", (o,):
                return self.release(o)
            case "recover", (o, region):
                return self.transfer(o, region, region)
            case _:
                raise ValueError(f"no such action: {action}")

    # ------------------------------------------------------------------ the skills

    def pick(self, target: str, place: str) -> Skill:
        """Take a thing from above; ends with it held, a little above where it was."""
        yield from self._arm_at_rest()
        if self.bench.sensed.held is not None:
            raise SkillError("hand_not_empty", self.bench.sensed.held)
        grasp = self._grasp(target)
        for _ in range(_REPLANS):
            self.bench.panda.grip(grasp.opening_m if self._hand_clear() else MAX_OPENING_M)
            yield from self._over(grasp.tip, None)
            planned, grasp = grasp, self._grasp(target)
            if not _far(planned.tip, grasp.tip, _REPLAN_M):
                break
        else:
            raise SkillError("moved_since_seen")
        self.bench.panda.grip(grasp.opening_m)
        yield from self._down(grasp.tip, None)
        yield from self._close_and_lift(target, place, grasp)

    def place(self, target: str, place: str) -> Skill:
        """Put the held thing onto a slot, or onto a free spot of a region.

        One that has turned in the hand cannot be set onto a slot: it is put down in a buffer, to be taken anew.
        """
        yield from self._arm_at_rest()
        buffer = next((p.id for p in self.scene.places if p.buffer), None)
        if self.scene.place(place).is_slot and buffer is not None and self._askew(target):
            yield from self._put(target, buffer, for_=None)
            raise SkillError("held_askew")
        yield from self._put(target, place, for_=None)

    def transfer(self, target: str, place: str, region: str, for_: str | None = None) -> Skill:
        """Take a thing and put it down in a region, so that `for_` can be taken afterwards."""
        yield from self.pick(target, place)
        yield from self._put(target, region, for_=for_)

    def release(self, target: str) -> Skill:
        """Let go of whatever the fingers touch, and withdraw upwards."""
        yield from self._arm_at_rest()
        self.reporter.enter_contact(target, ())
        self.bench.panda.grip(MAX_OPENING_M)
        yield from self._wait(4)
        yield from self._up(0.10, _FINE_SPEED)
        yield from self._wait(1)
        if self.bench.sensed.touched:
            raise SkillError("not_let_go", self.bench.sensed.touched[0][0])
        self.reporter.leave_contact()

    # ------------------------------------------------------------------ taking

    def _grasp(self, target: str) -> Grasp:
        self._mirror()
        verdict = self.approach.grasp(target)
        if verdict.grasp is None:
            raise SkillError("not_approachable", verdict.blocker)
        return verdict.grasp

    def _close_and_lift(self, target: str, place: str, grasp: Grasp) -> Skill:
        self.reporter.enter_contact(target, (place,))
        bench = self.bench
        bench.panda.grip(0.0)
        for _ in range(_CLOSE_TICKS):
            yield
            if bench.sensed.held == target:
                break
        else:
            yield from self._give_up(grasp)
            raise SkillError("missed")
        away = self._off_the_wall(target, grasp.tip)
        yield from self._line(away, _FINE_SPEED, _FINE_ACCELERATION, checked=False)
        up = (*away[:2], grasp.tip[2] + _LIFT_M, away[3])
        yield from self._line(up, _FINE_SPEED, _FINE_ACCELERATION, checked=False)
        if bench.sensed.held != target or bench.panda.tracking_error() > TRACKING_LIMIT_RAD:
            yield from self._give_up(grasp)
            raise SkillError("not_lifted")
        self.carried = self._carried(target, grasp.width_m)
        self.reporter.leave_contact()

    def _off_the_wall(self, target: str, tip: TipPose) -> TipPose:
        """A thing that stands against the side of a fixture is drawn off it first, or it would turn in the hand."""
        e = self._state(target).extent
        x, y, z, yaw = self.approach.frame.to_world(tip)
        for f in self.scene.fixtures:
            if f.top_m < e.bottom_m + 0.005 or f.top_m - f.size_m[2] > e.top_m:
                continue
            gaps = [abs(e.centre[i] - f.xyz_m[i]) - e.half[i] - f.size_m[i] / 2 for i in (0, 1)]
            axis = 0 if gaps[0] > gaps[1] else 1
            if -0.005 < gaps[axis] < _WALL_GAP_M:
                side = math.copysign(_WALL_GAP_M - max(0.0, gaps[axis]), e.centre[axis] - f.xyz_m[axis])
                x, y = (x + side, y) if axis == 0 else (x, y + side)
                z = self.approach.frame.to_world(tip)[2] + 0.003
        return self.approach.frame.to_base(x, y, z, yaw)

    def _give_up(self, grasp: Grasp) -> Skill:
        """Open and withdraw, so that the hand is empty and clear of what it failed to take."""
        self.bench.panda.grip(grasp.opening_m)
        yield from self._wait(3)
        yield from self._up(0.10, _FINE_SPEED)
        yield from self._wait(2)

    def _askew(self, target: str) -> bool:
        """Whether the held thing is tilted, or its faces are not square to the fingers."""
        if self.bench.sensed.held != target:
            return False
        carried = self._carried(target, 0.0)
        round_ = self.bench.kinds[target].shape in ("cylinder", "sphere")
        return carried.tilted or (not round_ and abs(math.sin(carried.turn_rad)) > _ASKEW)

    def _tilted(self, target: str, state: BodyState) -> bool:
        match self.bench.kinds[target].shape:
            case "sphere":
                return False
            case "cylinder":
                up = abs(state.axes[2][2])
            case _:
                up = max(abs(u) for u in state.axes[2])
        return up < math.sqrt(1 - _ASKEW**2)

    def _carried(self, target: str, width_m: float) -> Carried:
        """How the held thing sits in the hand, as measured."""
        state = self._state(target)
        tx, ty, tz, yaw = self.approach.frame.to_world(self.bench.panda.tip())
        dx, dy = state.xyz[0] - tx, state.xyz[1] - ty
        c, s = math.cos(yaw), math.sin(yaw)
        turn = _flat_yaw(state) - yaw
        return Carried(
            id=target,
            along_m=c * dx + s * dy,
            across_m=-s * dx + c * dy,
            below_m=tz - state.xyz[2],
            bottom_below_tip_m=tz - state.extent.bottom_m,
            turn_rad=math.remainder(turn, math.pi / 2),
            width_m=width_m,
            tilted=self._tilted(target, state),
        )

    # ------------------------------------------------------------------ putting down

    def _put(self, target: str, place: str, for_: str | None) -> Skill:
        if self.bench.sensed.held != target:
            raise SkillError("not_holding", self.bench.sensed.held)
        carried = self.carried = self._carried(target, self.bench.panda.finger_gap())
        where = self.scene.place(place)
        (x, y), how = self._choose(carried, where, for_)
        yield from self._over(how.tip, target)
        carried = self.carried = self._carried(target, carried.width_m)
        how = self._still_free(carried, where, x, y, how)
        tip = (*how.tip[:2], how.tip[2] + _LET_GO_ABOVE_M, how.tip[3])
        yield from self._down(tip, target)
        yield from self._let_go(target, place, how)

    def _choose(self, carried: Carried, place: ScenePlace, for_: str | None) -> tuple[tuple[float, float], Grasp]:
        """Where on a place the thing goes, and how."""
        self._mirror(without=carried.id)
        yaws = self._yaws(carried, place)
        if place.surface_m is None:
            raise SkillError("no_surface")
        if place.is_slot:
            x, y = place.surface_m[0], place.surface_m[1]
            return (x, y), self._allowed(self.approach.let_go(carried, x, y, place.surface_m[2], yaws))
        found = self.approach.spot(carried, place, yaws, avoid=for_)
        if found is None or found[1].grasp is None:
            raise SkillError("no_free_buffer")
        return found[0], found[1].grasp

    def _still_free(self, carried: Carried, place: ScenePlace, x: float, y: float, how: Grasp) -> Grasp:
        """The plan for the last few centimetres, with the world and the hold as they are now."""
        assert place.surface_m is not None
        self._mirror(without=carried.id)
        yaw = how.tip[3] + self.scene.robot_yaw_rad
        return self._allowed(self.approach.let_go(carried, x, y, place.surface_m[2], [yaw]))

    @staticmethod
    def _allowed(verdict: Verdict) -> Grasp:
        if verdict.grasp is not None:
            return verdict.grasp
        if verdict.blocker is not None:
            raise SkillError("spot_occupied", verdict.blocker)
        raise SkillError("blocked" if verdict.reachable else "ik_unreachable")

    def _yaws(self, carried: Carried, place: ScenePlace) -> list[float]:
        """Yaws of the fingers that put a thing down square to the place, along its edge first on a slot."""
        edge = self._edge(place)
        square = [k * math.pi / 2 - carried.turn_rad for k in (0, 1)]
        if place.is_slot:
            return sorted(square, key=lambda y: abs(math.sin(y - edge)))
        tip = self.bench.panda.tip()
        middle = math.pi / 2 + math.atan2(tip[1], tip[0]) + self.scene.robot_yaw_rad
        return sorted(square, key=lambda y: round(abs(math.sin(y - middle)), 3))

    def _edge(self, place: ScenePlace) -> float:
        """The direction of the long side of what a slot belongs to: the fingers open along it, past the neighbours."""
        parent = self.scene.place(place.parent) if place.parent is not None else place
        return math.pi / 2 if parent.size_m[1] >= parent.size_m[0] else 0.0

    def _let_go(self, target: str, place: str, how: Grasp) -> Skill:
        self.reporter.enter_contact(target, (place,))
        bench = self.bench
        bench.panda.grip(how.opening_m)
        yield from self._wait(3)
        yield from self._up(0.07, _FINE_SPEED)
        on = Condition("On", (target, place))
        for _ in range(_SETTLE_TICKS):
            if on in self.facts() and not bench.sensed.touched:
                break
            yield
        self.carried = None
        self.reporter.leave_contact()
        if bench.sensed.touched:
            raise SkillError("not_let_go", bench.sensed.touched[0][0])
        if on not in self.facts():
            raise SkillError("unstable_after_release")

    # ------------------------------------------------------------------ motion

    def _arm_at_rest(self) -> Skill:
        """A skill may start while the arm still brakes."""
        while not self.bench.panda.arrived:
            yield

    def _wait(self, ticks: int) -> Skill:
        for _ in range(ticks):
            yield

    def _up(self, metres: float, speed: float) -> Skill:
        x, y, z, yaw = self.bench.panda.tip()
        yield from self._line((x, y, z + metres, yaw), speed, _FINE_ACCELERATION, checked=False)

    def _line(
        self,
        end: TipPose,
        speed: float,
        acceleration: float,
        *,
        carrying: str | None = None,
        checked: bool = True,
        until: int | None = None,
    ) -> Skill:
        """Along one line; ends at rest. With `carrying`, dropping it on the way is a failure at once. With `until`,
        the arm brakes and the line ends early when the count of the world's surprises is no more that."""
        panda = self.bench.panda
        if not _far(panda.tip(), end):
            return
        plan = plan_line(panda.tip(), end, speed, acceleration)
        if plan is None:
            raise SkillError("ik_unreachable")
        panda.follow(plan)
        while not panda.arrived:
            yield
            if carrying is not None and self.bench.sensed.held != carrying:
                panda.brake()
                raise SkillError("dropped_on_the_way")
            if panda.tracking_error() > _SILENT_BLOCK_RAD:
                panda.brake()
                raise SkillError("tracking_error")
            if until is not None and until != self.bench.surprises:
                panda.brake()
                return
        if checked and panda.tracking_error() > TRACKING_LIMIT_RAD:
            raise SkillError("tracking_error")

    def _over(self, end: TipPose, carrying: str | None) -> Skill:
        """Up to a height at which nothing is in the way, and over to above `end`. Planned anew when a thing that was
        not there, or not so, turns up on the way."""
        panda = self.bench.panda
        speed = (_CARRY_SPEED, _CARRY_ACCELERATION) if carrying else (_FREE_SPEED, _FREE_ACCELERATION)
        for _ in range(_REPLANS):
            seen = self.bench.surprises
            start, end = panda.tip(), (*end[:3], central_yaw(end[0], end[1], end[3]))
            height = self._travel_height(start, end, carrying)
            yield from self._line((*start[:2], height, start[3]), *speed, carrying=carrying, until=seen)
            if carrying is not None:
                self.transferring = carrying
            try:
                yield from self._line((*end[:2], height, end[3]), *speed, carrying=carrying, until=seen)
            finally:
                self.transferring = None
            if seen == self.bench.surprises:
                return
            yield from self._arm_at_rest()
        raise SkillError("blocked")

    def _travel_height(self, start: TipPose, end: TipPose, carrying: str | None) -> float:
        """The height of the tip (base frame) at which to go from one point to another."""
        needed = self._height(start, end, carrying)
        for clearance in (_CLEARANCE_M, 0.012):
            height = max(start[2], end[2] + _HEADROOM_M, needed + clearance)
            if all(solve_one((*p[:2], height, p[3])) is not None for p in (start, end)):
                return height
        raise SkillError("ik_unreachable")

    def _down(self, end: TipPose, carrying: str | None) -> Skill:
        """Straight down, the last centimetres slowly."""
        speed = (_CARRY_SPEED, _CARRY_ACCELERATION) if carrying else (_FREE_SPEED, _FREE_ACCELERATION)
        above = (*end[:2], end[2] + _HEADROOM_M, end[3])
        if self.bench.panda.tip()[2] > above[2] + _HEADROOM_M:
            yield from self._line(above, *speed, carrying=carrying)
        yield from self._line(end, _FINE_SPEED, _FINE_ACCELERATION, carrying=carrying)

    def _height(self, start: TipPose, end: TipPose, carrying: str | None) -> float:
        """The lowest tip (base frame) for which hand and load pass over everything between two points."""
        s = np.linspace(0.0, 1.0, 17)
        th0, th1 = math.atan2(start[1], start[0]), math.atan2(end[1], end[0])
        r0, r1 = math.hypot(*start[:2]), math.hypot(*end[:2])
        theta, r = th0 + s * (th1 - th0) + self.scene.robot_yaw_rad, r0 + s * (r1 - r0)
        x = r * np.cos(theta) + self.scene.robot_xyz_m[0]
        y = r * np.sin(theta) + self.scene.robot_xyz_m[1]
        top = -math.inf
        for cx, cy, hx, hy, z in self._tops(carrying):
            if bool(np.any((np.abs(x - cx) < hx + _CORRIDOR_M) & (np.abs(y - cy) < hy + _CORRIDOR_M))):
                top = max(top, z)
        below = FINGER_BELOW_TIP_M
        if carrying is not None and self.carried is not None:
            below = max(below, self.carried.bottom_below_tip_m)
        return top - self.scene.robot_xyz_m[2] + below

    def _tops(self, carrying: str | None) -> Iterator[tuple[float, float, float, float, float]]:
        for f in self.scene.fixtures:
            yield f.xyz_m[0], f.xyz_m[1], f.size_m[0] / 2, f.size_m[1] / 2, f.top_m
        for _, state in self.bench.others(carrying):
            e = state.extent
            yield e.centre[0], e.centre[1], e.half[0], e.half[1], e.top_m

    # ------------------------------------------------------------------ looking

    def _state(self, id_: str) -> BodyState:
        found = self.bench.sensed.states.get(id_)
        if found is None:
            raise SkillError("unknown_object")
        return found

    def _mirror(self, without: str | None = None) -> None:
        self.approach.mirror(self.bench.sensed.states, without=without)

    def _hand_clear(self) -> bool:
        """Whether the fingers may open or close where they are without touching anything."""
        return not self.bench.sensed.touched


def _far(a: TipPose, b: TipPose, metres: float = 1e-4) -> bool:
    return math.dist(a[:3], b[:3]) > metres or abs(math.sin(a[3] - b[3])) > 10 * metres


def _flat_yaw(state: BodyState) -> float:
    """The direction of a body's horizontal axis: whichever of its axes is flattest."""
    columns = [tuple(row[i] for row in state.axes) for i in (0, 1, 2)]
    flattest = min(columns, key=lambda c: (round(abs(c[2]), 3), c))
    return math.atan2(flattest[1], flattest[0])
