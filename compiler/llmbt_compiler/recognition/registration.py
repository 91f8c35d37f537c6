"""A known solid in any orientation, brought onto a cluster: FPFH features, RANSAC over their matches, then ICP."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.open3d import SEED, open3d
from llmbt_compiler.recognition.solids import Fit, Geometry, Kind

__all__ = ["register"]

Array = NDArray[np.float64]

_SPACING_M = 0.003
_FEATURE_REACH = 6.0
_NORMAL_REACH = 2.5
_INLIER_M = 0.006
_ICP_M = 0.008
_LEVEL = 0.985


def register(points: Array, geometry: Geometry) -> Fit:
    """The pose in which a solid explains a cluster (N x 3, world) best."""
    o3d = open3d()
    o3d.utility.random.seed(SEED)
    model = _model(geometry)
    seen = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    _normals(seen, points.mean(axis=0))
    reach = _FEATURE_REACH * _SPACING_M
    around = o3d.geometry.KDTreeSearchParamHybrid(radius=reach, max_nn=100)
    features = [o3d.pipelines.registration.compute_fpfh_feature(c, around) for c in (seen, model)]
    r = o3d.pipelines.registration
    rough = r.registration_ransac_based_on_feature_matching(
        seen,
        model,
        *features,
        True,
        _INLIER_M,
        r.TransformationEstimationPointToPoint(False),
        3,
        [r.CorrespondenceCheckerBasedOnEdgeLength(0.9), r.CorrespondenceCheckerBasedOnDistance(_INLIER_M)],
        r.RANSACConvergenceCriteria(20_000, 0.999),
    )
    fine = r.registration_icp(seen, model, _ICP_M, rough.transformation, r.TransformationEstimationPointToPlane())
    onto_model = np.asarray(fine.transformation)  # the cluster into the model's frame: its inverse is the pose
    rotation = onto_model[:3, :3].T
    xyz = -rotation @ onto_model[:3, 3]
    up = np.abs(rotation[2])
    level = bool(geometry.kind is Kind.SPHERE or up.max() > _LEVEL)
    return Fit.at(geometry, xyz, rotation, points, level=level)


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
