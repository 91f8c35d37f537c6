"""Free spots of a region, seen from above. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Fixture, ScenePlace
from llmbt_runtime.bullet.bodies import Extent
from llmbt_runtime.bullet.frames import BasePose

Array = NDArray[np.float64]

__all__ = ["SPOT_GAP_TILTED_M", "free_spots", "has_room", "small_half_m"]

_SPOT_STEP_M = 0.02
_SPOT_GAP_M, SPOT_GAP_TILTED_M = 0.055, 0.025
_SPOT_FIXTURE_GAP_M = 0.09
_BLOCK_HALF_M, _DRINK_HALF_M = 0.0235, 0.033
_MIN_REACH_M, _MAX_REACH_M = 0.30, 0.74


def small_half_m(*, drives: bool) -> tuple[float, float]:
    """Half the extents of what a region has to have room for to be free: a block on a bench, a drink in a room."""
    return (_DRINK_HALF_M, _DRINK_HALF_M) if drives else (_BLOCK_HALF_M, _BLOCK_HALF_M)


def free_spots(
    place: ScenePlace,
    half_m: tuple[float, float],
    keep_off: Iterable[Extent],
    fixtures: Iterable[Fixture],
    frame: BasePose | None,
    gap_m: float = _SPOT_GAP_M,
) -> list[tuple[float, float]]:
    """Where in a region a thing of half-extents `half_m` would lie apart from everything, the roomiest first.

    With a frame, only where an arm that stands there reaches, near before far.
    """
    if place.surface_m is None:
        return []
    px, py, pz = place.surface_m
    hx, hy = half_m
    rx, ry = place.size_m[0] / 2 - hx - 0.005, place.size_m[1] / 2 - hy - 0.005
    if rx < 0 or ry < 0:
        return []
    xs = np.linspace(-rx, rx, max(1, int(2 * rx / _SPOT_STEP_M) + 1)) + px if rx > 0 else np.array([px])
    ys = np.linspace(-ry, ry, max(1, int(2 * ry / _SPOT_STEP_M) + 1)) + py if ry > 0 else np.array([py])
    gx, gy = (a.ravel() for a in np.meshgrid(xs, ys, indexing="ij"))
    ok = np.ones(len(gx), dtype=bool)
    away = np.hypot(gx - px, gy - py)
    if frame is not None:
        bx, by = gx - frame.x_m, gy - frame.y_m
        away = np.hypot(bx, by)
        turn = np.remainder(np.arctan2(by, bx) - frame.yaw_rad + np.pi, 2 * np.pi) - np.pi
        ok &= (away >= _MIN_REACH_M) & (away <= _MAX_REACH_M) & (np.abs(turn) < math.radians(150))
    for f in fixtures:
        if f.top_m > pz + 0.005:
            gap = _gap(gx, gy, f.xyz_m, (f.size_m[0] / 2 + hx, f.size_m[1] / 2 + hy))
            ok &= gap >= _SPOT_FIXTURE_GAP_M
    room = np.full(len(gx), 0.12)
    for e in keep_off:
        room = np.minimum(room, _gap(gx, gy, e.centre, (e.half[0] + hx, e.half[1] + hy)))
    ok &= room >= gap_m
    index = np.flatnonzero(ok)
    order = np.lexsort((gy[index], gx[index], np.round(away[index], 3), -np.round(room[index], 3)))
    return [(float(gx[i]), float(gy[i])) for i in index[order]]


def has_room(
    place: ScenePlace, size_m: tuple[float, ...], keep_off: Iterable[Extent], fixtures: Iterable[Fixture]
) -> bool:
    """Whether something of a size could stand somewhere on a region, one way round or the other; the arm aside."""
    half, lying, fixed = (size_m[0] / 2, size_m[1] / 2), list(keep_off), list(fixtures)
    return any(free_spots(place, h, lying, fixed, None) for h in sorted({half, half[::-1]}))


def _gap(x: Array, y: Array, centre: Vec3, half: tuple[float, float]) -> Array:
    """How far points are outside a box, along the axis on which they are further out."""
    found: Array = np.maximum(np.abs(x - centre[0]) - half[0], np.abs(y - centre[1]) - half[1])
    return found
