"""Poses and boxes. Metres and radians; quaternions are (x, y, z, w); the frame is named where it is not `world`."""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["IDENTITY_QUAT", "Box", "Pose", "Viewpoint", "quat_from_yaw", "yaw_from_quat"]

IDENTITY_QUAT = (0.0, 0.0, 0.0, 1.0)
Vec3 = tuple[float, float, float]
Quat = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Pose:
    """Position of a body's centre and its orientation, in the world frame unless said otherwise."""

    xyz_m: Vec3
    quat_xyzw: Quat = IDENTITY_QUAT


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """Who looks, from where (world frame), and with what heading about the vertical: 0 looks along x, with y to the
    left."""

    of: str = "robot"
    xyz_m: Vec3 = (0.0, 0.0, 0.0)
    yaw_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class Box:
    """An axis-aligned box: centre and full extents."""

    centre_m: Vec3
    size_m: Vec3

    def contains_xy(self, x: float, y: float, margin_m: float = 0.0) -> bool:
        """Whether a point seen from above lies in the box, shrunk by `margin_m` on every side."""
        dx, dy = abs(x - self.centre_m[0]), abs(y - self.centre_m[1])
        return dx <= self.size_m[0] / 2 - margin_m and dy <= self.size_m[1] / 2 - margin_m


def quat_from_yaw(yaw_rad: float) -> Quat:
    """The rotation about the vertical axis."""
    return (0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2))


def yaw_from_quat(quat_xyzw: Quat) -> float:
    """The heading of a rotation, in (-pi, pi]."""
    x, y, z, w = quat_xyzw
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
