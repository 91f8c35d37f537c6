"""Shapes and states of movable bodies: extents, which way up, how fast. World frame, metres, seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass

from llmbt_ir.geometry import Pose, Quat, Vec3, quat_from_yaw
from llmbt_ir.scene import Body

__all__ = ["AT_REST_M_S", "BodyState", "Extent", "extent_of", "lying_at", "overlap"]

AT_REST_M_S = 0.01
AT_REST_RAD_S = 0.3
_UPRIGHT = math.cos(math.radians(10))
_STILL_UPRIGHT = math.cos(math.radians(20))


@dataclass(frozen=True, slots=True)
class Extent:
    """An axis-aligned bounding box in the world: centre and half extents."""

    centre: Vec3
    half: Vec3

    @property
    def top_m(self) -> float:
        """Height of its upper face."""
        return self.centre[2] + self.half[2]

    @property
    def bottom_m(self) -> float:
        """Height of its lower face."""
        return self.centre[2] - self.half[2]

    def gap_xy(self, other: Extent) -> float:
        """The larger of the gaps in x and in y; negative where they overlap seen from above."""
        return max(abs(self.centre[i] - other.centre[i]) - self.half[i] - other.half[i] for i in (0, 1))


def overlap(a: Extent, b: Extent, slack_m: float = 0.0) -> bool:
    """Whether two bounding boxes reach into each other by more than `slack_m` on every axis."""
    return all(abs(a.centre[i] - b.centre[i]) < a.half[i] + b.half[i] - slack_m for i in (0, 1, 2))


@dataclass(frozen=True, slots=True)
class BodyState:
    """Where a body is and how fast. `axes` are the rows of its rotation matrix: world from body."""

    xyz: Vec3
    quat: Quat
    axes: tuple[Vec3, Vec3, Vec3]
    speed: float
    spin: float
    extent: Extent

    @property
    def at_rest(self) -> bool:
        """Slower than a centimetre a second, and not turning."""
        return self.speed < AT_REST_M_S and self.spin < AT_REST_RAD_S

    @property
    def pose(self) -> Pose:
        """Position and orientation."""
        return Pose(self.xyz, self.quat)

    def moved_from(self, other: BodyState) -> bool:
        """Whether it has moved by more than 2 mm or about 2 degrees."""
        if any(abs(a - b) > 0.002 for a, b in zip(self.xyz, other.xyz, strict=True)):
            return True
        return abs(sum(a * b for a, b in zip(self.quat, other.quat, strict=True))) < 0.99985

    def upright(self, shape: str, *, still: bool = False) -> bool:
        """Whether a face of a box, or an end of a cylinder, points up within 10 degrees (20 to stay so)."""
        limit = _STILL_UPRIGHT if still else _UPRIGHT
        up = self.axes[2]
        if shape == "sphere":
            return True
        if shape == "cylinder":
            return abs(up[2]) > limit
        return max(abs(u) for u in up) > limit


def extent_of(body: Body, xyz: Vec3, axes: tuple[Vec3, Vec3, Vec3]) -> Extent:
    """The bounding box of a body at a pose."""
    sx, sy, sz = body.size_m
    if body.shape == "sphere":
        half = (sx / 2, sx / 2, sx / 2)
    elif body.shape == "cylinder":
        half = _triple([abs(r[2]) * sz / 2 + math.sqrt(max(0.0, 1 - r[2] * r[2])) * sx / 2 for r in axes])
    else:
        half = _triple([(abs(r[0]) * sx + abs(r[1]) * sy + abs(r[2]) * sz) / 2 for r in axes])
    return Extent(xyz, half)


def lying_at(body: Body, xyz: Vec3, yaw_rad: float) -> BodyState:
    """A body at rest with its own z up, turned about it."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    axes = ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))
    return BodyState(xyz, quat_from_yaw(yaw_rad), axes, 0.0, 0.0, extent_of(body, xyz, axes))


def _triple(values: list[float]) -> Vec3:
    x, y, z = values
    return x, y, z
