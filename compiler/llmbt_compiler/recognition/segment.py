"""From all points to those of things: what is out of the workspace, what is known to stand there, and the robot go."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.open3d import open3d
from llmbt_ir.capture import PointCloud
from llmbt_ir.scene import Fixture, Scene
from llmbt_ir.workspace import workspace

__all__ = ["crop", "thin", "without_fixtures", "without_robot"]

Array = NDArray[np.float64]

VOXEL_M = 0.003
_FIXTURE_M = 0.005
"""Points so near to a fixture are its own: three standard deviations of a depth sensor's noise."""
_ROBOT_M = 0.008


def crop(cloud: PointCloud, scene: Scene) -> PointCloud:
    """The points over the scene's fixtures and places, up to some height; points that are no numbers go."""
    low, high = workspace(scene)
    inside = np.ones(len(cloud), dtype=bool)
    with np.errstate(invalid="ignore"):
        for axis in range(3):
            along = cloud.xyz_m[:, axis]
            inside &= (along > low[axis]) & (along < high[axis])
    return cloud.take(inside)


def without_fixtures(cloud: PointCloud, fixtures: Iterable[Fixture]) -> PointCloud:
    """The points that are neither in a fixture nor on its surface."""
    left = np.arange(len(cloud))
    for f in fixtures:
        within = left
        for axis in (2, 0, 1):
            off = np.abs(cloud.xyz_m[within, axis] - f.xyz_m[axis])
            within = within[off <= f.size_m[axis] / 2 + _FIXTURE_M]
        left = np.setdiff1d(left, within, assume_unique=True)
    return cloud.take(left)


def without_robot(cloud: PointCloud, links: Iterable[Array]) -> PointCloud:
    """The points that are not in the hull of a link, or close to it.

    Hulls are taken in 26 directions, a little wide.
    """
    keep = np.ones(len(cloud), dtype=bool)
    for vertices in links:
        ends = (vertices @ _DIRECTIONS.T).max(axis=0) + _ROBOT_M
        near = np.arange(len(cloud))
        for axis in range(3):
            along = cloud.xyz_m[near, axis]
            near = near[(along <= vertices[:, axis].max() + _ROBOT_M) & (along >= vertices[:, axis].min() - _ROBOT_M)]
        keep[near[(cloud.xyz_m[near] @ _DIRECTIONS.T <= ends).all(axis=1)]] = False
    return cloud.take(keep)


def _directions() -> Array:
    """To the faces, the edges and the corners of a cube."""
    grid = np.array([d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)])
    grid = grid[np.argsort(np.abs(grid).sum(axis=1), kind="stable")]
    return np.asarray(grid / np.linalg.norm(grid, axis=1, keepdims=True))


_DIRECTIONS = _directions()


def thin(cloud: PointCloud) -> PointCloud:
    """One point, the mean, for each voxel that has some."""
    o3d = open3d()
    whole = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(cloud.xyz_m))
    whole.colors = o3d.utility.Vector3dVector(cloud.rgb)
    few = whole.voxel_down_sample(VOXEL_M)
    return PointCloud(np.asarray(few.points), np.asarray(few.colors))
