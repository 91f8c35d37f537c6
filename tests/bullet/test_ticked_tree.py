"""The order of work began here: one block picked and placed by a tree that is ticked at 10 Hz, whatever the phase."""

from __future__ import annotations

import os

import numpy as np
import pytest

from llmbt_atl.library import load_library
from llmbt_atl.state import domain_of
from llmbt_ir.condition import Condition
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.tree import goal_tree
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.executor import Change, execute
from llmbt_runtime.outcome import Outcome
from tests.bullet.test_pick_and_place import SLOTS, one_block

TRIALS = int(os.environ.get("LLMBT_TRIALS", "30"))
"""A hundred with LLMBT_TRIALS=100."""


@pytest.mark.slow
def test_no_extra_update_and_no_halt() -> None:
    rng = np.random.default_rng(2026)
    scene = load_scene("cargo_sorting")
    library = load_library(scene.library)
    for trial in range(TRIALS):
        there = one_block(scene, rng)
        world = BulletWorld(there, seed=trial)
        try:
            for _ in range(int(rng.integers(0, 24))):  # the phase of the tick
                world._bench.client.stepSimulation()
            goals = ((Condition("On", ("object_1", str(rng.choice(SLOTS)))),),)
            kept: list[Change] = []
            domain = domain_of(library, to_semantic_map(there))
            found = execute(world, domain, goal_tree(goals), goals, keep=lambda c, k=kept: k.append(c) or "v")  # type: ignore[misc]
            assert found.outcome is Outcome.SUCCESS, (trial, found.reason)
            assert found.updates == len(kept) == 1, (trial, [c.cause for c in kept])
            assert [(e.call.name, e.result) for e in found.actions] == [("pick", "SUCCESS"), ("place", "SUCCESS")]
        finally:
            world.close()
