"""A cluster explained by several things of known geometry that touch.

One thing after another is put into a corner of what is still unexplained; where two are about equally good there, both
are tried. In the end all are fitted to their own points, and together they have to account for the cluster.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from llmbt_compiler.recognition.cluster import parts
from llmbt_compiler.recognition.measure import end_of, footprint
from llmbt_compiler.recognition.solids import Fit, Geometry, Kind, Upright, distances, fit, orientations, yaw_matrix

__all__ = ["Part", "split"]

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Part = tuple[Fit, Indices]
"""A thing, and which of the cluster's points are its own."""

_NEAR_M, _INSIDE_M = 0.003, 0.004
_HEIGHT_M = 0.007
_MOST_PARTS = 4
_LEAST_PART = 40
_LEFT_OVER, _NEARLY_ALL = 0.05, 0.25
_TRIED, _KEPT = 12, 5
_TAIL_M, _DEEP_PART = 0.0035, 0.02
_FAR_M, _FAR_PART = 0.005, 0.02
_BARE_PART = 0.4
_SETTLED, _ROUNDS = 4, 8
_EXCELLENT = 0.02
"""A way that leaves so little unexplained is it, if it is sound."""
_ALIKE_M = 0.01
"""Beginnings that are nearer to each other than this, and stand alike, count as one."""
_FEW = 200


def split(points: Array, support_m: float | None, stock: Mapping[Geometry, int]) -> list[Part]:
    """Two to four things on one support that together explain a cluster; nothing where there are none.

    `stock`: the geometries that may be there, with how many there are of each.
    """
    hull = _hull(points)
    least = sorted(_area(g) for g, n in stock.items() for _ in range(min(n, 2)))[:2]
    if support_m is None or hull is None or len(least) < 2 or hull.volume < 0.8 * sum(least):
        return []
    others: list[tuple[int, tuple[Fit, ...]]] = []
    for left, solids in _search(points, np.arange(len(points)), support_m, Counter(stock), ()):
        found = _settled(points, solids, support_m) if left <= _EXCELLENT * len(points) else []
        if found:
            return found
        others.append((left, solids))
    others.sort(key=lambda w: w[0])
    settled = (_settled(points, solids, support_m) for _, solids in others[:_SETTLED])
    return min((s for s in settled if s), key=lambda s: (len(s), _off(points, s)), default=[])


def _off(points: Array, found: list[Part]) -> float:
    return float(sum(np.abs(f.off(points[i])).sum() for f, i in found))


def _area(geometry: Geometry) -> float:
    """The least footprint of a solid."""
    x, y, _ = sorted(geometry.size_m)
    return x * y if geometry.kind is Kind.BOX else math.pi / 4 * x * y


def _hull(points: Array) -> ConvexHull | None:
    """Seen from above."""
    try:
        return ConvexHull(points[:, :2])
    except QhullError:
        return None


