"""Images with depth, and what follows from them by geometry alone: points, and whether a spot was in view. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.capture import PointCloud
from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Camera

__all__ = ["Region", "RgbdImage", "cloud_of", "noisy", "points_of", "project"]

Array = NDArray[np.float64]
Region = tuple[Vec3, Vec3]
"""The lowest and the highest corner of a box along the world's axes."""


@dataclass(frozen=True, slots=True, eq=False)
class RgbdImage:
    """`rgb`: height x width x 3, sRGB, 8 bit. `depth_m`: height x width, along the optical axis; infinite where nothing
    is in range."""

    camera: Camera
    rgb: NDArray[np.uint8]
    depth_m: Array


def _axes(camera: Camera) -> Array:
    """Right, up and forward of a camera in the world, as rows."""
    forward = np.subtract(camera.target_m, camera.eye_m)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, camera.up_m)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward])


def _tangents(camera: Camera, width: int, height: int) -> tuple[float, float]:
    """Half the image's extent at unit depth, across and up."""
    up = math.tan(math.radians(camera.fov_deg) / 2)
    return up * width / height, up


@lru_cache(maxsize=64)
def _rays(camera: Camera, width: int, height: int) -> Array:
    """What a step of one along the optical axis is for each pixel (height x width x 3, world).

    A pixel's ray goes through its centre, half a pixel from its corner.
    """
    across, up = _tangents(camera, width, height)
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * across
    y = (1 - (np.arange(height) + 0.5) / height * 2) * up
    right, above, ahead = _axes(camera)
    rays = x[None, :, None] * right + y[:, None, None] * above + ahead
    rays.flags.writeable = False
    return np.asarray(rays)


def cloud_of(image: RgbdImage, within: Region | None = None) -> PointCloud:
    """The points of an image, in the world; those of a region, if one is given, and perhaps some around it."""
    seen = np.isfinite(image.depth_m)
    if within is not None:
        height, width = image.depth_m.shape
        rays = _rays(image.camera, width, height)
        for axis in (2, 0, 1):
            along = image.depth_m * rays[:, :, axis]
            along += image.camera.eye_m[axis]
            seen &= (along > within[0][axis]) & (along < within[1][axis])
    v, u = np.nonzero(seen)
    return PointCloud(points_of(image, u, v), image.rgb[v, u].astype(np.float64) / 255)


def points_of(image: RgbdImage, u: NDArray[np.int64], v: NDArray[np.int64]) -> Array:
    """What some pixels show (columns and rows, N each; the points N x 3, world)."""
    height, width = image.depth_m.shape
    points = _rays(image.camera, width, height)[v, u]
    points *= image.depth_m[v, u][:, None]
    points += image.camera.eye_m
    return points


def project(camera: Camera, xyz_m: Array, width: int, height: int) -> tuple[NDArray[np.int64], Array]:
    """The pixels (N x 2: column, row; -1 where outside the image) that show points (N x 3, world), and their depths."""
    local = (xyz_m - np.asarray(camera.eye_m)) @ _axes(camera).T
    across, up = _tangents(camera, width, height)
    depth = local[:, 2]
    ahead = depth > 1e-6
    safe = np.where(ahead, depth, 1.0)
    u = np.floor((local[:, 0] / safe / across + 1) / 2 * width).astype(np.int64)
    v = np.floor((1 - local[:, 1] / safe / up) / 2 * height).astype(np.int64)
    inside = ahead & (u >= 0) & (u < width) & (v >= 0) & (v < height)
    return np.where(inside[:, None], np.column_stack([u, v]), -1), depth


def noisy(image: RgbdImage, sigma_m: float, rng: np.random.Generator) -> RgbdImage:
    """The image of a depth sensor whose every reading is off by a Gaussian error."""
    error = rng.normal(0.0, sigma_m, image.depth_m.shape)
    return RgbdImage(image.camera, image.rgb, image.depth_m + error)
