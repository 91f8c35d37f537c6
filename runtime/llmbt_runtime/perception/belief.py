"""What is known of each thing: where it was seen, or that nobody knows where it is. Pure.

What is not seen is unknown, not false. A thing that was seen and is not found again keeps its place as long as
something hides that place, or the picture does not contradict it; once one looks past where it was, it is `UNSEEN`.
Only after every view was looked at without it is it `GONE`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.semantic_map import MapObject, SemanticMap
from llmbt_runtime.perception.rgbd import RgbdImage, project

__all__ = ["Sight", "Standing", "Thing", "looked_for", "revised", "sight_of"]

Array = NDArray[np.float64]

_TOLERANCE_M = 0.02
_ENOUGH = 4
_INSET = 0.8


class Standing(StrEnum):
    """How a thing is known."""

    SEEN = "SEEN"
    HIDDEN = "HIDDEN"
    UNSEEN = "UNSEEN"
    GONE = "GONE"


class Sight(StrEnum):
    """What pictures say of a place where a thing was."""

    THERE = "THERE"
    HIDDEN = "HIDDEN"
    PAST = "PAST"


@dataclass(frozen=True, slots=True)
class Thing:
    """A thing with how it is known: `last` is how it was seen last, None where it never was."""

    standing: Standing
    last: MapObject | None = None

    @property
    def located(self) -> bool:
        """Whether it is known where it is."""
        return self.standing in (Standing.SEEN, Standing.HIDDEN) and self.last is not None


def revised(before: Mapping[str, Thing], found: SemanticMap, sight: Callable[[MapObject], Sight]) -> dict[str, Thing]:
    """What is known after a look: `found` is the map of what was recognised, `sight` what the pictures say of the place
    of a thing that was not."""
    seen = {o.id: Thing(Standing.SEEN, o) for o in found.objects}
    kept = {}
    for id_, thing in before.items():
        if id_ in seen:
            continue
        if thing.located and thing.last is not None:
            past = sight(thing.last) is Sight.PAST
            kept[id_] = replace(thing, standing=Standing.UNSEEN if past else Standing.HIDDEN)
        else:
            kept[id_] = thing
    return {**kept, **seen}


def looked_for(things: Mapping[str, Thing], id_: str) -> dict[str, Thing]:
    """What is known once every view was looked at for a thing: one that is still unseen is gone."""
    thing = things.get(id_)
    if thing is None or thing.standing is not Standing.UNSEEN:
        return dict(things)
    return {**things, id_: replace(thing, standing=Standing.GONE)}


def sight_of(thing: MapObject, images: tuple[RgbdImage, ...]) -> Sight:
    """What pictures say of the place of a thing: past how many of its points one sees, and where something is."""
    points = _points(thing)
    past, there = np.zeros(len(points), dtype=bool), np.zeros(len(points), dtype=bool)
    for image in images:
        height, width = image.depth_m.shape
        pixels, depth = project(image.camera, points, width, height)
        inside = pixels[:, 0] >= 0
        seen = np.full(len(points), -np.inf)
        seen[inside] = image.depth_m[pixels[inside, 1], pixels[inside, 0]]
        past |= inside & (seen > depth + _TOLERANCE_M)
        there |= inside & (np.abs(seen - depth) <= _TOLERANCE_M)
    if int((past & ~there).sum()) >= _ENOUGH and past.sum() > there.sum():
        return Sight.PAST
    return Sight.THERE if there.sum() >= _ENOUGH else Sight.HIDDEN


def _points(thing: MapObject) -> Array:
    """Corners, and the middles of the faces, of the thing's box, a little inside (15 x 3, world)."""
    grid = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)], dtype=np.float64)
    grid = grid[np.isin(np.abs(grid).sum(axis=1), (1, 3))]
    local = grid * np.asarray(thing.size_m) / 2 * _INSET
    return np.asarray(local @ _rotation(thing.pose.quat_xyzw).T + np.asarray(thing.pose.xyz_m))


def _rotation(quat_xyzw: tuple[float, float, float, float]) -> Array:
    x, y, z, w = quat_xyzw
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
