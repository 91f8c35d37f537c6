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
from llmbt_ir.capture import Capture, Gripper, PointCloud
from llmbt_ir.scene import ROBOT_FOOTPRINT_M, Scene

__all__ = ["Detection", "detect", "without_fragments"]

Array = NDArray[np.float64]

_POOR_TAIL_M = 0.0035
_REGISTERED_TAIL_M = 0.0045
_AT_TIP_M = 0.012
_ON_SURFACE_M, _MOSTLY = 0.006, 0.8


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """One thing that is seen. `measured`: by itself; `fits`: as a thing of known geometry, the likeliest first.

    `rgb`: its colour in the light, `term` what people call it, empty where no colour was seen. `held`: it is between
    the fingers, which grip.
    """

    measured: Fit
    fits: tuple[Fit, ...]
    rgb: Array
    term: str
    held: bool
    cloud: PointCloud

    @property
    def best(self) -> Fit:
        """The likeliest."""
        return self.fits[0] if self.fits else self.measured


def detect(
    cluster: PointCloud, scene: Scene, known: Sequence[Candidate], capture: Capture, every: Array
) -> list[Detection]:
    """What a cluster of a capture shows: one thing, or several of known geometry and colour that touch. `every`: all
    points about, those of fixtures among them."""
    xyz, gripper = cluster.xyz_m, capture.gripper
    held = gripper is not None and gripper.gripping and _at(gripper, xyz)
    support = None if held else support_under(xyz, scene)
    if not capture.robot and not held and (support is None or _at_base(xyz, scene)):
        return []  # the robot, whose joints nobody has told
    measured = measure(xyz, support)
    stock = Counter(c.geometry for c in known if not capture.coloured or may_be_in(c, cluster.rgb))
    fits = explain(xyz, measured, support, stock, every)
    if fits:
        return [_seen(cluster, tuple(fits), measured, capture, held=held)]
    several = split(xyz, support, stock)
    if several:
        return [_seen(cluster.take(i), (f,), f, capture, held=False) for f, i in several]
    if measured.tail_m > _POOR_TAIL_M:
        tried = (register(xyz, g) for g in stock)
        fits = sorted((f for f in tried if f.tail_m <= _REGISTERED_TAIL_M), key=lambda f: f.off_m)
    return [_seen(cluster, tuple(fits), measured, capture, held=held)]


def _seen(cluster: PointCloud, fits: tuple[Fit, ...], measured: Fit, capture: Capture, *, held: bool) -> Detection:
    rgb = lit_colour(cluster.rgb)
    return Detection(measured, fits, rgb, term_of(rgb) if capture.coloured else "", held, cluster)


def without_fragments(seen: Sequence[Detection]) -> list[Detection]:
    """Without those whose points lie on a larger one: a thing half hidden may come in pieces."""
    by_size = sorted(range(len(seen)), key=lambda k: -len(seen[k].cloud))
    kept: list[int] = []
    for k in by_size:
        xyz = seen[k].cloud.xyz_m
        if not any((np.abs(seen[j].best.off(xyz)) < _ON_SURFACE_M).mean() > _MOSTLY for j in kept):
            kept.append(k)
    return [seen[k] for k in sorted(kept)]


def _at_base(points: Array, scene: Scene) -> bool:
    """Whether points are over the robot's base."""
    x, y, z = scene.robot_xyz_m
    half = np.asarray(ROBOT_FOOTPRINT_M[:2]) / 2
    return bool(((np.abs(points[:, :2] - (x, y)) < half).all(axis=1) & (points[:, 2] > z)).any())


def _at(gripper: Gripper, points: Array) -> bool:
    """Whether points are about the tip of the hand: it lies within them, or they begin close by."""
    tip = np.asarray(gripper.tip.xyz_m)
    low, high = np.percentile(points, (2, 98), axis=0)
    return bool((tip > low - _AT_TIP_M).all() and (tip < high + _AT_TIP_M).all())
