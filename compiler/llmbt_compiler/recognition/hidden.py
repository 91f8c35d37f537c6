"""Where a thing can be of which a part is hidden: what is seen ends where the thing ends, or where something hides it.

Of the places that explain the seen part equally well, one is likelier that has something beside its hidden part, and
one is wrong that reaches to where other points were seen: a neighbour's, or those of the surface that it stands on.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from llmbt_compiler.recognition.solids import Fit, yaw_matrix

__all__ = ["Surroundings", "ends", "starts"]

Array = NDArray[np.float64]

_HIDDEN_M = 0.007
"""What is longer than is seen by more than this is partly hidden."""
_BAND_M, _BANDS = 0.006, 1.5
_OWN_M = 0.005
_BESIDE_M, _ABOVE_SUPPORT_M = 0.06, 0.02
_WITHIN_M, _NO_HIGHER_M = 0.003, 0.006
_SCREEN_POINTS, _WITHIN_POINTS = 20, 20
_PER_OPEN_M, _OFF_WITHIN_M = 0.1, 0.002
"""How much worse a place is, in metres that its points were off: for each metre hidden by nothing, and with so many
points of others within."""


def ends(along: Array) -> tuple[float, float]:
    """Where a thing begins and ends along a direction, by points on it that are off by noise."""
    return -_end(-along), _end(along)


def _end(along: Array) -> float:
    """Amid the last points where they crowd, which is a face; else as far beyond a line close to the end as the number
    of points there takes at the density before it."""
    line = float(np.percentile(along, 99.5)) - _BAND_M
    beyond = along[along > line]
    dense = int(((along > line - _BANDS * _BAND_M) & (along <= line)).sum()) / _BANDS
    return line + _BAND_M * len(beyond) / dense if len(beyond) < dense else float(np.median(beyond))


def starts(points: Array, yaw: float, flat: tuple[float, float]) -> Iterator[tuple[float, float]]:
    """Where the middle may be of what is `flat` along the axes of a yaw and longer than the points reach: so that it
    ends where they do, at the one side or at the other. Nothing where it is no longer."""
    turn = yaw_matrix(yaw)[:2, :2]
    choices, hidden = [], False
    for along, size in zip((points[:, :2] @ turn).T, flat, strict=True):
        low, high = ends(along)
        partly = size - (high - low) > _HIDDEN_M
        choices.append((high - size / 2, low + size / 2) if partly else ((low + high) / 2,))
        hidden |= partly
    for at in itertools.product(*choices) if hidden else ():
        x, y = turn @ np.array(at)
        yield float(x), float(y)


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """Points beside those of a thing (N x 3, world), and the height of what it stands on."""

    points: Array
    support_m: float

    @staticmethod
    def of(own: Array, support_m: float, every: Array) -> Surroundings:
        """Of all points those that are near, but are not the thing's own."""
        low, high = own[:, :2].min(axis=0) - 2 * _BESIDE_M, own[:, :2].max(axis=0) + 2 * _BESIDE_M
        near = every[((every[:, :2] > low) & (every[:, :2] < high)).all(axis=1)]
        away, _ = cKDTree(own).query(near, distance_upper_bound=_OWN_M)
        return Surroundings(near[np.isinf(away)], support_m)

    def against(self, solid: Fit, own: Array) -> float:
        """What speaks against a level solid that some points are seen of: so far, in metres, it counts as off."""
        up = int(np.argmax(np.abs(solid.rotation[2])))
        flat = [i for i in range(3) if i != up]
        half = np.asarray(solid.geometry.size_m)[flat] / 2
        seen, others = ((p[:, :2] - solid.xyz_m[:2]) @ solid.rotation[:2, flat] for p in (own, self.points))
        z = self.points[:, 2] - self.support_m
        inside = (np.abs(others) < half - _WITHIN_M).all(axis=1)
        inside &= (z > -_NO_HIGHER_M) & (z < solid.geometry.size_m[up] - _NO_HIGHER_M)
        cost = _OFF_WITHIN_M * min(1.0, int(inside.sum()) / _WITHIN_POINTS)
        for axis in (0, 1):
            aside = (z > _ABOVE_SUPPORT_M) & (np.abs(others[:, 1 - axis]) < half[1 - axis])
            low, high = ends(seen[:, axis])
            for sign, end in ((-1, -low), (1, high)):
                out = sign * others[aside, axis] - half[axis]
                if int(((out > -_WITHIN_M) & (out < _BESIDE_M)).sum()) < _SCREEN_POINTS:
                    cost += _PER_OPEN_M * max(0.0, float(half[axis]) - end - _HIDDEN_M / 2)
        return cost
