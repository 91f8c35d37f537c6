"""Driving: over the floor to a docking pose, or to where a thing can be reached. Generators, resumed once a tick."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Generator
from dataclasses import dataclass, field

import numpy as np

from llmbt_ir.scene import ScenePlace
from llmbt_runtime.bullet.arm import Arm, Skill, SkillError
from llmbt_runtime.bullet.base_conditions import BaseConditions, is_near
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.judging import Judge
from llmbt_runtime.bullet.motion import straight
from llmbt_runtime.bullet.navigation import Floor, Footprint, Point
from llmbt_runtime.bullet.reporting import Reporter
from llmbt_runtime.bullet.terrain import Terrain

__all__ = ["Driver"]

_Goals = Callable[[], tuple[BasePose, ...]]
_Followed = Generator[None, None, bool]

_SPEED_M_S, _ACCELERATION_M_S2 = 1.2, 1.4
_TURN_RAD_S, _TURN_RAD_S2 = 1.6, 2.5
_PEAK_SPEED, _PEAK_ACCELERATION = 1.875, 5.7735
"""Of the quintic from 0 to 1 in unit time."""
_TUCKED_M = (0.45, 0.0, 0.10)
_TUCKED_HEIGHT_M = 0.48
"""While it drives, the hand is this far before the base and so high, so that what is dropped falls beside it."""
_REPLANS = 6
_OFF_COURSE_M = 0.01
_ASIDE_M, _ASIDE_ROOM_M = 0.55, 0.05
_TURNS = tuple(k * math.pi / 8 * side for k in range(2, 7) for side in (1, -1))
"""Directions from the robot in which a thing is put aside, to its left and right before behind it."""


@dataclass
class Driver:
    """Drives the base of a bench. For a robot that is bolted down every drive is over before it begins."""

    arm: Arm
    terrain: Terrain
    judge: Judge
    conditions: BaseConditions
    reporter: Reporter
    _seen: Floor | None = field(default=None)
    _done: float = 0.0
    _leg: float = 0.0

    def __post_init__(self) -> None:
        self.bench = self.arm.bench

    @property
    def drives(self) -> bool:
        """Whether the robot has wheels."""
        return self.terrain.drives

    def come_to_rest(self) -> Skill:
        """A skill may start while arm and base still brake."""
        while not self.bench.base.arrived:
            yield
        yield from self.arm.come_to_rest()

    def navigate(self, place: str) -> Skill:
        """To the docking pose of a place that is the nearest by the way there is; planned anew when that is blocked."""
        yield from self.come_to_rest()
        docks = self.terrain.docks[place]
        if any(is_near(self.bench.base.pose, d) for d in docks):
            return
        yield from self._drive(lambda: self.terrain.docks[place])

    def face(self, target: str, place: str | None) -> Skill:
        """To where a thing can be taken from: where the robot stands, unless something is in the way of the arm.

        With a place, the robot stays at it by all that is told of it: it goes from one of its docking poses to another.
        """
        if not self.drives:
            return
        sensed = self.bench.sensed
        if target not in sensed.states:
            raise SkillError("unknown_object")
        on = frozenset({place}) if place is not None else frozenset()
        if place is not None and self.judge.can_take(target, sensed, self.bench.base.pose):
            return
        pose = self.judge.pose_to_take(target, sensed, on)
        if pose is None:
            raise SkillError("not_approachable", self.judge.blocker_of(target))
        if place is not None:
            self.reporter.hold_near(place)
        yield from self._drive(lambda: (pose,))

    def floor_around(self, location: str, obstacle: str) -> ScenePlace:
        """A region of the floor around the robot where an obstacle may be put so that there is a way to a location.

        no_free_buffer where there is none.
        """
        x, y, yaw = self.bench.base.pose.x_m, self.bench.base.pose.y_m, self.bench.base.pose.yaw_rad
        body, sensed = self.bench.kinds[obstacle], self.bench.sensed
        floor = self.terrain.floor(sensed.states, obstacle).without(obstacle)
        here = (x, y)
        size = 2 * (math.hypot(*body.size_m[:2]) / 2 + _ASIDE_ROOM_M)
        for turn in _TURNS:
            angle = yaw + turn
            at = (x + _ASIDE_M * math.cos(angle), y + _ASIDE_M * math.sin(angle))
            there = Footprint(obstacle, at, (size / 2, size / 2), 0.0, body.size_m[2])
            if floor.bare(there) and self._leads_on(floor.with_(there), here, location):
                return ScenePlace("floor", "the floor", "region", surface_m=(*at, 0.0), size_m=(size, size))
        raise SkillError("no_free_buffer")

    def _leads_on(self, floor: Floor, here: Point, location: str) -> bool:
        return any(floor.connected(here, (d.x_m, d.y_m)) for d in self.terrain.docks[location])

    # -- the base -------------------------------------------------------------------------------------------------

    def _drive(self, goals: _Goals) -> Skill:
        """Over the floor to one of some poses."""
        carrying = self.bench.sensed.held
        yield from self._tuck(carrying)
        self._seen = None
        self.arm.transferring, self.arm.share = carrying, self._share
        try:
            yield from self._to_one_of(goals, carrying)
        finally:
            self.arm.transferring, self.arm.share = None, self.arm.of_motion

    def _share(self) -> float:
        """How much of the way has been gone."""
        return self._done + self._leg * self.bench.base.progress

    def _to_one_of(self, goals: _Goals, carrying: str | None) -> Skill:
        for _ in range(_REPLANS):
            route, pose = self._route(goals())
            if (yield from self._follow(route, pose, carrying, goals)):
                return
        raise SkillError("blocked")

    def _tuck(self, carrying: str | None) -> Skill:
        """The hand before the base, high enough to pass over tables."""
        x, y, z = _TUCKED_M
        tip = self.bench.panda.tip()
        if math.hypot(tip[0] - x, tip[1] - y) > 0.02:
            yield from self.arm.over((x, y, z, math.pi / 2), carrying)
        tip = self.bench.panda.tip()
        if tip[2] < _TUCKED_HEIGHT_M:
            yield from self.arm.line((*tip[:2], _TUCKED_HEIGHT_M, tip[3]), 1.6, 5.0, carrying=carrying)

    def _route(self, poses: tuple[BasePose, ...]) -> tuple[list[Point], BasePose]:
        sensed = self.bench.sensed
        floor = self.terrain.floor(sensed.states, sensed.held)
        here = (self.bench.base.pose.x_m, self.bench.base.pose.y_m)
        ways = ((floor.route(here, (p.x_m, p.y_m)), p) for p in poses)
        found = [(_length(way), k, way, p) for k, (way, p) in enumerate(ways) if way is not None]
        if not found:
            raise SkillError("no_path", self._in_the_way(floor, here, poses))
        _, _, way, pose = min(found, key=lambda f: (round(f[0], 3), f[1]))
        return way, pose

    def _in_the_way(self, floor: Floor, here: Point, poses: tuple[BasePose, ...]) -> str | None:
        sensed = self.bench.sensed
        for id_ in sorted(self.terrain.floor_bodies(sensed.states, sensed.held)):
            rest = floor.without(id_)
            if any(rest.connected(here, (p.x_m, p.y_m)) for p in poses):
                return id_
        return None

    def _follow(self, route: list[Point], pose: BasePose, carrying: str | None, goals: _Goals) -> _Followed:
        """Along a route, turning on the way; False where something turned up in front, the base at rest again."""
        base = self.bench.base
        start, total = base.pose, _length(route)
        turn = math.remainder(pose.yaw_rad - start.yaw_rad, 2 * math.pi)
        done = 0.0
        for a, b in itertools.pairwise(route):
            leg = math.dist(a, b)
            share = leg / total if total > 1e-9 else 1.0 / (len(route) - 1)
            first, last = start.yaw_rad + done * turn, start.yaw_rad + (done + share) * turn
            self._done, self._leg = done, share
            done += share
            if leg < 1e-6 and abs(last - first) < 1e-6:
                continue
            base.follow(straight(np.array([*a, first]), np.array([*b, last]), _seconds(leg, abs(last - first))))
            while not base.arrived:
                yield
                if carrying is not None and self.bench.sensed.held != carrying:
                    base.brake()
                    raise SkillError("dropped_on_the_way")
                if pose not in goals() or not self._clear_ahead(b, pose):
                    base.brake()
                    while not base.arrived:
                        yield
                    return False
        for _ in range(2):
            yield
        if base.measured().far_from(base.pose)[0] > _OFF_COURSE_M:
            raise SkillError("tracking_error")
        return True

    def _clear_ahead(self, corner: Point, pose: BasePose) -> bool:
        """Whether the rest of a leg is still free, and the pose at the end of the route."""
        sensed, base = self.bench.sensed, self.bench.base.pose
        floor = self.terrain.floor(sensed.states, sensed.held)
        if floor is self._seen:
            return True
        if floor.sees((base.x_m, base.y_m), corner) and floor.stands((pose.x_m, pose.y_m)):
            self._seen = floor
            return True
        return False


def _length(way: list[Point]) -> float:
    return sum(math.dist(a, b) for a, b in itertools.pairwise(way))


def _seconds(metres: float, radians: float) -> float:
    """How long a leg takes, at rest at both ends."""
    return max(
        _PEAK_SPEED * metres / _SPEED_M_S,
        math.sqrt(_PEAK_ACCELERATION * metres / _ACCELERATION_M_S2),
        _PEAK_SPEED * radians / _TURN_RAD_S,
        math.sqrt(_PEAK_ACCELERATION * radians / _TURN_RAD_S2),
        0.1,
    )
