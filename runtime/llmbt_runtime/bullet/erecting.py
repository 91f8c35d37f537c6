"""Setting a cylinder upright that lies in the hand: the hand is pitched back towards the base until it stands.

A lying cylinder is taken from above, the fingers across it. Pitched by nearly a quarter turn about the line through the
fingers, the hand points back to the base with the wrist above it, and the cylinder's axis points down; it is set onto
its rim and rights itself when it is let go. All in the plane of the arm, in closed form (`kinematics.solve_pitched`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from llmbt_ir.condition import Condition
from llmbt_ir.scene import Body, ScenePlace
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.arm import Arm, Skill, SkillError
from llmbt_runtime.bullet.bodies import BodyState, lying_at
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.grasping import Carried
from llmbt_runtime.bullet.kinematics import TipPose, solve_pitched
from llmbt_runtime.bullet.motion import plan_pitched
from llmbt_runtime.bullet.spots import free_spots

__all__ = ["UPRIGHT_M", "Erector", "Upright", "can_stand_at", "lies"]

_LEANS_RAD = tuple(math.radians(a) for a in (4, 8, 12, 16, 20, 24, 28))
"""How far the cylinder leans when it is let go: the least for which the wrist is clear of what is below it."""
_RIGHTS_ITSELF = 0.7
"""It may lean by this part of the angle at which it would fall over."""
_BACK_M, _UP_M, _OPEN_M = 0.09, 0.12, 0.012
_DROP_M = 0.002
UPRIGHT_M = (0.26, 0.44)
"""How far from the base a cylinder is set upright."""
_SPOTS_TRIED = 12
_LOADED, _EMPTY = (1.2, 3.5), (1.9, 7.0)
"""Radians a second, and a second squared."""
Plane = tuple[float, float, float]
"""Radius and height of the tip (base frame), and the pitch of the hand."""


@dataclass(frozen=True, slots=True)
class Upright:
    """How a cylinder is set upright: where the arm's plane stands, and the way of the tip in it."""

    theta_rad: float
    over: Plane
    pitched: Plane
    down: Plane
    back: Plane
    away: Plane
    opening_m: float

    def poses(self) -> tuple[Plane, ...]:
        """Where the arm must be free of everything else."""
        return self.pitched, self.down, self.back, self.away


def can_stand_at(base: BasePose, spot: tuple[float, float]) -> bool:
    """Whether a spot is at a distance at which a cylinder is set upright."""
    return UPRIGHT_M[0] <= math.hypot(spot[0] - base.x_m, spot[1] - base.y_m) <= UPRIGHT_M[1]


def lies(body: Body, state: BodyState) -> bool:
    """Whether a thing is a cylinder on its side."""
    return body.shape == "cylinder" and abs(state.axes[2][2]) < 0.5


@dataclass
class Erector:
    """Plans and moves for one arm."""

    arm: Arm
    approach: Approach

    def plan(self, carried: Carried, body: Body, place: ScenePlace) -> Upright:
        """How to set the held cylinder upright on a place. no_room_upright where there is none at such a distance from
        the base, ik_unreachable."""
        base = self.arm.bench.base.pose
        any_room = False
        for x, y in self._spots(place, body):
            any_room = True
            assert place.surface_m is not None
            bx, by, bz, _ = base.to_base(x, y, place.surface_m[2], 0.0)
            for lean in _LEANS_RAD:
                if lean > _RIGHTS_ITSELF * math.atan2(body.size_m[0], body.size_m[2]):
                    break
                how = _ways(carried, body, math.atan2(by, bx), math.hypot(bx, by), bz, lean)
                standing = lying_at(body, (x, y, place.surface_m[2] + body.size_m[2] / 2 + 0.001), 0.0)
                if self._possible(how) and self.approach.fits(body.id, standing):
                    return how
        free = Condition("Free", (place.id,))
        raise SkillError("ik_unreachable" if any_room else "no_room_upright", denies=free)

    def _spots(self, place: ScenePlace, body: Body) -> Iterator[tuple[float, float]]:
        if place.surface_m is None:
            return
        base, bench = self.arm.bench.base.pose, self.arm.bench
        if place.is_slot:
            yield place.surface_m[:2]
            return
        half = body.size_m[0] / 2
        lying = [s.extent for _, s in bench.others(body.id)]
        spots = free_spots(place, (half, half), lying, self.arm.stage.scene.fixtures, base)
        near = [p for p in spots if can_stand_at(base, p)]
        yield from near[:_SPOTS_TRIED]

    def _possible(self, how: Upright) -> bool:
        joints = []
        for pose in (how.over, *how.poses()):
            r, z, pitch = (np.array([v]) for v in pose)
            q = solve_pitched(r, z, pitch, how.theta_rad)[0]
            if np.isnan(q[0]):
                return False
            joints.append(q)
        return not any(self.approach.touches(q, how.opening_m) for q in joints[1:])

    def set_upright(self, how: Upright) -> Skill:
        """From above the spot: pitch, set down, let go, withdraw, and the hand upright again."""
        yield from self._along(how, how.over, how.pitched)
        yield from self._along(how, how.pitched, how.down)
        panda = self.arm.bench.panda
        panda.grip(how.opening_m)
        yield from self.arm.wait(5)
        yield from self._along(how, how.down, how.back)
        yield from self._along(how, how.back, how.away)
        yield from self._along(how, how.away, (how.away[0], how.away[1], 0.0), _EMPTY)

    def _along(self, how: Upright, start: Plane, end: Plane, speed: tuple[float, float] = _LOADED) -> Skill:
        panda = self.arm.bench.panda
        plan = plan_pitched(how.theta_rad, start, end, *speed)
        if plan is None:
            raise SkillError("ik_unreachable")
        panda.follow(plan)
        while not panda.arrived:
            yield

    @staticmethod
    def above(how: Upright) -> TipPose:
        """Where the tip has to be before it begins: the hand still vertical."""
        r, z, _ = how.over
        return r * math.cos(how.theta_rad), r * math.sin(how.theta_rad), z, how.theta_rad + math.pi / 2


def _ways(carried: Carried, body: Body, theta: float, r: float, surface_m: float, lean: float) -> Upright:
    """The way of the tip for a cylinder that is to stand at radius `r` on a surface (base frame)."""
    pitch = lean - math.pi / 2
    out, down = (math.cos(pitch), math.sin(pitch)), (math.sin(pitch), -math.cos(pitch))  # radius, height
    length, radius = body.size_m[2], body.size_m[0] / 2
    beyond, below = -carried.across_m, carried.below_m
    height = surface_m + length / 2 * math.cos(lean) + radius * math.sin(lean) + _DROP_M
    tip_r = r - beyond * out[0] - below * down[0]
    tip_z = height - beyond * out[1] - below * down[1]
    high = tip_z + length / 2 + abs(beyond) + 0.03
    back_r, back_z = tip_r - _BACK_M * down[0], tip_z - _BACK_M * down[1]
    return Upright(
        theta,
        (tip_r, high, 0.0),
        (tip_r, high, pitch),
        (tip_r, tip_z, pitch),
        (back_r, back_z, pitch),
        (back_r, back_z + _UP_M, pitch),
        carried.width_m + 2 * _OPEN_M,
    )
