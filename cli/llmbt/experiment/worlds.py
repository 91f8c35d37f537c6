"""Physical worlds, built once in a process and taken back to the start for each trial."""

from __future__ import annotations

from llmbt_ir.condition import Condition
from llmbt_ir.scene import Scene
from llmbt_runtime.bullet.world import BulletWorld, Perception
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.world import WorldLostError

__all__ = ["kept_world"]

_KEPT: dict[tuple[str, bool], _KeptWorld] = {}
"""By the scene's file, and whether the robot has to see. A process runs one trial at a time, so one of each is enough.
"""


class _KeptWorld(BulletWorld):
    """A world that outlives its trial."""

    def close(self) -> None:
        """It stays, for the next trial of this scene."""


def kept_world(
    scene: Scene, seed: int, specs: tuple[DisturbanceSpec, ...], aims: tuple[Condition, ...], *, sees: bool = False
) -> BulletWorld:
    """A world at its start: what follows is, bit for bit, what a new one would do (`BulletWorld.reset`). The scene is
    that of its file, nothing varied. `sees`: conditions and skills go by the cameras."""
    key = scene.source, sees
    world = _KEPT.get(key)
    if world is not None:
        try:
            world.reset(seed, specs, aims)
        except WorldLostError:
            BulletWorld.close(_KEPT.pop(key))
        else:
            return world
    world = _KEPT[key] = _KeptWorld(scene, seed, specs, aims, _eyes() if sees else None)
    return world


def _eyes() -> Perception:
    from llmbt_compiler.recognition.recognise import recognise

    return Perception(recognise)
