"""What makes it doubtful that a cloud shows a scene: other units or another frame, or too few points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.segment import VOXEL_M, crop
from llmbt_ir.capture import Capture
from llmbt_ir.diagnostics import Diagnostic, Severity
from llmbt_ir.scene import Scene

__all__ = ["doubts"]

_HARDLY_ANY = 0.01
_AT_SURFACE_M = 0.01
_SPARSE_M = 2 * VOXEL_M
_SAMPLED = 2_000


def doubts(capture: Capture, scene: Scene) -> tuple[Diagnostic, ...]:
    """W453 where hardly a point is over the scene, or none at a place's height; W454 where points are too far apart."""
    xyz = capture.cloud.xyz_m[np.isfinite(capture.cloud.xyz_m).all(axis=1)]
    inside = crop(capture.cloud, scene).xyz_m
    heights = np.array([p.surface_m[2] for p in scene.places if p.surface_m is not None])
    at_surface = bool((np.abs(inside[:, 2, None] - heights) < _AT_SURFACE_M).any()) if len(heights) else True
    if len(inside) < _HARDLY_ANY * len(xyz) or not len(inside) or not at_surface:
        low, high = (xyz.min(axis=0), xyz.max(axis=0)) if len(xyz) else (np.zeros(3), np.zeros(3))
        spans = ", ".join(f"{a} {b:.3g} to {c:.3g}" for a, b, c in zip("xyz", low, high, strict=True))
        title = f"of {len(xyz)} points {len(inside)} are where scene `{scene.name}` is: the cloud spans {spans}"
        hint = "a cloud is in metres and in the scene's world frame, z up and 0 at the floor"
        return (Diagnostic("W453", title, severity=Severity.WARNING, help=hint),)
    apart = _spacing_m(inside)
    if apart > _SPARSE_M:
        title = f"the points are some {1e3 * apart:.0f} mm apart" if len(inside) > 1 else "it has one point there"
        hint = f"things are found by points every {1e3 * VOXEL_M:.0f} mm or nearer; give a denser cloud"
        return (Diagnostic("W454", title, severity=Severity.WARNING, help=hint),)
    return ()


def _spacing_m(xyz: NDArray[np.float64]) -> float:
    """The median distance from a point to its nearest neighbour."""
    from scipy.spatial import cKDTree

    if len(xyz) < 2:
        return float("inf")
    some = xyz[:: max(1, len(xyz) // _SAMPLED)]
    return float(np.median(cKDTree(xyz).query(some, k=2)[0][:, 1]))
