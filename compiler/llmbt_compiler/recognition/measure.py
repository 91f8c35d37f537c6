"""What a cluster is by itself, no list of known things at hand: its support, shape, size and pose."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.solids import Fit, Geometry, Kind, Upright, fit, orientations
from llmbt_ir.geometry import Box
from llmbt_ir.scene import Scene

__all__ = ["Footprint", "footprint", "measure", "support_under", "top_of"]

Array = NDArray[np.float64]

_REACHES_DOWN_M = 0.04
"""A round thing hides the lower half of itself."""
_LEAST_M, _MOST_M = 0.004, 0.3
_TOP_BAND_M = 0.004
_SIDE_BAND_M = 0.006
_SIDE_POINTS = 12
_MOST_POINTS = 500
_HALF_VOXEL_M = 0.0015
_ROUND_UP_TO = 1.05
"""A round solid is it unless a box explains the cluster so much better: of a round thing, 0.8 at most has been seen, of
a box 1.4 at least (development scenes)."""


def support_under(points: Array, scene: Scene) -> float | None:
    """The height of the known surface that the points stand on; None where they hang in the air."""
    bottom = float(np.percentile(points[:, 2], 1))
    x, y = (float(v) for v in np.median(points[:, :2], axis=0))
    tops = [f.top_m for f in scene.fixtures if Box(f.xyz_m, f.size_m).contains_xy(x, y, -0.01)]
    below = [t for t in (0.0, *tops) if t < bottom + _TOP_BAND_M]
    highest = max(below, default=-math.inf)
    return highest if bottom - highest <= _REACHES_DOWN_M else None


def top_of(points: Array) -> float:
    """The height of the highest level part."""
    return end_of(points[:, 2])


def end_of(values: Array) -> float:
    """Where a face ends values at the high side: the median of the densest band just below the highest of them."""
    v = np.sort(values)
    v = v[v > v[int(0.995 * (len(v) - 1))] - 2 * _TOP_BAND_M]
    within = np.searchsorted(v, v + _TOP_BAND_M, side="right") - np.arange(len(v))
    first = int(np.argmax(within))
    return float(np.median(v[first : first + within[first]]))


@dataclass(frozen=True, slots=True)
class Footprint:
    """The smallest rectangle around points seen from above: its centre, the direction of its first side, its sides."""

    centre: tuple[float, float]
    yaw_rad: float
    size_m: tuple[float, float]


def footprint(points: Array) -> Footprint:
    """The rectangle of least area over all yaws, its own in [0, pi/2)."""
    xy = points[:: max(1, len(points) // _MOST_POINTS), :2]
    middle = np.median(xy, axis=0)
    yaw = 0.0
    for around in (np.arange(0.0, 90.0, 2.0), np.arange(-2.0, 2.1, 0.25)):
        yaws = yaw + np.radians(around)
        across = np.stack([_axes(y) for y in yaws]) @ (xy - middle).T
        low, high = np.percentile(across, (1, 99), axis=2)
        yaw = float(yaws[int(np.argmin(np.prod(high - low, axis=1)))])
    yaw %= math.pi / 2
    low, high = np.percentile((xy - middle) @ _axes(yaw).T, (0.5, 99.5), axis=0)
    cx, cy = (low + high) / 2 @ _axes(yaw) + middle
    return Footprint((float(cx), float(cy)), yaw, (float(high[0] - low[0]), float(high[1] - low[1])))


def measure(points: Array, support_m: float | None) -> Fit:
    """The solid of whatever size, upright on its support, that explains the points best."""
    top = top_of(points)
    bottom = support_m if support_m is not None else float(np.percentile(points[:, 2], 1))
    height = max(top - bottom, _LEAST_M)
    seen = footprint(points)
    found = [_box(points, seen, bottom, height)]
    found += [
        f for f in (_standing(points, bottom, height), _lying(points, seen, bottom), _ball(points)) if f is not None
    ]
    box, *round_ = found
    best = min(round_, key=lambda f: f.off_m, default=box)
    return best if best.off_m < _ROUND_UP_TO * box.off_m else box


def _box(points: Array, seen: Footprint, bottom: float, height: float) -> Fit:
    """Sides from the points of the faces where a face is seen, else from where the top ends."""
    cx, cy = seen.centre
    yaw, size = seen.yaw_rad, seen.size_m
    for _ in range(2):
        local = (points[:, :2] - (cx, cy)) @ _axes(yaw).T
        side = points[:, 2] < bottom + height - _SIDE_BAND_M
        edges = [_edge(local[:, axis], side, sign) for axis in (0, 1) for sign in (-1, 1)]
        middle = np.array([edges[0] + edges[1], edges[2] + edges[3]]) / 2
        size = (max(edges[1] - edges[0], _LEAST_M), max(edges[3] - edges[2], _LEAST_M))
        cx, cy = (float(v) for v in middle @ _axes(yaw) + (cx, cy))
        geometry = Geometry(Kind.BOX, (size[0], size[1], height))
        way = next(orientations(geometry))
        found = fit(geometry, way, np.array([cx, cy, bottom + height / 2, yaw]), points)
        cx, cy = found.xyz_m[:2]
        yaw = math.atan2(found.rotation[1, 0], found.rotation[0, 0])
    return found


def _edge(along: Array, side: NDArray[np.bool_], sign: int) -> float:
    """Where a box ends in one direction. Where only its top is seen, it ends half a voxel beyond the last mean."""
    out = sign * along
    end = float(np.percentile(out, 99))
    face = out[side & (out > end - _SIDE_BAND_M)]
    return sign * (
        float(np.median(face)) if len(face) >= _SIDE_POINTS else float(np.percentile(out, 99.7)) + _HALF_VOXEL_M
    )


def _standing(points: Array, bottom: float, height: float) -> Fit | None:
    """A cylinder on its end, from the circle of its sides, or of its rim where no side is seen."""
    side = points[points[:, 2] < bottom + height - _SIDE_BAND_M]
    circle = _circle(side[:, :2]) if len(side) >= 2 * _SIDE_POINTS else None
    if circle is None:
        return None
    geometry = Geometry(Kind.CYLINDER, (2 * circle[2], 2 * circle[2], height))
    return fit(geometry, next(orientations(geometry)), np.array([*circle[:2], bottom + height / 2, 0.0]), points)


def _lying(points: Array, seen: Footprint, bottom: float) -> Fit | None:
    """A cylinder on its side: a circle that touches the support, across one of the sides of the footprint."""
    found = []
    for turn in (0.0, math.pi / 2):
        yaw = seen.yaw_rad + turn
        local = (points[:, :2] - seen.centre) @ _axes(yaw).T
        low, high = np.percentile(local[:, 0], (15, 85))  # the ends are discs
        between = (local[:, 0] > low) & (local[:, 0] < high)
        middle, radius = _rolling(local[between, 1], points[between, 2] - bottom)
        if not _LEAST_M / 2 < radius < _MOST_M / 2:
            continue
        ends = (-end_of(-local[:, 0]), end_of(local[:, 0]))
        geometry = Geometry(Kind.CYLINDER, (2 * radius, 2 * radius, max(ends[1] - ends[0], _LEAST_M)))
        x, y = np.array([(ends[0] + ends[1]) / 2, middle]) @ _axes(yaw) + seen.centre
        found.append(fit(geometry, _on_side(geometry), np.array([x, y, bottom + radius, yaw]), points))
    return min(found, key=lambda f: f.off_m, default=None)


def _rolling(across: Array, up: Array) -> tuple[float, float]:
    """Where the middle of a circle that stands on a line is along it, and its radius: least squares, a few times over
    from the middle found before."""
    middle, radius = float(np.median(across)), 0.0
    for _ in range(4):
        here = across - middle
        solution, *_ = np.linalg.lstsq(np.column_stack([2 * here, 2 * up]), here**2 + up**2, rcond=None)
        middle, radius = middle + float(solution[0]), float(solution[1])
    return middle, radius


def _on_side(geometry: Geometry) -> Upright:
    return list(orientations(geometry))[1]


def _ball(points: Array) -> Fit | None:
    """A sphere, by least squares."""
    a = np.column_stack([2 * points, np.ones(len(points))])
    solution, *_ = np.linalg.lstsq(a, (points**2).sum(axis=1), rcond=None)
    squared = float(solution[3] + solution[:3] @ solution[:3])
    if not _LEAST_M**2 < 4 * squared < _MOST_M**2:
        return None
    d = 2 * math.sqrt(squared)
    geometry = Geometry(Kind.SPHERE, (d, d, d))
    return fit(geometry, next(orientations(geometry)), np.array([*solution[:3], 0.0]), points, free=(0, 1, 2))


def _circle(xy: Array) -> tuple[float, float, float] | None:
    """Centre and radius of the circle through points, by least squares on the algebraic distance, then once more
    without the points that are far off."""
    use = xy
    for _ in range(2):
        if len(use) < 12:
            return None
        middle = use.mean(axis=0)
        u = use - middle
        a = np.column_stack([2 * u, np.ones(len(u))])
        solution, *_ = np.linalg.lstsq(a, (u**2).sum(axis=1), rcond=None)
        squared = float(solution[2] + solution[:2] @ solution[:2])
        if not _LEAST_M**2 < 4 * squared < _MOST_M**2:
            return None
        radius = math.sqrt(squared)
        off = np.abs(np.linalg.norm(u - solution[:2], axis=1) - radius)
        cx, cy = (float(v) for v in solution[:2] + middle)
        use = use[off < max(0.004, 2 * float(np.median(off)))]
    return cx, cy, radius


def _axes(yaw: float) -> Array:
    """Along a direction and to its left, as rows."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([[c, s], [-s, c]])
