"""Boxes, cylinders and spheres: how far points are from their surfaces, and the pose that brings them onto it.

A solid's own frame has its centre as origin; a cylinder's axis is z. Sizes are full extents (a cylinder's are diameter,
diameter, height; a sphere's three times its diameter).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.geometry import Pose, Vec3

__all__ = ["Fit", "Geometry", "Kind", "Upright", "distances", "fit", "orientations", "quat_of", "yaw_matrix"]

Array = NDArray[np.float64]

_HUBER_M = 0.003
_ROUNDS = 12
_STILL = 5e-5
_DAMPING = 0.005
"""Of each step, in shares of the points: a direction that fewer of them tell of is hardly gone."""
_MOST_POINTS = 350


class Kind(StrEnum):
    """What recognition tells apart."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"


@dataclass(frozen=True, slots=True)
class Geometry:
    """A solid without a pose."""

    kind: Kind
    size_m: Vec3

    @staticmethod
    def of(shape: str, size_m: Vec3) -> Geometry:
        """That of a scene's shape word: block, cube and box are boxes."""
        return Geometry(Kind(shape) if shape in ("cylinder", "sphere") else Kind.BOX, size_m)


@dataclass(frozen=True, slots=True)
class Upright:
    """A way to lie on a level surface: `turn` (3 x 3, rows) takes the solid's frame to one whose z is up; the extents
    are those along that frame's axes."""

    turn: tuple[Vec3, Vec3, Vec3]
    extents_m: Vec3


_AS_IS = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_ON_END = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0))
"""x of the solid is down, its z along x."""
_ON_SIDE = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0))
"""y of the solid is down, its z along y."""


def orientations(geometry: Geometry) -> Iterator[Upright]:
    """The ways in which a solid lies on a level surface, but for turns about the vertical; its own z up first."""
    x, y, z = geometry.size_m
    yield Upright(_AS_IS, (x, y, z))
    if geometry.kind is Kind.SPHERE:
        return
    if not (math.isclose(x, z) and geometry.kind is Kind.BOX):
        yield Upright(_ON_END, (z, y, x))
    if geometry.kind is Kind.BOX and not math.isclose(y, z) and not math.isclose(x, y):
        yield Upright(_ON_SIDE, (x, z, y))


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A solid where it explains points best. `rotation`: from its frame to the world, 3 x 3. `off_m`: the root mean
    square, `tail_m` the 90th percentile of the points' distances from its surface. `level`: whether a face or an end
    of it points up."""

    geometry: Geometry
    xyz_m: Vec3
    rotation: Array
    off_m: float
    tail_m: float
    level: bool = True

    @property
    def pose(self) -> Pose:
        """Where the solid is."""
        return Pose(self.xyz_m, quat_of(self.rotation))

    def off(self, points: Array) -> Array:
        """Signed distances of points (N x 3, world) from the surface."""
        return distances(self.geometry, (points - np.asarray(self.xyz_m)) @ self.rotation)

    @staticmethod
    def at(geometry: Geometry, xyz: Array, rotation: Array, points: Array, *, level: bool) -> Fit:
        """The solid at a pose, with its distances from points."""
        off = np.abs(distances(geometry, (points - xyz) @ rotation))
        x, y, z = (float(v) for v in xyz)
        root = float(np.sqrt(np.mean(off**2)))
        return Fit(geometry, (x, y, z), rotation, root, float(np.percentile(off, 90)), level)


def distances(geometry: Geometry, local: Array) -> Array:
    """Signed distances of points (N x 3, in the solid's frame) from its surface; negative within."""
    half = np.asarray(geometry.size_m) / 2
    if geometry.kind is Kind.SPHERE:
        return np.asarray(np.linalg.norm(local, axis=1) - half[0])
    if geometry.kind is Kind.CYLINDER:
        out = np.column_stack([np.hypot(local[:, 0], local[:, 1]) - half[0], np.abs(local[:, 2]) - half[2]])
    else:
        out = np.abs(local) - half
    return np.asarray(np.linalg.norm(np.maximum(out, 0.0), axis=1) + np.minimum(out.max(axis=1), 0.0))


def _residual(geometry: Geometry, turn: Array, pose: Array, points: Array) -> Array:
    """Signed distances of points (world) for a pose (x, y, z, yaw)."""
    return distances(geometry, (points - pose[:3]) @ (yaw_matrix(pose[3]) @ turn))


def fit(geometry: Geometry, upright: Upright, start: Array, points: Array, *, free: tuple[int, ...] = (0, 1, 3)) -> Fit:
    """The pose nearest to `start` (x, y, z, yaw) that brings a solid's surface to the points (N x 3, world).

    Levenberg-Marquardt on the distances with Huber weights; of the four numbers only those in `free` change. Where the
    points say nothing of a direction, the solid stays where it was started.
    """
    few = points[:: max(1, len(points) // _MOST_POINTS)]
    pose = np.array(start, dtype=np.float64)
    turn = np.array(upright.turn)
    if geometry.kind is Kind.SPHERE or (geometry.kind is Kind.CYLINDER and upright.turn == _AS_IS):
        free = tuple(i for i in free if i != 3)
    steps = np.array([1e-4, 1e-4, 1e-4, 1e-3])
    arm = float(np.hypot(*upright.extents_m[:2])) / 2
    damping = _DAMPING * len(few) * np.array([1.0, 1.0, 1.0, arm**2])[list(free)]
    for _ in range(_ROUNDS):
        r = _residual(geometry, turn, pose, few)
        slopes = np.empty((len(few), len(free)))
        for k, i in enumerate(free):
            moved = pose.copy()
            moved[i] += steps[i]
            slopes[:, k] = (_residual(geometry, turn, moved, few) - r) / steps[i]
        weights = np.minimum(1.0, _HUBER_M / np.maximum(np.abs(r), 1e-9))
        normal = slopes.T @ (slopes * weights[:, None]) + np.diag(damping)
        step = -np.linalg.solve(normal, slopes.T @ (weights * r))
        for k, i in enumerate(free):
            pose[i] += np.clip(step[k], *((-0.3, 0.3) if i == 3 else (-0.02, 0.02)))
        if np.abs(step).max() < _STILL:
            break
    return Fit.at(geometry, pose[:3], yaw_matrix(pose[3]) @ turn, few, level=True)


def yaw_matrix(yaw: float) -> Array:
    """The rotation about the vertical."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def quat_of(rotation: Array) -> tuple[float, float, float, float]:
    """The quaternion (x, y, z, w) of a rotation matrix, w not negative."""
    m = rotation
    quarters = np.array(
        [
            1 + m[0, 0] - m[1, 1] - m[2, 2],
            1 - m[0, 0] + m[1, 1] - m[2, 2],
            1 - m[0, 0] - m[1, 1] + m[2, 2],
            1 + m[0, 0] + m[1, 1] + m[2, 2],
        ]
    )
    k = int(np.argmax(quarters))
    columns = [
        (quarters[0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]),
        (m[0, 1] + m[1, 0], quarters[1], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]),
        (m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], quarters[2], m[1, 0] - m[0, 1]),
        (m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], quarters[3]),
    ]
    q = np.array(columns[k]) / np.linalg.norm(columns[k])
    x, y, z, w = (float(v) for v in (q if q[3] >= 0 else -q))
    return x, y, z, w
