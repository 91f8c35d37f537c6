"""Upright boxes that may reach into each other: what overlaps in a scene at its start."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from llmbt_ir.geometry import Vec3, yaw_from_quat
from llmbt_ir.scene_model import PLATFORM_RADIUS_M, ROBOT_FOOTPRINT_M, Body, Fixture, RobotModel

__all__ = ["Solid", "overlaps", "robot_solid"]

Vec2 = tuple[float, float]

OVERLAP_M = 0.0005
"""Bodies that reach less deeply into each other than this count as touching."""


@dataclass(frozen=True, slots=True)
class Solid:
    """An upright box, turned about the vertical."""

    label: str
    xyz_m: Vec3
    size_m: Vec3
    yaw_rad: float

    def axes(self) -> tuple[Vec2, Vec2]:
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return (c, s), (-s, c)

    def reach(self, axis: Vec2) -> float:
        """Half of the extent along a horizontal direction."""
        u, v = self.axes()
        return (
            abs(u[0] * axis[0] + u[1] * axis[1]) * self.size_m[0] / 2
            + abs(v[0] * axis[0] + v[1] * axis[1]) * self.size_m[1] / 2
        )

    def overlaps(self, other: Solid) -> bool:
        """Separating axes in the plane, and the heights."""
        dz = abs(self.xyz_m[2] - other.xyz_m[2])
        if dz > (self.size_m[2] + other.size_m[2]) / 2 - OVERLAP_M:
            return False
        dx, dy = self.xyz_m[0] - other.xyz_m[0], self.xyz_m[1] - other.xyz_m[1]
        return all(
            abs(dx * a[0] + dy * a[1]) < self.reach(a) + other.reach(a) - OVERLAP_M
            for a in (*self.axes(), *other.axes())
        )


def robot_solid(xyz_m: Vec3, model: RobotModel) -> Solid:
    """The robot's base, with the platform below it."""
    below = xyz_m[2] if model is RobotModel.MOBILE_PANDA else 0.0
    height = ROBOT_FOOTPRINT_M[2] + below
    size = (2 * PLATFORM_RADIUS_M, 2 * PLATFORM_RADIUS_M) if below else ROBOT_FOOTPRINT_M[:2]
    x, y, z = xyz_m
    return Solid("the robot", (x, y, z - below + height / 2), (*size, height), 0.0)


def overlaps(
    fixtures: Iterable[Fixture], objects: Iterable[Body], robot_xyz_m: Vec3, model: RobotModel
) -> Iterator[tuple[Body, str]]:
    """The objects that reach into the robot, a fixture or an object before them, each with what it reaches into."""
    solids = [robot_solid(robot_xyz_m, model)]
    solids += [Solid(f"`{f.id}`", f.xyz_m, f.size_m, 0.0) for f in fixtures]
    for o in objects:
        if o.pose is None:
            continue
        solid = Solid(f"`{o.id}`", o.pose.xyz_m, o.size_m, yaw_from_quat(o.pose.quat_xyzw))
        yield from ((o, other.label) for other in solids if solid.overlaps(other))
        solids.append(solid)
