"""From a cluster to detections: what it is by itself, and which known geometries it may be."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.candidates import Candidate, may_be_in
from llmbt_compiler.recognition.colour import lit_colour, term_of
from llmbt_compiler.recognition.explain import explain
from llmbt_compiler.recognition.measure import measure, support_under
from llmbt_compiler.recognition.registration import register
from llmbt_compiler.recognition.solids import Fit
from llmbt_compiler.recognition.split import split
from llmbt_ir.capture import Gripper, PointCloud
from llmbt_ir.scene import Scene

__all__ = ["Detection", "detect"]

Array = NDArray[np.float64]

_POOR_TAIL_M = 0.0035
_REGISTERED_TAIL_M = 0.0045
_AT_TIP_M = 0.012


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """One thing that is seen. `measured`: by itself; `fits`: as a thing of known geometry, the likeliest first.

    `rgb`: its colour in the light, `term` what people call it. `held`: it is between the fingers, which grip.
    """

    measured: Fit
    fits: tuple[Fit, ...]
    rgb: Array
    term: str
    held: bool
    points: int

    @property
    def best(self) -> Fit:
        """The likeliest."""
        return self.fits[0] if self.fits else self.measured


def detect(cluster: PointCloud, scene: Scene, known: Sequence[Candidate], gripper: Gripper | None) -> list[Detection]:
    """What a cluster shows: one thing, or several of known geometry and colour that touch."""
    xyz = cluster.xyz_m
    held = gripper is not None and gripper.gripping and _at(gripper, xyz)
    support = None if held else support_under(xyz, scene)
    measured = measure(xyz, support)
    stock = Counter(c.geometry for c in known if may_be_in(c, cluster.rgb))
    fits = explain(xyz, measured, support, stock)
    if fits:
        return [_seen(cluster, tuple(fits), measured, held=held)]
    several = split(xyz, support, stock)
    if several:
        return [_seen(cluster.take(i), (f,), f, held=False) for f, i in several]
    if measured.tail_m > _POOR_TAIL_M:
        tried = (register(xyz, g) for g in stock)
        fits = sorted((f for f in tried if f.tail_m <= _REGISTERED_TAIL_M), key=lambda f: f.off_m)
    return [_seen(cluster, tuple(fits), measured, held=held)]


def _seen(cluster: PointCloud, fits: tuple[Fit, ...], measured: Fit, *, held: bool) -> Detection:
    rgb = lit_colour(cluster.rgb)
    return Detection(measured, fits, rgb, term_of(rgb), held, len(cluster))


def _at(gripper: Gripper, points: Array) -> bool:
    """Whether points are about the tip of the hand: it lies within them, or they begin close by."""
    tip = np.asarray(gripper.tip.xyz_m)
    low, high = np.percentile(points, (2, 98), axis=0)
    return bool((tip > low - _AT_TIP_M).all() and (tip < high + _AT_TIP_M).all())
