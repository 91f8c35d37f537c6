"""A cluster explained by one thing of known geometry."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.hidden import Surroundings, starts
from llmbt_compiler.recognition.measure import top_of
from llmbt_compiler.recognition.solids import Fit, Geometry, Kind, Upright, fit, orientations

__all__ = ["explain", "mismatch"]

Array = NDArray[np.float64]

_MISMATCH_M = 0.007
"""Measured sizes exceed the known ones by less than this, or the thing is another one."""
_HIDDEN = 0.35
"""So much of an extent may be hidden behind other things."""
_TAIL_M = 0.0045
_WORSE, _SLACK_M = 1.5, 0.0005
"""How much worse than the measured solid a known one may explain the points."""
_PER_MISMATCH = 0.25
_OTHER_KIND_M = 0.001
_AS_GOOD_M = 0.0003
"""Places explain points equally well where they differ by less."""


def mismatch(measured: Fit, upright: Upright) -> float:
    """The largest difference between measured and known extents, footprints turned to agree best; infinite where they
    cannot be of one thing: what is seen is larger, or much less, or of another height."""
    a, b, h = _extents(measured)
    x, y, z = upright.extents_m
    best = math.inf
    for flat in ((a - x, b - y), (a - y, b - x)):
        off = (*flat, h - z)
        if max(off) <= _MISMATCH_M and abs(h - z) <= _MISMATCH_M:
            hidden = all(-d <= max(_MISMATCH_M, _HIDDEN * e) for d, e in zip(flat, (x, y), strict=True))
            best = min(best, max(abs(d) for d in off)) if hidden else best
    return best


def _extents(measured: Fit) -> tuple[float, float, float]:
    """Along the level axes of a measured solid and up: an axis of a solid that lies level is up or not."""
    sizes = np.abs(measured.rotation) @ np.diag(measured.geometry.size_m)
    up = int(np.argmax(np.abs(measured.rotation[2])))
    flat = [measured.geometry.size_m[i] for i in range(3) if i != up]
    return flat[0], flat[1], float(sizes[2, up])


def explain(
    points: Array, measured: Fit, support_m: float | None, known: Iterable[Geometry], every: Array | None = None
) -> list[Fit]:
    """The known geometries that explain a cluster, each upright where it does so best; the best one first.

    `every`: all points that were seen, the surfaces on which things stand among them; they tell where a part may be
    hidden. A worse one may still be right where what is seen is little; what is declared of colours and places decides.
    """
    found: dict[Geometry, tuple[float, Fit]] = {}
    for geometry in known:
        other = _OTHER_KIND_M if geometry.kind is not measured.geometry.kind else 0.0
        for way in orientations(geometry):
            off = mismatch(measured, way)
            if math.isinf(off):
                continue
            here = _fit_here(points, measured, support_m, geometry, way, every)
            score = here.off_m + _PER_MISMATCH * off + other
            if (
                here.tail_m <= _TAIL_M
                and here.off_m <= _WORSE * measured.off_m + _SLACK_M
                and (geometry not in found or score < found[geometry][0])
            ):
                found[geometry] = score, here
    return [f for _, f in sorted(found.values(), key=lambda f: (f[0], f[1].geometry.kind, f[1].geometry.size_m))]


def _fit_here(
    points: Array, measured: Fit, support_m: float | None, geometry: Geometry, way: Upright, every: Array | None
) -> Fit:
    x, y, _ = measured.xyz_m
    level = measured.rotation[:2, int(np.argmax(np.abs(measured.rotation[:2]).max(axis=0)))]
    yaw = math.atan2(level[1], level[0])
    half = way.extents_m[2] / 2
    z = support_m + half if support_m is not None else top_of(points) - half
    free = (0, 1, 3) if support_m is not None else (0, 1, 2, 3)
    alike = geometry.kind is Kind.BOX and math.isclose(way.extents_m[0], way.extents_m[1])
    yaws = (yaw,) if alike else (yaw, yaw + math.pi / 2)
    here = min((fit(geometry, way, np.array([x, y, z, a]), points, free=free) for a in yaws), key=lambda f: f.off_m)
    if every is None or support_m is None or geometry.kind is not Kind.BOX:
        return here
    others = [
        fit(geometry, way, np.array([*at, z, a]), points, free=free)
        for a in yaws
        for at in starts(points, a, way.extents_m[:2])
    ]
    best = min((here, *others), key=lambda f: f.off_m).off_m
    as_good = [f for f in (here, *others) if f.off_m <= best + _AS_GOOD_M]
    if len(as_good) == 1:
        return as_good[0]
    around = Surroundings.of(points, support_m, every)
    return min(as_good, key=lambda f: f.off_m + around.against(f, points))
