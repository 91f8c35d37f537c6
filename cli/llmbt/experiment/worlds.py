"""Physical worlds, built once in a process and taken back to the start for each trial."""

from __future__ import annotations

from llmbt_ir.condition import Condition
from llmbt_ir.scene import Scene
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.world import WorldLostError

__all__ = ["kept_world"]

_KEPT: dict[str, _KeptWorld] = {}
"""By the scene's file. A process runs one trial at a time, so one world of each scene is enough."""


class _KeptWorld(BulletWorld):
    """A world that outlives its trial."""

    def close(self) -> None:
        """It stays, for the next trial of this scene."""


def kept_world(scene: Scene, seed: int, specs: tuple[DisturbanceSpec, ...], aims: tuple[Condition, ...]) -> BulletWorld:
    """A world at its start: what follows is, bit for bit, what a new one would do (`BulletWorld.reset`)."""
    world = _KEPT.get(scene.source)
    if world is not None:
        try:
            world.reset(seed, specs, aims)
        except WorldLostError:
            BulletWorld.close(_KEPT.pop(scene.source))
        else:
            return world
    world = _KEPT[scene.source] = _KeptWorld(scene, seed, disturbances=specs, goals=aims)
    return world
