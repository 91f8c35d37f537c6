"""Colours as people name them: the eleven basic terms, by the nearest known examples in CIELAB."""

from __future__ import annotations

import importlib.resources
import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["colour_distances", "lab_of", "lit_colour", "term_of"]

Array = NDArray[np.float64]

_NEUTRAL, _BLACK_TO, _WHITE_FROM = 8.0, 15.0, 85.0
"""Below this chroma a colour is black, grey or white, by its lightness."""
_VOTES = 3
_LIGHTNESS_WEIGHT = 0.5
"""Of a difference in lightness between a thing and what it is declared as: how light it looks depends on the lamp."""
_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_WHITE = np.array([0.95047, 1.0, 1.08883])


def lab_of(rgb: Array) -> Array:
    """CIELAB (D65) of sRGB in [0, 1]; N x 3 to N x 3."""
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = linear @ _TO_XYZ.T / _WHITE
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.column_stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])])


@cache
def _examples() -> tuple[tuple[str, ...], Array]:
    """The terms of the known examples, and their CIELAB (N x 3)."""
    text = (importlib.resources.files("llmbt_compiler.recognition") / "colour_terms.txt").read_text("ascii")
    rows = [line.split() for line in text.splitlines() if not line.startswith("#")]
    hexes = [(term, bytes.fromhex(h)) for term, *several in rows for h in several]
    return tuple(term for term, _ in hexes), lab_of(np.array([list(h) for _, h in hexes]) / 255)


def term_of(rgb: Array) -> str:
    """The basic term for a colour (3 numbers, sRGB in [0, 1]): that of most of the three nearest examples, the nearer
    the more; black, grey or white where it has next to no chroma."""
    lab = lab_of(rgb[None])[0]
    if math.hypot(lab[1], lab[2]) < _NEUTRAL:
        return "black" if lab[0] < _BLACK_TO else "white" if lab[0] >= _WHITE_FROM else "grey"
    terms, labs = _examples()
    off = np.linalg.norm(labs - lab, axis=1)
    votes: dict[str, float] = {}
    for k in np.argsort(off, kind="stable")[:_VOTES].tolist():
        votes[terms[k]] = votes.get(terms[k], 0.0) + 1 / (off[k] + 1)
    return max(votes, key=lambda term: votes[term])


def lit_colour(rgb: Array) -> Array:
    """The colour of a thing from its points (N x 3): the median of the lightest fifth, which faces the light."""
    light = rgb.sum(axis=1)
    return np.asarray(np.median(rgb[light >= np.percentile(light, 80)], axis=0))


def colour_distances(a: Array, b: Array) -> Array:
    """How far colours (N x 3, sRGB) are from one (3 numbers), lightness counting half: the difference of CIE 1994, in
    which a paler shade is near and another hue is far."""
    one, others = lab_of(a[None]), lab_of(b)
    chroma, chromas = np.hypot(one[:, 1], one[:, 2]), np.hypot(others[:, 1], others[:, 2])
    mean, paler = np.sqrt(chroma * chromas), chromas - chroma
    hue = np.sqrt(np.maximum(((others[:, 1:] - one[:, 1:]) ** 2).sum(axis=1) - paler**2, 0.0))
    lighter = _LIGHTNESS_WEIGHT * (others[:, 0] - one[:, 0])
    terms = np.column_stack([lighter, paler / (1 + 0.045 * mean), hue / (1 + 0.015 * mean)])
    return np.asarray(np.linalg.norm(terms, axis=1))
