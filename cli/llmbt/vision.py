"""Capturing, which the runtime does, and recognising, which the compiler does, put together."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from llmbt_ir.capture import Capture, PointCloud
from llmbt_ir.scene import Scene
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["NOISE_M", "capture_start", "map_of_start", "recogniser"]

NOISE_M = 0.0015
"""The standard deviation of the depth cameras' error, unless asked otherwise."""


def capture_start(scene: Scene, *, noise_m: float = NOISE_M, seed: int = 0) -> tuple[Mapping[str, PointCloud], Capture]:
    """What the scene's cameras see before a run, by camera, and all of it with what the robot knows of itself."""
    from llmbt_runtime.bullet.world import BulletWorld
    from llmbt_runtime.perception.sensors import capture_of, clouds_of

    world = BulletWorld(scene)
    try:
        sensors = world.sensors(noise_m, np.random.default_rng(seed))
        try:
            clouds = clouds_of(sensors)
            return clouds, capture_of(sensors, clouds)
        finally:
            sensors.close()
    finally:
        world.close()


def recogniser(scene: Scene) -> Callable[[Capture, SemanticMap | None], SemanticMap]:
    """Recognition for one scene, as perception in the loop wants it."""
    from llmbt_compiler.recognition.recognise import recognise

    return lambda capture, previous: recognise(capture, scene, previous)


def map_of_start(scene: Scene, *, seed: int = 0) -> SemanticMap:
    """The map recognised from the scene's cameras before a run."""
    return recogniser(scene)(capture_start(scene, seed=seed)[1], None)
