"""Points to clusters: DBSCAN over position and chromaticity, so that things that touch but differ in colour part."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from llmbt_compiler.recognition.open3d import open3d
from llmbt_ir.capture import PointCloud

__all__ = ["clusters", "parts"]

Array = NDArray[np.float64]

_REACH_M = 0.0075
_PER_CHROMATICITY_M = 0.05
_NEIGHBOURS = 8
_LEAST_POINTS = 30


def clusters(cloud: PointCloud) -> list[PointCloud]:
    """The clusters of a thinned cloud, the ones nearest to the origin of x first; what is too small is noise."""
    xyz, rgb = cloud.xyz_m, cloud.rgb
    chromaticity = rgb[:, :2] / np.maximum(rgb.sum(axis=1, keepdims=True), 0.15)
    found = [cloud.take(i) for i in parts(np.column_stack([xyz, _PER_CHROMATICITY_M * chromaticity]))]
    return sorted(found, key=lambda c: tuple(np.round(c.xyz_m.mean(axis=0), 4)))


def parts(points: Array, least: int = _LEAST_POINTS) -> list[NDArray[np.int64]]:
    """DBSCAN: indices of the points (N x D) of each dense part of at least so many points."""
    if len(points) < least:
        return []
    o3d = open3d()
    search = o3d.core.nns.NearestNeighborSearch(o3d.core.Tensor(np.ascontiguousarray(points)))
    search.fixed_radius_index(_REACH_M)
    found, _, splits = search.fixed_radius_search(o3d.core.Tensor(np.ascontiguousarray(points)), _REACH_M)
    other, start = found.numpy(), splits.numpy()
    count = np.diff(start)
    core = count >= _NEIGHBOURS
    one = np.repeat(np.arange(len(points)), count)
    linked = core[one] & core[other]
    n = len(points)
    graph = coo_matrix((np.ones(int(linked.sum()), dtype=np.int8), (one[linked], other[linked])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    label = np.where(core, label, -1)
    border = ~core[one] & core[other]
    label[one[border][::-1]] = label[other[border][::-1]]
    sizes = np.bincount(label[label >= 0], minlength=1)
    return [np.flatnonzero(label == k) for k in np.flatnonzero(sizes >= least)]
