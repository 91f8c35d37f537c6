"""Ways for a round platform over the floor: a grid of what is clear, and routes on it. World frame, metres."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.scene import PLATFORM_RADIUS_M, Body, Fixture, Scene
from llmbt_runtime.bullet.bodies import BodyState

__all__ = ["MARGIN_M", "Floor", "Footprint", "footprint_of", "footprints_of_fixtures"]

Array = NDArray[np.float64]
Point = tuple[float, float]

MARGIN_M = 0.03
"""The platform keeps so far away from everything, but at a docking pose or where it is close already."""
_DOCK_MARGIN_M = 0.012
_CELL_M = 0.05
_AROUND_M = 0.9
"""The floor goes on so far beyond what stands on it."""
_TALL_M, _TALL_RADIUS_M = 0.80, 0.55
"""What is taller would be met by the arm and what it carries, which reach out over the platform."""
_CLOSE_M = 0.06
"""It may leave a place that is closer to something than the margin, by the nearest point that is not."""
_SIGHT_M = 0.02


@dataclass(frozen=True, slots=True)
class Footprint:
    """What something takes of the floor: an upright box, turned about the vertical."""

    id: str
    xy_m: Point
    half_m: Point
    yaw_rad: float = 0.0
    top_m: float = 0.0

    def distance(self, x: Array, y: Array) -> Array:
        """How far points are from it; 0 within."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        dx, dy = x - self.xy_m[0], y - self.xy_m[1]
        along = np.abs(c * dx + s * dy) - self.half_m[0]
        across = np.abs(-s * dx + c * dy) - self.half_m[1]
        return np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))


def footprints_of_fixtures(fixtures: Iterable[Fixture]) -> tuple[Footprint, ...]:
    """Those of a scene's fixtures."""
    return tuple(
        Footprint(f.id, f.xyz_m[:2], (f.size_m[0] / 2, f.size_m[1] / 2), 0.0, f.top_m)
        for f in fixtures
        if f.top_m > 0.005
    )


def footprint_of(body: Body, state: BodyState) -> Footprint:
    """That of a movable body: an upright one as it stands, any other by its bounding box."""
    x, y, _ = state.xyz
    if abs(state.axes[2][2]) > 0.999 and body.shape != "sphere":
        yaw = math.atan2(state.axes[1][0], state.axes[0][0])
        return Footprint(body.id, (x, y), (body.size_m[0] / 2, body.size_m[1] / 2), yaw, state.extent.top_m)
    return Footprint(body.id, (x, y), state.extent.half[:2], 0.0, state.extent.top_m)


