"""Which thing is which: detections to the ids that a scene declares, by attributes first, then by where they were."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from llmbt_compiler.recognition.candidates import OTHER_COLOUR, Candidate, colour_off
from llmbt_compiler.recognition.detect import Detection
from llmbt_compiler.recognition.solids import Fit, Geometry, Kind

__all__ = ["identify", "shape_word"]

_PER_COLOUR, _PER_METRE_ROOT = 0.2, 6.0
_NO_POSITION_M = 0.5
"""A thing that was nowhere counts as having been so far away."""
_UNLIKELY = 1.0
"""Of a parked obstacle, against a thing that the scene has in play."""
_LEFT_OVER = 60.0
_CUBE = 0.88


def identify(seen: Sequence[Detection], known: Sequence[Candidate]) -> list[tuple[Fit, Candidate | None]]:
    """For each detection its candidate and how that one fits, or None and the measured solid.

    The assignment of least cost: how well size and shape agree, how far colours differ, and the root of how far things
    would have moved, so that one thing moved far is likelier than two a little.
    """
    if not seen:
        return []
    cost = np.full((len(seen), len(known) + len(seen)), _LEFT_OVER)
    for i, d in enumerate(seen):
        for k, c in enumerate(known):
            cost[i, k] = _cost(d, c)
    rows, columns = linear_sum_assignment(np.minimum(cost, 1e6))
    found: list[tuple[Fit, Candidate | None]] = []
    for i, k in zip(rows.tolist(), columns.tolist(), strict=True):
        match = known[k] if k < len(known) and cost[i, k] < _LEFT_OVER else None
        fit = _fit_of(seen[i], match) if match is not None else None
        found.append((fit, match) if fit is not None else (seen[i].measured, None))
    return found


def _fit_of(d: Detection, c: Candidate) -> Fit | None:
    return next((f for f in d.fits if f.geometry == c.geometry), None)


def _cost(d: Detection, c: Candidate) -> float:
    fit = _fit_of(d, c)
    if fit is None:
        return math.inf
    best = d.best
    rank = 1e3 * max(0.0, fit.off_m - best.off_m) + (0.5 if fit is not best else 0.0)
    off = colour_off(c, d.rgb, d.term)
    colour = math.inf if off > OTHER_COLOUR else _PER_COLOUR * off
    moved = _NO_POSITION_M if c.last_m is None else math.dist(c.last_m, fit.xyz_m)
    where = 0.0 if d.held and c.held else _PER_METRE_ROOT * math.sqrt(moved)
    return rank + colour + where + (0.0 if c.likely else _UNLIKELY)


def shape_word(geometry: Geometry) -> str:
    """What a measured solid is called: a box of equal sides is a cube."""
    if geometry.kind is not Kind.BOX:
        return geometry.kind.value
    return "cube" if min(geometry.size_m) > _CUBE * max(geometry.size_m) else "box"
