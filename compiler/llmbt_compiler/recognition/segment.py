"""From all points to those of things: what is out of the workspace, what is known to stand there, and the robot go."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.open3d import open3d
from llmbt_ir.capture import PointCloud
from llmbt_ir.scene import Fixture, Scene

__all__ = ["crop", "thin", "without_fixtures", "without_robot"]

Array = NDArray[np.float64]

VOXEL_M = 0.003
_AROUND_M = 0.05
_ABOVE_M = 0.6
_FIXTURE_M = 0.005
"""Points so near to a fixture are its own: three standard deviations of a depth sensor's noise."""
_ROBOT_M = 0.008
_GROUND_M = 0.0


def crop(cloud: PointCloud, scene: Scene) -> PointCloud:
    """The points over the scene's fixtures and places, up to some height; points that are no numbers go."""
    boxes = [(f.xyz_m[:2], f.size_m[:2], f.top_m) for f in scene.fixtures]
    boxes += [(p.surface_m[:2], p.size_m, p.surface_m[2]) for p in scene.places if p.surface_m is not None]
    if not boxes:
        return cloud.take(np.flatnonzero(np.isfinite(cloud.xyz_m).all(axis=1)))
    centre, size = np.array([b[0] for b in boxes]), np.array([b[1] for b in boxes])
    low = (centre - size / 2).min(axis=0) - _AROUND_M
    high = (centre + size / 2).max(axis=0) + _AROUND_M
    top = max(b[2] for b in boxes) + _ABOVE_M
    x, y, z = cloud.xyz_m.T
    with np.errstate(invalid="ignore"):
        inside = (x > low[0]) & (x < high[0]) & (y > low[1]) & (y < high[1])
        inside &= (z > _GROUND_M + _FIXTURE_M) & (z < top)
    return cloud.take(inside)


def without_fixtures(cloud: PointCloud, fixtures: Iterable[Fixture]) -> PointCloud:
    """The points that are neither in a fixture nor on its surface."""
    xyz = cloud.xyz_m
    keep = np.ones(len(xyz), dtype=bool)
    for f in fixtures:
        inside = np.ones(len(xyz), dtype=bool)
        for axis in range(3):
            inside &= np.abs(xyz[:, axis] - f.xyz_m[axis]) <= f.size_m[axis] / 2 + _FIXTURE_M
        keep &= ~inside
    return cloud.take(keep)


def without_robot(cloud: PointCloud, links: Iterable[Array]) -> PointCloud:
    """The points that are not in the hull of a link, or close to it.

    Hulls are taken in 26 directions, a little wide.
    """
    along = cloud.xyz_m @ _DIRECTIONS.T
    keep = np.ones(len(along), dtype=bool)
    for vertices in links:
        ends = (vertices @ _DIRECTIONS.T).max(axis=0) + _ROBOT_M
        near = np.flatnonzero((along[:, :6] <= ends[:6]).all(axis=1))
        keep[near[(along[near, 6:] <= ends[6:]).all(axis=1)]] = False
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