@dataclass(frozen=True)
class Floor:
    """The floor with what stands on it. Immutable: another world is another floor."""

    things: tuple[Footprint, ...]
    low_m: Point = field(default=(-1.0, -1.0))
    high_m: Point = field(default=(1.0, 1.0))

    @classmethod
    def of(cls, scene: Scene, bodies: Sequence[Footprint] = ()) -> Floor:
        """The floor of a scene, as far as anything stands on it and a bit further."""
        fixed = footprints_of_fixtures(scene.fixtures)
        corners = [(f.xy_m[i] - f.half_m[i], f.xy_m[i] + f.half_m[i]) for f in fixed for i in (0, 1)]
        spans = [corners[i::2] or [(0.0, 0.0)] for i in (0, 1)]
        robot = scene.robot_xyz_m
        low = [min(robot[i], *(a for a, _ in spans[i])) - _AROUND_M for i in (0, 1)]
        high = [max(robot[i], *(b for _, b in spans[i])) + _AROUND_M for i in (0, 1)]
        return cls((*fixed, *bodies), (low[0], low[1]), (high[0], high[1]))

    def without(self, *ids: str) -> Floor:
        """The floor with some things taken away."""
        return Floor(tuple(t for t in self.things if t.id not in ids), self.low_m, self.high_m)

    def with_(self, thing: Footprint) -> Floor:
        """The floor with one more thing on it."""
        return Floor((*self.things, thing), self.low_m, self.high_m)

    def bare(self, there: Footprint) -> bool:
        """Whether nothing stands within the circle around a footprint, and it is on the floor that is known."""
        radius, (x, y) = math.hypot(*there.half_m), there.xy_m
        point = np.array([x]), np.array([y])
        return self._inside((x, y)) and all(float(t.distance(*point)[0]) > radius for t in self.things)

    def room(self, x: Array, y: Array, *, low_only: bool = False) -> Array:
        """By how much a platform at points is clear of everything (negative: it is not); metres."""
        room = np.full(np.shape(x), 10.0)
        for thing in self.things:
            distance = thing.distance(x, y)
            room = np.minimum(room, distance - PLATFORM_RADIUS_M)
            if thing.top_m > _TALL_M and not low_only:
                room = np.minimum(room, distance - _TALL_RADIUS_M + MARGIN_M)
        return room

    def stands(self, at: Point) -> bool:
        """Whether a platform can stand there, as close as at a docking pose."""
        room = self.room(np.array([at[0]]), np.array([at[1]]), low_only=True)
        return bool(room[0] >= _DOCK_MARGIN_M) and self._inside(at)

    def _inside(self, at: Point) -> bool:
        return all(low < v < high for low, v, high in zip(self.low_m, at, self.high_m, strict=True))

    # -- the grid ---------------------------------------------------------------------------------------------------

    @cached_property
    def _axes(self) -> tuple[Array, Array]:
        return (
            np.arange(self.low_m[0], self.high_m[0], _CELL_M),
            np.arange(self.low_m[1], self.high_m[1], _CELL_M),
        )

    @cached_property
    def _room(self) -> Array:
        gx, gy = np.meshgrid(*self._axes, indexing="ij")
        return self.room(gx, gy)

    @cached_property
    def _parts(self) -> NDArray[np.int32]:
        """The number of the connected part of the clear floor that a cell belongs to; 0 where it is not clear."""
        from scipy.ndimage import label

        found: NDArray[np.int32] = label(self._room >= MARGIN_M)[0]
        return found

    def _cell(self, at: Point) -> tuple[int, int]:
        """The clear cell nearest to a point, if there is one close by; else the cell that it is in."""
        xs, ys = self._axes
        i = int(np.clip(round((at[0] - self.low_m[0]) / _CELL_M), 0, len(xs) - 1))
        j = int(np.clip(round((at[1] - self.low_m[1]) / _CELL_M), 0, len(ys) - 1))
        if self._room[i, j] >= MARGIN_M:
            return i, j
        n = math.ceil(2 * _CLOSE_M / _CELL_M)
        near = [
            (math.hypot(xs[a] - at[0], ys[b] - at[1]), a, b)
            for a in range(max(0, i - n), min(len(xs), i + n + 1))
            for b in range(max(0, j - n), min(len(ys), j + n + 1))
            if self._room[a, b] >= MARGIN_M
        ]
        return min(near)[1:] if near else (i, j)

    def part(self, at: Point) -> int:
        """The number of the part of the clear floor that a point belongs to; 0 for none."""
        return int(self._parts[self._cell(at)])

    def connected(self, start: Point, end: Point) -> bool:
        """Whether there is a way."""
        return self.stands(end) and self.part(start) == self.part(end) != 0

    # -- routes -----------------------------------------------------------------------------------------------------

    def route(self, start: Point, end: Point) -> list[Point] | None:
        """The corners of a way from one point to another, both included; None where there is none."""
        if math.dist(start, end) < 1e-6:
            return [start, end]
        if not self.connected(start, end):
            return None
        from skimage.graph import route_through_array

        costs = np.where(self._room >= MARGIN_M, 1.0 + np.clip(0.25 - self._room, 0.0, 0.25) * 4, -1.0)
        ends = self._cell(start), self._cell(end)
        cells, _ = route_through_array(costs, *ends, fully_connected=True, geometric=True)  # type: ignore[no-untyped-call]
        xs, ys = self._axes
        points = [start, *((float(xs[i]), float(ys[j])) for i, j in cells), end]
        return self._straightened(points)

    def _straightened(self, points: list[Point]) -> list[Point]:
        """Without the corners that are not needed: from each point on to the furthest that it sees."""
        found, at = [points[0]], 0
        while at < len(points) - 1:
            to = next((k for k in range(len(points) - 1, at + 1, -1) if self.sees(points[at], points[k])), at + 1)
            found.append(points[to])
            at = to
        return found

    def sees(self, a: Point, b: Point) -> bool:
        """Whether the straight way is clear by the margin, or by no less than what its ends have."""
        n = max(2, math.ceil(math.dist(a, b) / _SIGHT_M))
        s = np.linspace(0.0, 1.0, n)
        room = self.room(a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]))
        close = np.minimum(s, 1 - s) * math.dist(a, b) < _CLOSE_M + MARGIN_M
        least = min(MARGIN_M, float(room[0]), float(room[-1]))
        return bool(np.all(room[~close] >= MARGIN_M - 1e-9) and np.all(room[close] >= least - 1e-6))
