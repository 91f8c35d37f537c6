"""Where cameras stand."""

from __future__ import annotations

import math

import numpy as np

from llmbt_ir.scene import Camera, Scene

__all__ = ["cameras_of"]

_AZIMUTHS_DEG = (70.0, 190.0, 290.0)
_HEIGHT_M, _FOV_DEG = 1.1, 50.0


def cameras_of(scene: Scene) -> tuple[Camera, ...]:
    """The scene's cameras; where it declares none, three around its places, from the robot's left on."""
    if scene.cameras:
        return scene.cameras
    spots = np.array([p.surface_m for p in scene.places if p.surface_m is not None] or [scene.robot_xyz_m])
    middle = (spots.min(axis=0) + spots.max(axis=0)) / 2
    radius = 0.75 + float(np.linalg.norm(np.ptp(spots[:, :2], axis=0))) / 2
    found = []
    for k, azimuth in enumerate(_AZIMUTHS_DEG, 1):
        angle = math.radians(azimuth) + scene.robot_yaw_rad
        x, y, z = (float(v) for v in middle)
        eye = (x + radius * math.cos(angle), y + radius * math.sin(angle), z + _HEIGHT_M)
        found.append(Camera(f"camera_{k}", eye, (x, y, z), _FOV_DEG))
    return tuple(found)
