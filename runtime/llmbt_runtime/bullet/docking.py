"""Where the robot stands to reach a place or a thing: poses of the base that inverse kinematics proves.

A docking pose of a place reaches all of it, just above its surface and high enough to come from above; nothing that
is fixed is in the way of the arm there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Scene, ScenePlace
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.kinematics import solve
from llmbt_runtime.bullet.navigation import Floor, Point

__all__ = ["Docks", "around", "find_docks"]

_STEP_M = 0.05
_OUT_M = 0.85
_LOWEST_M, _HIGH_M = 0.015, 0.32
_NEAREST_M = 0.30
_EDGE_M = 0.03
"""Things are put down no nearer to a region's edge."""
_APART_M = 0.30
_MOST = 4
_TRIED = 40
_RINGS_M = (0.48, 0.42, 0.55, 0.36, 0.62)
_SIDES = 24


@dataclass(frozen=True)
class Docks:
    """The docking poses of each place that is driven to, the handiest first."""

    of: dict[str, tuple[BasePose, ...]]

    def __getitem__(self, place: str) -> tuple[BasePose, ...]:
        return self.of.get(place, ())


def find_docks(scene: Scene, approach: Approach, *, only: str | None = None) -> Docks:
    """The docking poses of a scene's places (or of one), with its fixtures where they are and nothing in the way."""
    floor = Floor.of(scene)
    found: dict[str, tuple[BasePose, ...]] = {}
    for place in scene.places:
        if place.surface_m is None or place.is_slot or only not in (None, place.id):
            continue
        taken = [(d.x_m, d.y_m) for docks in found.values() for d in docks]
        found[place.id] = tuple(_docks_of(place, scene, approach, floor, taken))
    return Docks(found)


def _samples(place: ScenePlace) -> list[tuple[float, float]]:
    assert place.surface_m is not None
    x, y, _ = place.surface_m
    hx, hy = (max(0.0, s / 2 - _EDGE_M) for s in place.size_m)
    return [(x + i * hx, y + j * hy) for i in (-1, 0, 1) for j in (-1, 0, 1)]


def _docks_of(
    place: ScenePlace, scene: Scene, approach: Approach, floor: Floor, taken: list[Point]
) -> Iterator[BasePose]:
    assert place.surface_m is not None
    x, y, z = place.surface_m
    height = scene.robot_xyz_m[2]
    out = max(place.size_m) / 2 + _OUT_M
    n = int(out / _STEP_M)
    gx, gy = (a.ravel() for a in np.meshgrid(x + np.arange(-n, n + 1) * _STEP_M, y + np.arange(-n, n + 1) * _STEP_M))
    samples = _samples(place)
    reach = np.array([np.hypot(gx - sx, gy - sy) for sx, sy in samples])
    ok = (reach.min(axis=0) >= _NEAREST_M) & (floor.room(gx, gy, low_only=True) >= 0.02)
    for dz in (_LOWEST_M, _HIGH_M):
        furthest, nearest = reach.max(axis=0), reach.min(axis=0)
        for r in (furthest, nearest):
            q = solve(r, np.zeros_like(r), np.full_like(r, z + dz - height), np.full_like(r, math.pi / 2))
            ok &= ~np.isnan(q[:, 0])
    order = np.lexsort((gy, gx, np.round(np.abs(reach).max(axis=0), 3)))
    index = [int(i) for i in order if ok[i]]
    chosen: list[Point] = []
    tried = 0
    for i in index:
        at = (float(gx[i]), float(gy[i]))
        if len(chosen) == _MOST or tried == _TRIED:
            return
        if any(math.dist(at, other) < _APART_M for other in (*chosen, *taken)):
            continue
        tried += 1
        pose = BasePose(*at, height, math.atan2(y - at[1], x - at[0]))
        if approach.reaches(pose, [(sx, sy, z + dz) for sx, sy in samples for dz in (_LOWEST_M, _HIGH_M)]):
            chosen.append(at)
            yield pose


def around(thing: Vec3, height_m: float, floor: Floor, start: Point) -> Iterator[BasePose]:
    """Poses of the base from which a thing is within reach, and to which there is a way, the nearest first."""
    found = []
    for ring, away in enumerate(_RINGS_M):
        for k in range(_SIDES):
            angle = 2 * math.pi * k / _SIDES
            at = (thing[0] - away * math.cos(angle), thing[1] - away * math.sin(angle))
            if floor.connected(start, at):
                found.append((ring, round(math.dist(at, start), 3), at, angle))
    for _, _, at, angle in sorted(found):
        yield BasePose(*at, height_m, angle)
