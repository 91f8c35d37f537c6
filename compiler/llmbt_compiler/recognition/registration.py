"""A known solid in any orientation, brought onto a cluster: FPFH features, RANSAC over their matches, then ICP.

Features and ICP are Open3D's. Its RANSAC draws from several threads, so that no two runs are alike, and takes minutes
where there is one core; ours draws once.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.open3d import SEED, open3d
from llmbt_compiler.recognition.solids import Fit, Geometry, Kind

__all__ = ["register"]

Array = NDArray[np.float64]

_SPACING_M = 0.003
_FEATURE_REACH, _NORMAL_REACH = 8.0, 4.0
"""In spacings."""
_DRAWS, _ALIKE, _LEAST_SIDE_M = 20_000, 0.9, 0.012
_INLIER_M = 0.006
_REFINED, _TURNED = 8, 1 + 2 * np.cos(np.radians(20))
"""So many are refined, each turned by 20 degrees at least against the others."""
_ICP_M = (0.008, 0.004)
_LEVEL = 0.985


def register(points: Array, geometry: Geometry) -> Fit:
    """The pose in which a solid explains a cluster (N x 3, world) best; at the cluster's middle where none does."""
    o3d = open3d()
    o3d.utility.random.seed(SEED)
    model = _model(geometry)
    seen = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    _normals(seen, points.mean(axis=0))
    around = o3d.geometry.KDTreeSearchParamHybrid(radius=_FEATURE_REACH * _SPACING_M, max_nn=100)
    r = o3d.pipelines.registration
    features = [r.compute_fpfh_feature(c, around) for c in (seen, model)]
    pairs = np.asarray(r.correspondences_from_features(*features, False))
    found = [_at(points.mean(axis=0), np.eye(3), points, geometry)]
    for rough in _ransac(points[pairs[:, 0]], np.asarray(model.points)[pairs[:, 1]]):
        now = rough
        for reach in _ICP_M:
            now = r.registration_icp(seen, model, reach, now, r.TransformationEstimationPointToPlane()).transformation
        rotation = np.asarray(now)[:3, :3].T
        found.append(_at(-rotation @ np.asarray(now)[:3, 3], rotation, points, geometry))
    return min(found, key=lambda f: f.off_m)


def _at(xyz: Array, rotation: Array, points: Array, geometry: Geometry) -> Fit:
    level = geometry.kind is Kind.SPHERE or bool(np.abs(rotation[2]).max() > _LEVEL)
    return Fit.at(geometry, xyz, rotation, points, level=level)


def _ransac(ours: Array, theirs: Array) -> list[Array]:
    """The rigid motions (4 x 4) of three matches each under which most of all matches (N x 3 and N x 3) agree."""
    rng = np.random.default_rng(SEED)
    triples = rng.integers(0, len(ours), (_DRAWS, 3))
    a, b = ours[triples], theirs[triples]
    sides = [np.linalg.norm(t - np.roll(t, 1, axis=1), axis=2) for t in (a, b)]
    least, most = np.minimum(*sides), np.maximum(*sides)
    alike = ((least > _ALIKE * most) & (least > _LEAST_SIDE_M)).all(axis=1)
    a, b = a[alike], b[alike]
    if not len(a):
        return []
    middle_a, middle_b = a.mean(axis=1, keepdims=True), b.mean(axis=1, keepdims=True)
    u, _, vt = np.linalg.svd(np.swapaxes(a - middle_a, 1, 2) @ (b - middle_b))
    proper = np.ones((len(a), 3))
    proper[:, 2] = np.sign(np.linalg.det(u @ vt))
    rotation = np.swapaxes(u * proper[:, None] @ vt, 1, 2)
    shift = middle_b[:, 0] - np.einsum("kij,kj->ki", rotation, middle_a[:, 0])
    agree = np.array(
        [
            int((((ours @ r.T + t - theirs) ** 2).sum(axis=1) < _INLIER_M**2).sum())
            for r, t in zip(rotation, shift, strict=True)
        ]
    )
    best: list[int] = []
    for k in np.argsort(-agree, kind="stable").tolist():
        if all(np.trace(rotation[k].T @ rotation[b]) < _TURNED for b in best):
            best.append(k)
        if len(best) == _REFINED:
            break
    motions = np.tile(np.eye(4), (len(best), 1, 1))
    motions[:, :3, :3], motions[:, :3, 3] = rotation[best], shift[best]
    return list(motions)


def _model(geometry: Geometry) -> Any:
    """Points all over the surface of a solid, with normals."""
    o3d = open3d()
    x, y, z = geometry.size_m
    match geometry.kind:
        case Kind.SPHERE:
            mesh = o3d.geometry.TriangleMesh.create_sphere(x / 2, 40)
        case Kind.CYLINDER:
            mesh = o3d.geometry.TriangleMesh.create_cylinder(x / 2, z, 40, 10)
        case _:
            mesh = o3d.geometry.TriangleMesh.create_box(x, y, z).translate((-x / 2, -y / 2, -z / 2))
    count = int(np.clip(mesh.get_surface_area() / _SPACING_M**2, 500, 6000))
    model = mesh.sample_points_uniformly(count)
    _normals(model, np.zeros(3))
    return model


def _normals(cloud: Any, middle: Array) -> None:
    """Estimate normals that point away from the middle: the solids are convex."""
    o3d = open3d()
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamHybrid(radius=_NORMAL_REACH * _SPACING_M, max_nn=30))
    normals, points = np.asarray(cloud.normals).copy(), np.asarray(cloud.points)
    inward = ((points - middle) * normals).sum(axis=1) < 0
    normals[inward] *= -1
    cloud.normals = o3d.utility.Vector3dVector(normals)
