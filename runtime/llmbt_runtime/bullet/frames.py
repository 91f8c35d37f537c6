"""Where the base of the arm stands, and poses of the tip seen from it. Metres, radians."""

from __future__ import annotations

import math
from dataclasses import dataclass

from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Scene
from llmbt_runtime.bullet.kinematics import TipPose

__all__ = ["BasePose"]


@dataclass(frozen=True, slots=True)
class BasePose:
    """The frame of the arm's base in the world: on a platform, z_m is the platform's height."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float

    @classmethod
    def of_scene(cls, scene: Scene) -> BasePose:
        """Where the robot stands at the start."""
        return cls(*scene.robot_xyz_m, scene.robot_yaw_rad)

    @property
    def xyz_m(self) -> Vec3:
        """The origin of the frame."""
        return self.x_m, self.y_m, self.z_m

    def to_base(self, x: float, y: float, z: float, yaw: float) -> TipPose:
        """A tip pose of the world in the frame of the base."""
        dx, dy = x - self.x_m, y - self.y_m
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return (c * dx + s * dy, -s * dx + c * dy, z - self.z_m, yaw - self.yaw_rad)

    def to_world(self, pose: TipPose) -> TipPose:
        """A tip pose in the frame of the base, in the world."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x, y, z, yaw = pose
        return (self.x_m + c * x - s * y, self.y_m + s * x + c * y, z + self.z_m, yaw + self.yaw_rad)

    def far_from(self, other: BasePose) -> tuple[float, float]:
        """How far two poses of the base are apart: metres on the floor, and radians between the headings."""
        turn = math.remainder(self.yaw_rad - other.yaw_rad, 2 * math.pi)
        return math.hypot(self.x_m - other.x_m, self.y_m - other.y_m), abs(turn)
