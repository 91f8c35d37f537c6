"""Whole executions in physics: a world that is restored between them, a tree that grows, and the log."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from llmbt_atl.library import load_library
from llmbt_atl.state import Domain, domain_of
from llmbt_ir.condition import Condition
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.tree import goal_tree
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.executor import Settings, execute
from llmbt_runtime.outcome import Result
from llmbt_runtime.world import Disturbed


@dataclass(frozen=True)
class Room:
    """A scene's world and its domain, built once a process."""

    world: BulletWorld
    domain: Domain


@cache
def room(scene: str) -> Room:
    loaded = load_scene(scene)
    return Room(BulletWorld(loaded), domain_of(load_library(loaded.library), to_semantic_map(loaded)))


def on(*pairs: tuple[str, str]) -> tuple[Condition, ...]:
    return tuple(Condition("On", pair) for pair in pairs)


def play(
    scene: str, goals: tuple[Condition, ...], specs: tuple[DisturbanceSpec, ...] = (), seed: int = 0
) -> tuple[Result, tuple[Disturbed, ...]]:
    """One execution from the start of the scene."""
    here = room(scene)
    here.world.reset(seed, specs, goals)
    settings = Settings(max_ticks=4000)
    result = execute(here.world, here.domain, goal_tree((goals,)), (goals,), keep=lambda _: "v", settings=settings)
    return result, here.world.disturbances()
