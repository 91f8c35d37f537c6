"""The motions of the arm that skills are made of: generators that are resumed once a tick."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field

import numpy as np

from llmbt_ir.condition import Condition
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.bench import Bench
from llmbt_runtime.bullet.grasping import FINGER_BELOW_TIP_M, Carried
from llmbt_runtime.bullet.kinematics import TipPose, central_yaw, solve_one
from llmbt_runtime.bullet.motion import Trajectory, plan_line
from llmbt_runtime.bullet.planning import plan_tip
from llmbt_runtime.bullet.stage import Stage

__all__ = ["FINE_ACCELERATION", "FINE_SPEED", "TRACKING_LIMIT_RAD", "Arm", "Skill", "SkillError", "far"]

Skill = Generator[None, None, None]

TRACKING_LIMIT_RAD = 0.02
FINE_SPEED, FINE_ACCELERATION = 0.9, 4.0
_SILENT_BLOCK_RAD = 0.08
_FREE_SPEED, _FREE_ACCELERATION = 1.9, 7.0
_CARRY_SPEED, _CARRY_ACCELERATION = 1.6, 5.0
_CLEARANCE_M = 0.03
_CORRIDOR_M = 0.13
_HEADROOM_M = 0.04
_REPLANS = 4
_CHECKED_ROWS, _HIGHER_TRIED = 5, 4


class SkillError(Exception):
    """A skill cannot go on. `blocker` is the body in the way, where there is one; `denies` a fact that does not hold
    after all, until something moves: the skill has looked more closely."""

    def __init__(self, reason: str, blocker: str | None = None, *, denies: Condition | None = None) -> None:
        super().__init__(reason)
        self.reason, self.blocker, self.denies = reason, blocker, denies


@dataclass
class Arm:
    """Moves the arm of a bench. `carried` is how what is held sits in the hand; `transferring` is the thing that is
    being carried over, while it is, and `share` how far it has come."""

    stage: Stage
    bench: Bench
    approach: Approach
    carried: Carried | None = field(default=None)
    transferring: str | None = field(default=None)
    share: Callable[[], float] = field(default=lambda: 0.0)

    def __post_init__(self) -> None:
        self.share = self.of_motion

    def of_motion(self) -> float:
        """How much of the running motion has been commanded."""
        return self.bench.panda.progress

    def come_to_rest(self) -> Skill:
        """A skill may start while the arm still brakes."""
        while not self.bench.panda.arrived:
            yield

    def wait(self, ticks: int) -> Skill:
        for _ in range(ticks):
            yield

    def up(self, metres: float, speed: float) -> Skill:
        x, y, z, yaw = self.bench.panda.tip()
        yield from self.line((x, y, z + metres, yaw), speed, FINE_ACCELERATION, checked=False)

    def line(
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
        if not far(panda.tip(), end):
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

    def over(self, end: TipPose, carrying: str | None) -> Skill:
        """Up to a height at which nothing is in the way, and over to above `end`. Planned anew when a thing that was
        not there, or not so, turns up on the way."""
        panda = self.bench.panda
        speed = (_CARRY_SPEED, _CARRY_ACCELERATION) if carrying else (_FREE_SPEED, _FREE_ACCELERATION)
        for _ in range(_REPLANS):
            seen = self.bench.surprises
            start, end = panda.tip(), (*end[:3], central_yaw(end[0], end[1], end[3]))
            height = self._travel_height(start, end, carrying)
            if height is None:
                yield from self._round(start, end, carrying, speed)
                return
            yield from self.line((*start[:2], height, start[3]), *speed, carrying=carrying, until=seen)
            if carrying is not None:
                self.transferring = carrying
            try:
                yield from self.line((*end[:2], height, end[3]), *speed, carrying=carrying, until=seen)
            finally:
                self.transferring = None
            if seen == self.bench.surprises:
                return
            yield from self.come_to_rest()
        raise SkillError("blocked")

    def _round(self, start: TipPose, end: TipPose, carrying: str | None, speed: tuple[float, float]) -> Skill:
        """To above `end` by a way that was searched for, where none leads over everything. A part of it is no line of
        its own: what turns up on the way halts it as a motion that is blocked."""
        self.approach.stand_at(self.bench.base.pose)
        self.approach.mirror(self.bench.sensed.states, without=carrying)
        carried, opening = (self.carried if carrying is not None else None), self.bench.panda.finger_gap()

        def free_at(tip: TipPose) -> bool:
            q = solve_one(tip)
            return q is not None and self.approach.is_free(q, opening, carried)

        def free(motion: Trajectory) -> bool:
            return self.approach.free_along(motion.q[::_CHECKED_ROWS], opening, carried)

        if not free_at(start):
            raise SkillError("start_in_collision")
        above = [(*end[:2], end[2] + _HEADROOM_M + k * 0.03, end[3]) for k in range(_HIGHER_TRIED)]
        goal = next((tip for tip in above if free_at(tip)), None)
        if goal is None:
            raise SkillError("goal_in_collision")
        way = plan_tip(start, goal, free_at, free)
        if way is None:
            raise SkillError("no_plan")
        seen = self.bench.surprises
        for corner in way:
            yield from self.line(corner, *speed, carrying=carrying, until=seen)
            if seen != self.bench.surprises:
                yield from self.come_to_rest()
                raise SkillError("blocked")

    def _travel_height(self, start: TipPose, end: TipPose, carrying: str | None) -> float | None:
        """The height of the tip (base frame) at which to go from one point to another; None where that is too high."""
        needed = self._height(start, end, carrying)
        for clearance in (_CLEARANCE_M, 0.012):
            height = max(start[2], end[2] + _HEADROOM_M, needed + clearance)
            if all(solve_one((*p[:2], height, p[3])) is not None for p in (start, end)):
                return height
        return None

    def down(self, end: TipPose, carrying: str | None) -> Skill:
        """Straight down, the last centimetres slowly."""
        speed = (_CARRY_SPEED, _CARRY_ACCELERATION) if carrying else (_FREE_SPEED, _FREE_ACCELERATION)
        above = (*end[:2], end[2] + _HEADROOM_M, end[3])
        if self.bench.panda.tip()[2] > above[2] + _HEADROOM_M:
            yield from self.line(above, *speed, carrying=carrying)
        yield from self.line(end, FINE_SPEED, FINE_ACCELERATION, carrying=carrying)

    def _height(self, start: TipPose, end: TipPose, carrying: str | None) -> float:
        """The lowest tip (base frame) for which hand and load pass over everything between two points."""
        s = np.linspace(0.0, 1.0, 17)
        th0, th1 = math.atan2(start[1], start[0]), math.atan2(end[1], end[0])
        r0, r1 = math.hypot(*start[:2]), math.hypot(*end[:2])
        base = self.bench.base.pose
        theta, r = th0 + s * (th1 - th0) + base.yaw_rad, r0 + s * (r1 - r0)
        x = r * np.cos(theta) + base.x_m
        y = r * np.sin(theta) + base.y_m
        top, corridor = -math.inf, self._corridor(carrying)
        for cx, cy, hx, hy, z in self._tops(carrying):
            if bool(np.any((np.abs(x - cx) < hx + corridor) & (np.abs(y - cy) < hy + corridor))):
                top = max(top, z)
        below = FINGER_BELOW_TIP_M
        if carrying is not None and self.carried is not None:
            below = max(below, self.carried.bottom_below_tip_m)
        return top - base.z_m + below

    def _corridor(self, carrying: str | None) -> float:
        """How far to either side of its path hand and load reach."""
        if carrying is None or carrying not in self.bench.sensed.states:
            return _CORRIDOR_M
        return max(_CORRIDOR_M, *self.bench.sensed.states[carrying].extent.half[:2])

    def _tops(self, carrying: str | None) -> Iterator[tuple[float, float, float, float, float]]:
        for f in self.stage.scene.fixtures:
            yield f.xyz_m[0], f.xyz_m[1], f.size_m[0] / 2, f.size_m[1] / 2, f.top_m
        for _, state in self.bench.others(carrying):
            e = state.extent
            yield e.centre[0], e.centre[1], e.half[0], e.half[1], e.top_m


def far(a: TipPose, b: TipPose, metres: float = 1e-4) -> bool:
    """Whether two tip poses are further apart than so, or turned against each other."""
    return math.dist(a[:3], b[:3]) > metres or abs(math.sin(a[3] - b[3])) > 10 * metres