def _search(
    points: Array, left: Indices, support_m: float, stock: Counter[Geometry], so_far: tuple[Fit, ...]
) -> Iterator[tuple[int, tuple[Fit, ...]]]:
    """Ways to explain the rest, each with how many points it leaves."""
    if len(so_far) > 1 and len(left) <= _NEARLY_ALL * len(points):
        yield len(left), so_far
    if len(left) <= max(_LEAST_PART, _LEFT_OVER * len(points)) or len(so_far) == _MOST_PARTS:
        return
    kept = _KEPT if len(so_far) < 2 else 1
    for solid in _corners(points, left, support_m, [g for g, n in stock.items() if n > 0])[:kept]:
        rest = left[solid.off(points[left]) > _NEAR_M]
        pieces = parts(points[rest], _LEAST_PART // 2)
        rest = rest[np.concatenate(pieces)] if pieces else rest[:0]
        if len(rest) < len(left) and not any(_into(solid, s) for s in so_far):
            yield from _search(points, rest, support_m, stock - Counter([solid.geometry]), (*so_far, solid))


def _settled(points: Array, solids: tuple[Fit, ...], support_m: float) -> list[Part]:
    """Each solid fitted to the points that are nearest to it; nothing if that is no good."""
    now = list(solids)
    before: Indices = np.zeros(0, dtype=np.int64)
    for _ in range(_ROUNDS):
        nearest = np.argmin([np.abs(s.off(points)) for s in now], axis=0)
        if any((nearest == k).sum() < _LEAST_PART for k in range(len(now))):
            return []
        if np.array_equal(nearest, before):
            break
        before = nearest
        now = [_again(s, points[nearest == k], support_m) for k, s in enumerate(now)]
    every = np.stack([s.off(points) for s in now])
    deep = float((every < -_INSIDE_M).any(axis=0).mean())
    off = np.abs(every).min(axis=0)
    if np.percentile(off, 90) > _TAIL_M or (off > _FAR_M).mean() > _FAR_PART or deep > _DEEP_PART:
        return []
    if any(_into(a, b) or _into(b, a) for a, b in itertools.combinations(now, 2)):
        return []
    nearest = np.argmin(np.abs(every), axis=0)
    found = [(s, np.flatnonzero(nearest == k)) for k, s in enumerate(now)]
    return found if all(_sound(s, points[i], points) for s, i in found) else []


def _sound(solid: Fit, own: Array, every: Array) -> bool:
    """Whether a solid is where its points are, and they cover its top."""
    if len(own) < _LEAST_PART or np.percentile(np.abs(solid.off(own)), 90) > _TAIL_M:
        return False
    return _bare(solid, every) < _BARE_PART


def _into(one: Fit, other: Fit) -> bool:
    """Whether one solid reaches deeply into another."""
    steps = np.linspace(-0.45, 0.45, 5)
    grid = np.array(list(itertools.product(steps, repeat=3))) * one.geometry.size_m
    grid = grid[distances(one.geometry, grid) < 0]
    return bool((other.off(grid @ one.rotation.T + np.asarray(one.xyz_m)) < -_INSIDE_M).mean() > _DEEP_PART)


def _again(solid: Fit, points: Array, support_m: float) -> Fit:
    """Fitted anew, standing as it does."""
    for way in orientations(solid.geometry):
        rest = solid.rotation @ np.array(way.turn).T
        if rest[2, 2] > 0.99:
            yaw = math.atan2(rest[1, 0], rest[0, 0])
            start = np.array([*solid.xyz_m[:2], support_m + way.extents_m[2] / 2, yaw])
            return fit(solid.geometry, way, start, points)
    raise AssertionError("a level solid stands in one of its ways")


def _corners(points: Array, left: Indices, support_m: float, known: list[Geometry]) -> list[Fit]:
    """The known solids that account best for points that are left when they are put into a corner of them, none of all
    the points being inside."""
    few = points[left][:: max(1, len(left) // _FEW)]
    every = points[:: max(1, len(points) // _FEW)]
    tries = sorted(
        ((_account(s, few, every), s) for s in _placed(points[left], few, support_m, known)), key=lambda t: -t[0]
    )
    best: dict[tuple[Geometry, bytes], tuple[float, Fit]] = {}
    for account, solid in tries[:_TRIED]:
        kept = account, solid
        for _ in range(2):
            near = few[np.abs(kept[1].off(few)) < 1.5 * _NEAR_M]
            if len(near) < _LEAST_PART // 4:
                break
            better = _again(kept[1], near, support_m)
            kept = max(kept, (_account(better, few, every), better), key=lambda t: t[0])
        score = kept[0] - 0.5 * len(few) * _bare(kept[1], every)
        pose = np.vstack([np.asarray(kept[1].xyz_m) / _ALIKE_M, np.abs(kept[1].rotation) * 3])
        where = (solid.geometry, np.round(pose).astype(np.int8).tobytes())
        if score > best.get(where, (0.0,))[0]:
            best[where] = score, kept[1]
    return [s for _, s in sorted(best.values(), key=lambda t: -t[0])]


def _placed(rest: Array, few: Array, support_m: float, known: list[Geometry]) -> Iterator[Fit]:
    """Known solids in the corners of the rectangles around points, in so far as they are as high as those."""
    for yaw in _directions(rest):
        turn = yaw_matrix(yaw)[:2, :2]
        flat = rest[:, :2] @ turn
        low, high = np.percentile(flat, (0.5, 99.5), axis=0)
        for geometry, way, quarter in _standing(known):
            extent = np.array(way.extents_m)[[1, 0] if quarter else [0, 1]]
            for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
                at = np.where(corner, high - extent / 2, low + extent / 2)
                there = rest[(np.abs(flat - at) < extent / 2).all(axis=1), 2]
                if len(there) < _LEAST_PART // 2 or abs(end_of(there) - support_m - way.extents_m[2]) > _HEIGHT_M:
                    continue
                centre = np.array([*(turn @ at), support_m + way.extents_m[2] / 2])
                rotation = yaw_matrix(yaw + (math.pi / 2 if quarter else 0.0)) @ np.array(way.turn)
                yield Fit.at(geometry, centre, rotation, few, level=True)


def _standing(known: list[Geometry]) -> Iterator[tuple[Geometry, Upright, bool]]:
    """Every way to stand, also turned by a quarter where that makes a difference."""
    for geometry in known:
        for way in orientations(geometry):
            yield geometry, way, False
            if not math.isclose(way.extents_m[0], way.extents_m[1]):
                yield geometry, way, True


def _account(solid: Fit, few: Array, every: Array) -> float:
    """How many points are on the surface of a solid, the nearer the more, less twice those deep inside."""
    on = np.maximum(0.0, 1 - (solid.off(few) / _NEAR_M) ** 2).sum()
    inside = (solid.off(every) < -_INSIDE_M).sum() * len(few) / len(every)
    return float(on - 2.0 * inside)


def _bare(solid: Fit, every: Array) -> float:
    """The part of a level solid's top, on a grid, over which there is no point."""
    size = np.asarray(solid.geometry.size_m)
    up = int(np.argmax(np.abs(solid.rotation[2])))
    flat = [i for i in range(3) if i != up]
    steps = np.linspace(-0.4, 0.4, 5) if solid.geometry.kind is Kind.BOX else np.linspace(-0.2, 0.2, 3)
    grid = np.array([(a, b) for a in steps for b in steps]) * size[flat]
    over = every[np.abs(every[:, 2] - solid.xyz_m[2] - size[up] / 2) < 2 * _NEAR_M, :2]
    if not len(over):
        return 1.0
    where = grid @ solid.rotation[:2, flat].T + np.asarray(solid.xyz_m[:2])
    return 1.0 - float((np.linalg.norm(where[:, None] - over[None], axis=2).min(axis=1) < 0.008).mean())


def _directions(points: Array) -> list[float]:
    """The yaws that sides of things may have: of the smallest rectangle, and of the longest sides of the hull."""
    found = [footprint(points).yaw_rad]
    hull = _hull(points)
    if hull is None:
        return found
    ring = points[hull.vertices, :2]
    sides = np.roll(ring, -1, axis=0) - ring
    for k in np.argsort(-np.linalg.norm(sides, axis=1), kind="stable")[:4]:
        yaw = math.atan2(sides[k, 1], sides[k, 0]) % (math.pi / 2)
        if all(abs(math.remainder(yaw - f, math.pi / 2)) > math.radians(4) for f in found):
            found.append(yaw)
    return found
