"""Colours as people name them: the eleven basic terms, by the nearest known example in CIELAB."""

from __future__ import annotations

import importlib.resources
from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["colour_distances", "lab_of", "lit_colour", "term_of"]

Array = NDArray[np.float64]

_BLACK_TO, _WHITE_FROM = 40, 215
"""Of the neutral axis (0 to 255)."""
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
    hexes += [
        ("black" if v <= _BLACK_TO else "white" if v >= _WHITE_FROM else "grey", bytes((v, v, v)))
        for v in range(0, 256, 3)
    ]
    return tuple(term for term, _ in hexes), lab_of(np.array([list(h) for _, h in hexes]) / 255)


def term_of(rgb: Array) -> str:
    """The basic term for a colour (3 numbers, sRGB in [0, 1])."""
    terms, labs = _examples()
    return terms[int(np.argmin(np.linalg.norm(labs - lab_of(rgb[None]), axis=1)))]


def lit_colour(rgb: Array) -> Array:
    """The colour of a thing from its points (N x 3): the median of the lightest fifth, which faces the light."""
    light = rgb.sum(axis=1)
    return np.asarray(np.median(rgb[light >= np.percentile(light, 80)], axis=0))


def colour_distances(a: Array, b: Array) -> Array:
    """How far colours (N x 3, sRGB) are from one (3 numbers) in CIELAB, lightness counting half."""
    difference = lab_of(b) - lab_of(a[None])
    return np.asarray(np.linalg.norm(difference * (_LIGHTNESS_WEIGHT, 1.0, 1.0), axis=1))
