"""The scenes of the experiments can be worked in: what a case wants can be done where nothing happens."""

from __future__ import annotations

import pytest

from llmbt.experiment.cases import experiment_names, load_experiment
from llmbt_ir.condition import ActionCall
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.tree import goal_tree
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.update.loop import Grown, update
from llmbt_runtime.world import Status

CASES = [c for name in experiment_names() for c in load_experiment(name).cases]


@pytest.mark.parametrize("case", CASES, ids=[c.name for c in CASES])
def test_each_alternative_of_a_case_has_a_certified_tree(case):
    domain = case.domain()
    facts = facts_of_map(domain, to_semantic_map(case.scene))
    for alternative in case.success:
        goals = (alternative,)
        assert isinstance(update(goal_tree(goals), domain, facts, goals), Grown)


def done(world: BulletWorld, *call: str) -> Status:
    world.start(ActionCall(call[0], call[1:]))
    while (report := world.advance()).status is Status.RUNNING:
        pass
    return report.status


def test_a_cylinder_that_was_taken_askew_is_put_down_square():
    world = BulletWorld(load_scene("cargo_shapes"))
    assert done(world, "pick", "object_2", "sorting_area") is Status.SUCCESS
    assert done(world, "place", "object_2", "position_11") is Status.SUCCESS
    world.close()


def test_the_box_stands_in_the_way_of_the_milk_and_of_nothing_else():
    world = BulletWorld(load_scene("household_milk"))
    facts = {str(f) for f in world.truth()}
    assert {f for f in facts if f.startswith("Blocks")} == {"Blocks(box, milk)"}
    assert "Clear(box)" in facts
    world.close()
