"""What perception needs of a robot, be it simulated or real: pictures with depth, and what it feels of itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.capture import Capture, Gripper, PointCloud
from llmbt_ir.scene import Camera
from llmbt_runtime.perception.rgbd import RgbdImage, cloud_of

__all__ = ["Sensors", "capture_of", "clouds_of"]


class Sensors(Protocol):
    """Cameras, and the robot's own joints and fingers. Nothing here knows of things: those are recognised."""

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """Where cameras stand."""

    def look(self, camera: Camera, scale: float = 1.0) -> RgbdImage:
        """What a camera sees now, at a part of its resolution."""

    def robot(self) -> tuple[NDArray[np.float64], ...]:
        """Each link by the vertices (M x 3, world) whose hull encloses it, from the joints as they are measured."""

    def gripper(self) -> Gripper:
        """Where the fingers meet, and whether they grip."""


def clouds_of(sensors: Sensors) -> Mapping[str, PointCloud]:
    """What each camera sees, by its id."""
    return {c.id: cloud_of(sensors.look(c)) for c in sensors.cameras}


def capture_of(sensors: Sensors, clouds: Mapping[str, PointCloud]) -> Capture:
    """Clouds together, with what the robot knows of itself."""
    return Capture(PointCloud.join(list(clouds.values())), sensors.robot(), sensors.gripper())
