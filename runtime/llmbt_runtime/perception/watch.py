"""Noticing that something has changed, from small pictures: the background of each camera, pixel by pixel."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from llmbt_runtime.perception.rgbd import RgbdImage, points_of

__all__ = ["Box", "Watch"]

Array = NDArray[np.float64]

_DEPTH_M, _COLOUR = 0.012, 40
"""A pixel has changed when its depth or a colour (0 to 255) is off by more than this: eight deviations of the noise."""
_PIXELS = 4
_ROBOT_M = 0.03
_BEYOND_M = 1e3


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """An axis-aligned box of the world in which nothing counts."""

    low_m: Array
    high_m: Array


@dataclass
class Watch:
    """Keeps for each camera what its pixels last showed that was not the robot's; NaN where that is nothing yet."""

    _depth: dict[str, Array] = field(default_factory=dict)
    _rgb: dict[str, NDArray[np.int16]] = field(default_factory=dict)

    def changed(self, images: Iterable[RgbdImage], robot: Iterable[Array], but: Iterable[Box] = ()) -> bool:
        """Whether more than a few pixels show something else than before, the robot's and those of boxes aside. What is
        shown now is what the next pictures are compared with."""
        boxes = [Box(v.min(axis=0) - _ROBOT_M, v.max(axis=0) + _ROBOT_M) for v in robot]
        boxes += but
        changed = [self._one(image, boxes) for image in images]
        return any(changed)

    def _one(self, image: RgbdImage, boxes: list[Box]) -> bool:
        key = image.camera.id
        if key not in self._depth:
            self._depth[key] = np.full(image.depth_m.shape, np.nan)
            self._rgb[key] = np.zeros(image.rgb.shape, dtype=np.int16)
        before, colours = self._depth[key], self._rgb[key]
        depth, rgb = np.minimum(image.depth_m, _BEYOND_M), image.rgb.astype(np.int16)
        with np.errstate(invalid="ignore"):
            other = (np.abs(depth - before) > _DEPTH_M) | (np.abs(rgb - colours).max(axis=2) > _COLOUR)
        new = np.isnan(before)
        v, u = np.nonzero(other | new)
        mine = _within_any(points_of(image, u, v), boxes)
        v, u = v[~mine], u[~mine]
        count = int((~new[v, u]).sum())
        before[v, u], colours[v, u] = depth[v, u], rgb[v, u]
        return count > _PIXELS


def _within_any(points: Array, boxes: list[Box]) -> NDArray[np.bool_]:
    found = np.zeros(len(points), dtype=bool)
    for box in boxes:
        x, y, z = points.T
        (a, b, c), (d, e, f) = box.low_m, box.high_m
        found |= (x >= a) & (x <= d) & (y >= b) & (y <= e) & (z >= c) & (z <= f)
    return found
