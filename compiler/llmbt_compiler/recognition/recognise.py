"""The table of stages from a capture to a semantic map, and the call that runs them."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from llmbt_compiler.recognition import segment
from llmbt_compiler.recognition.candidates import Candidate, candidates
from llmbt_compiler.recognition.cluster import clusters
from llmbt_compiler.recognition.detect import Detection, detect, without_fragments
from llmbt_compiler.recognition.identity import identify, shape_word
from llmbt_compiler.recognition.open3d import SEED, open3d
from llmbt_compiler.recognition.solids import Fit, Geometry, Kind, quat_of, yaw_matrix
from llmbt_ir.capture import Capture, PointCloud
from llmbt_ir.geometry import Pose
from llmbt_ir.scene import Scene, to_semantic_map
from llmbt_ir.semantic_map import MapObject, SemanticMap

__all__ = ["STAGES", "detections", "recognise"]

STAGES = ("crop", "fixtures", "robot", "thin", "cluster", "detect", "identify")
"""In the order of the work; `observe` hears each with its time."""
Observe = Callable[[str, float], None]


def _silent(_stage: str, _seconds: float) -> None:
    """Nobody listens."""


def recognise(
    capture: Capture, scene: Scene, previous: SemanticMap | None = None, *, observe: Observe = _silent
) -> SemanticMap:
    """The map of what a capture shows: the scene's places, and every thing that is seen.

    Things have the ids of the scene's objects and obstacles where they agree with them, those of the map before where
    that had others, and new ones (obstacle_N) else. The same capture gives the same map.
    """
    known = candidates(scene, previous)
    seen = detections(capture, scene, known, observe=observe)
    clock = time.perf_counter()
    named = identify(seen, known)
    objects = _objects(seen, named, scene, known)
    observe("identify", time.perf_counter() - clock)
    return replace(to_semantic_map(scene), objects=objects)


def detections(
    capture: Capture, scene: Scene, known: Sequence[Candidate], *, observe: Observe = _silent
) -> list[Detection]:
    """Everything that a capture shows, nameless."""
    open3d().utility.random.seed(SEED)
    steps: tuple[tuple[str, Callable[[PointCloud], PointCloud]], ...] = (
        ("crop", lambda c: segment.crop(c, scene)),
        ("fixtures", lambda c: segment.without_fixtures(c, scene.fixtures)),
        ("robot", lambda c: segment.without_robot(c, capture.robot)),
        ("thin", segment.thin),
    )
    cloud = every = capture.cloud
    for name, step in steps:
        clock = time.perf_counter()
        cloud = step(cloud)
        every = cloud if name == "crop" else every
        observe(name, time.perf_counter() - clock)
    clock = time.perf_counter()
    found = clusters(cloud)
    observe("cluster", time.perf_counter() - clock)
    clock = time.perf_counter()
    seen = [d for c in found for d in detect(c, scene, known, capture, every.xyz_m)]
    seen = without_fragments(seen)
    observe("detect", time.perf_counter() - clock)
    return seen


def _objects(
    seen: Sequence[Detection],
    named: Sequence[tuple[Fit, Candidate | None]],
    scene: Scene,
    known: Sequence[Candidate],
) -> tuple[MapObject, ...]:
    """In the order of the candidates, new things behind them."""
    order = {c.id: i for i, c in enumerate(known)}
    taken = {*order, *(p.id for p in scene.places), *(f.id for f in scene.fixtures)}
    fresh = (name for n in itertools.count(1) if (name := f"obstacle_{n}") not in taken)
    rows = []
    for d, (fit, match) in zip(seen, named, strict=True):
        word = shape_word(fit.geometry)
        who = match or Candidate(next(fresh), f"{d.term} {word}".strip(), "obstacle", d.term, word, fit.geometry)
        place = None if d.held or not fit.level else _place(scene, fit)
        x, y, z = _rounded(who.geometry.size_m)
        pose = _canonical(fit)
        thing = MapObject(who.id, who.name, who.colour, who.shape, (x, y, z), pose, place, who.type, held=d.held)
        rows.append((order.get(who.id, len(order)), thing))
    return tuple(thing for _, thing in sorted(rows, key=lambda r: r[0]))


def _place(scene: Scene, fit: Fit) -> str | None:
    x, y, z = fit.xyz_m
    half = float((np.abs(fit.rotation[2]) * np.asarray(fit.geometry.size_m)).sum() / 2)
    if fit.geometry.kind is Kind.SPHERE:
        half = fit.geometry.size_m[0] / 2
    return scene.most_specific(x, y, z - half)


def _rounded(values: tuple[float, ...]) -> tuple[float, ...]:
    """To a hundredth of a millimetre: sums over threads differ in their last bits."""
    return tuple(round(v, 5) for v in values)


def _canonical(fit: Fit) -> Pose:
    """The pose of those that look alike with the least turn: a box may be turned by half, a square one by a quarter, a
    round one by anything."""
    rotation = fit.rotation
    x, y, z = _rounded(fit.xyz_m)
    if fit.geometry.kind is Kind.SPHERE:
        return Pose((x, y, z))
    turns = (
        [yaw_matrix(k * math.pi / 2) for k in range(4)]
        if _square(fit.geometry)
        else [yaw_matrix(k * math.pi) for k in (0, 1)]
    )
    if fit.geometry.kind is Kind.CYLINDER:
        back = math.atan2(rotation[0, 1] - rotation[1, 0], rotation[0, 0] + rotation[1, 1])
        turns = [yaw_matrix(back), yaw_matrix(back + math.pi)]
    flips = [np.eye(3), np.diag([1.0, -1.0, -1.0]), np.diag([-1.0, 1.0, -1.0])]
    alike = [rotation @ f @ t for f in flips[: 1 if rotation[2, 2] > 0.99 else 3] for t in turns]
    qx, qy, qz, qw = _rounded(quat_of(max(alike, key=lambda r: round(float(np.trace(r)), 6))))
    return Pose((x, y, z), (qx, qy, qz, qw))


def _square(geometry: Geometry) -> bool:
    return math.isclose(geometry.size_m[0], geometry.size_m[1])
