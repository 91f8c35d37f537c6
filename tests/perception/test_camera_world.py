"""A physical world whose robot has to see: what the tree is told, against the truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from llmbt.execution import load_tree
from llmbt_atl.library import load_library
from llmbt_atl.state import domain_of
from llmbt_compiler.recognition.recognise import recognise
from llmbt_ir.capture import Capture
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.geometry import Pose
from llmbt_ir.scene import Scene, load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap
from llmbt_ir.tree import goal_tree
from llmbt_runtime.bullet.world import BulletWorld, Perception
from llmbt_runtime.executor import Settings, execute
from llmbt_runtime.outcome import Outcome, Result
from llmbt_runtime.world import ActionReport, Status

SCENE = load_scene("cargo_sorting")


def call(name: str, *args: str) -> ActionCall:
    return ActionCall(name, args)


def do(world: BulletWorld, action: ActionCall) -> ActionReport:
    """An action to its end."""
    world.start(action)
    while (report := world.advance()).status is Status.RUNNING:
        pass
    return report


@pytest.fixture
def world() -> Iterator[BulletWorld]:
    made = BulletWorld(SCENE, perception=Perception(recognise))
    yield made
    made.close()


def on(id_: str, place: str) -> Condition:
    return Condition("On", (id_, place))


def unseen(id_: str) -> Condition:
    return Condition("Unseen", (id_,))


def run(world: BulletWorld, *goals: Condition) -> Result:
    """The goals, by the executor, from an empty tree."""
    domain = domain_of(load_library("cargo_sorting"), to_semantic_map(SCENE))
    wanted = (tuple(goals),)
    return execute(world, domain, goal_tree(wanted), wanted, keep=lambda _: "v", settings=Settings(max_ticks=2_000))


def test_what_is_seen_is_the_truth_after_every_action(world: BulletWorld) -> None:
    assert world.observe() == world.truth()
    for action in (call("pick", "object_1", "sorting_area"), call("place", "object_1", "position_12")):
        assert do(world, action).status is Status.SUCCESS
        assert world.observe() == world.truth()
    assert on("object_1", "position_12") in world.truth()


def test_a_world_that_sees_repeats_and_can_be_reset() -> None:
    def story(world: BulletWorld) -> list[object]:
        do(world, call("pick", "object_1", "sorting_area"))
        return [world.time_s, world.objects(), sorted(world.observe())]

    worlds = [BulletWorld(SCENE, 3, perception=Perception(recognise)) for _ in range(2)]
    first, second = (story(w) for w in worlds)
    assert first == second
    worlds[0].reset(3)
    assert story(worlds[0]) == first
    for w in worlds:
        w.close()


def test_what_is_taken_away_is_unseen_then_looked_for_then_gone(world: BulletWorld) -> None:
    world._bench.park("object_6")
    world.settle(2.0)
    assert unseen("object_6") in world.observe()
    assert not any(c.name == "On" and "object_6" in c.args for c in world.observe()), "unknown"
    report = do(world, call("look", "object_6", "sorting_area"))
    assert (report.status, report.reason) == (Status.FAILURE, "not_seen")
    assert unseen("object_6") not in world.observe()
    world._bench.put("object_6", Pose((0.1, 0.5, 0.4225)))
    world.settle(1.0)
    assert on("object_6", "sorting_area") in world.observe(), "what turns up again is there again"


def test_a_goal_about_what_is_gone_cannot_be_solved(world: BulletWorld) -> None:
    world._bench.park("object_6")
    world.settle(2.0)
    found = run(world, on("object_6", "position_32"))
    assert found.outcome is Outcome.UNSOLVABLE
    assert [str(a.call) for a in found.actions] == ["look(object_6, sorting_area)"]


def test_what_is_put_elsewhere_is_found_by_looking_once(world: BulletWorld) -> None:
    world._bench.put("object_6", Pose((0.44, -0.18, 0.4825)))
    world.settle(2.0)
    assert on("object_6", "position_14") in world.observe()
    assert run(world, on("object_6", "position_32")).outcome is Outcome.SUCCESS


def test_what_slips_out_of_the_hand_is_missed_at_once_and_found_where_it_fell(world: BulletWorld) -> None:
    do(world, call("pick", "object_1", "sorting_area"))
    world.start(call("place", "object_1", "position_12"))
    for _ in range(4):
        world.advance()
    world._bench.slip()
    reports = [world.advance() for _ in range(3)]
    assert any(r.reason == "dropped_on_the_way" for r in reports)
    assert Condition("Holding", ("object_1",)) not in world.observe()
    assert not world.at_rest
    world.settle(3.0)
    assert world.at_rest and unseen("object_1") not in world.observe()
    assert {c for c in world.observe() if "object_1" in c.args} == {c for c in world.truth() if "object_1" in c.args}


def test_what_the_arm_hides_keeps_its_place(world: BulletWorld) -> None:
    """While the hand is about to take it, no camera sees object_5."""
    world.start(call("pick", "object_5", "sorting_area"))
    told: list[Facts] = []
    while world.advance().status is Status.RUNNING:
        told.append(world.observe())
    assert all(
        on("object_5", "sorting_area") in facts or Condition("Holding", ("object_5",)) in facts for facts in told
    )
    assert not any(c.name == "Unseen" for facts in told for c in facts)


def liar(capture: Capture, scene: Scene, before: SemanticMap | None) -> SemanticMap:
    """Recognition that has object_1 where it should be."""
    found = recognise(capture, scene, before)
    there = Pose((0.44, 0.06, 0.4825))
    return replace(found, objects=tuple(replace(o, pose=there) if o.id == "object_1" else o for o in found.objects))


def test_the_truth_judges() -> None:
    world = BulletWorld(SCENE, perception=Perception(liar))
    assert on("object_1", "position_12") in world.observe() and on("object_1", "position_12") not in world.truth()
    found = run(world, on("object_1", "position_12"))
    assert found.outcome is Outcome.ACTION_FAILED and "by the truth not: On(object_1, position_12)" in found.reason
    assert not any(g[-1] for g in found.goals)
    world.close()


def test_a_tree_that_looks_is_a_tree_of_the_library(tmp_path: Path) -> None:
    """A grown tree with `look` in it loads, and goes by the truth as well: nothing is unseen there."""
    tree = tmp_path / "tree.xml"
    tree.write_text(
        '<root BTCPP_format="4" main_tree_to_execute="main"><BehaviorTree ID="main"><ReactiveFallback>'
        '<Condition ID="On" target="object_6" place="position_32"/>'
        '<ReactiveSequence><Condition ID="Unseen" target="object_6"/>'
        '<Action ID="look" target="object_6" place="sorting_area"/></ReactiveSequence>'
        "</ReactiveFallback></BehaviorTree></root>"
    )
    file, _, _, goals = load_tree(tree.read_bytes(), str(tree), SCENE)
    assert len(file.tree) == 5 and goals
