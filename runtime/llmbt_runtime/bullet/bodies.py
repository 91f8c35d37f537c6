"""Shapes and states of movable bodies: extents, which way up, how fast. World frame, metres, seconds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from llmbt_ir.geometry import Pose, Quat, Vec3, quat_from_yaw
from llmbt_ir.scene import Body

__all__ = ["AT_REST_M_S", "Axes", "BodyState", "Extent", "any_moved", "at_rest", "extent_of", "lying_at", "overlap"]

AT_REST_M_S = 0.01
AT_REST_RAD_S = 0.3
Axes = tuple[Vec3, Vec3, Vec3]
"""The rows of a rotation matrix: world from body."""
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
    axes: Axes
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


def any_moved(now: Mapping[str, BodyState], before: Mapping[str, BodyState]) -> bool:
    """Whether a body has moved, come or gone."""
    return now.keys() != before.keys() or any(s.moved_from(before[id_]) for id_, s in now.items())


def extent_of(body: Body, xyz: Vec3, axes: Axes) -> Extent:
    """The bounding box of a body at a pose."""
    sx, sy, sz = body.size_m
    if body.shape == "sphere":
        half = (sx / 2, sx / 2, sx / 2)
    elif body.shape == "cylinder":
        half = _triple([abs(r[2]) * sz / 2 + math.sqrt(max(0.0, 1 - r[2] * r[2])) * sx / 2 for r in axes])
    else:
        half = _triple([(abs(r[0]) * sx + abs(r[1]) * sy + abs(r[2]) * sz) / 2 for r in axes])
    return Extent(xyz, half)


def at_rest(body: Body, xyz: Vec3, axes: Axes) -> BodyState:
    """A body that does not move."""
    return BodyState(xyz, _quat_of(axes), axes, 0.0, 0.0, extent_of(body, xyz, axes))


def _quat_of(r: Axes) -> Quat:
    """The quaternion of a rotation matrix; the branch is the one whose divisor is largest."""
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = (1 + 2 * r[0][0] - trace, 1 + 2 * r[1][1] - trace, 1 + 2 * r[2][2] - trace, 1 + trace)
    k = max(range(4), key=lambda i: squares[i])
    big = math.sqrt(max(squares[k], 0.0)) / 2
    d = 1 / (4 * big)
    skew = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1])
    if k == 3:
        return skew[0] * d, skew[1] * d, skew[2] * d, big
    q = [(r[i][k] + r[k][i]) * d for i in (0, 1, 2)]
    q[k] = big
    return q[0], q[1], q[2], skew[k] * d


def lying_at(body: Body, xyz: Vec3, yaw_rad: float) -> BodyState:
    """A body at rest with its own z up, turned about it."""
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    axes = ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))
    return BodyState(xyz, quat_from_yaw(yaw_rad), axes, 0.0, 0.0, extent_of(body, xyz, axes))


def _triple(values: list[float]) -> Vec3:
    x, y, z = values
    return x, y, z
