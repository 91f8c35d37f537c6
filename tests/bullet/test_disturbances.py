"""Disturbances: each fires after the first grasp, breaks something, and can be dealt with."""

from __future__ import annotations

import importlib.util
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.scene import load_scene
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.disturbance import SOLVABLE, DisturbanceSpec


def _load_greedy() -> ModuleType:
    spec = importlib.util.spec_from_file_location("bullet_greedy", Path(__file__).with_name("greedy.py"))
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


greedy = _load_greedy()

DISTURBANCES = tuple(n for n in SOLVABLE if n != "base_blocked")
"""Those of a robot that stands still."""

SWAP = (Condition("On", ("object_1", "position_22")), Condition("On", ("object_3", "position_12")))
KEY = {
    "drop": "Holding",
    "obstacle_at_pick": "Clear",
    "obstacle_at_place": "Free",
    "placed_object_moved": "On",
    "object_moved": "On",
    "destination_shifted": "On",
}


def check(name: str, seed: int, scene: str = "cargo_sorting") -> BulletWorld:
    """One episode; the world is closed, its log can still be read."""
    goals = SWAP if scene == "cargo_swap" else greedy.CANONICAL
    world = BulletWorld(load_scene(scene), seed, (DisturbanceSpec(name),), goals)
    episode = greedy.run(world, goals)
    log = world.disturbances()
    world.close()
    assert episode.solved, episode.actions
    assert not episode.faults, episode.faults
    if name == "none":
        assert log == ()
        assert all("SUCCESS" in a for a in episode.actions)
        assert world.time_s < 100
        return world
    assert len(log) == 1
    entry = log[0]
    assert entry.name == name
    assert entry.fired_at_s > 1.0  # after the first grasp
    assert entry.recovered_at_s is not None
    assert any(c.name == KEY[entry.name] for c in entry.broke)
    return world


@pytest.mark.parametrize("name", ["none", *DISTURBANCES])
def test_canonical(name: str) -> None:
    check(name, seed=1)


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["cargo_sorting", "cargo_swap"])
@pytest.mark.parametrize("name", ["none", *DISTURBANCES])
def test_five_seeds(name: str, scene: str) -> None:
    for seed in range(5):
        check(name, seed, scene)


def test_unknown_and_impossible_disturbances() -> None:
    scene = load_scene("cargo_sorting")
    with pytest.raises(LlmbtError, match="E064") as unknown:
        BulletWorld(scene, 0, (DisturbanceSpec("obstacle_at_pik"),))
    assert unknown.value.diagnostics[0].candidates[0] == "obstacle_at_pick"
    with pytest.raises(LlmbtError, match="E065"):
        BulletWorld(replace(scene, obstacles=()), 0, (DisturbanceSpec("obstacle_at_place"),))
