"""Each thing that the update loop does, shown in the world of facts and in physics: the same scene, the same goals,
the same disturbance, and the same edits of the tree."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pytest

from llmbt_atl.library import load_library
from llmbt_atl.state import Domain, domain_of
from llmbt_ir.condition import ActionCall, Condition, Facts, Goals
from llmbt_ir.geometry import Pose
from llmbt_ir.scene import Scene, load_scene, to_semantic_map
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.executor import Change, Settings, execute
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.outcome import Outcome, Result
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.symbolic_disturbance import symbolic_events
from llmbt_runtime.update import loop
from llmbt_runtime.update.rollout import Certificate, rollout
from llmbt_runtime.world import ActionReport, World

C = Condition
WORLDS = pytest.mark.parametrize("world", ["symbolic", "bullet"])


def on(thing: str, place: str) -> Condition:
    return C("On", (thing, place))


ONE: Goals = ((on("object_1", "position_12"),),)
TWO: Goals = ((on("object_1", "position_12"), on("object_2", "position_13")),)


@dataclass
class Played:
    """How an execution ended, its trees (the one of the goals first), its changes, and what disturbed it."""

    result: Result
    trees: list[Tree]
    changes: list[Change] = field(default_factory=list)
    disturbed: int = 0

    @property
    def kinds(self) -> list[str]:
        return [s.kind for c in self.changes for s in c.grown.steps]

    @property
    def done(self) -> list[str]:
        return [str(a.call) for a in self.result.actions if a.result == "SUCCESS"]


@cache
def room(name: str) -> tuple[Scene, Domain, Facts]:
    scene = load_scene(name)
    semantic_map = to_semantic_map(scene)
    domain = domain_of(load_library(scene.library), semantic_map)
    return scene, domain, facts_of_map(domain, semantic_map)


def play(
    world: str,
    goals: Goals,
    disturb: str = "",
    *,
    scene: str = "cargo_sorting",
    seed: int = 1,
    settings: Settings | None = None,
    symbolic: type[SymbolicWorld] = SymbolicWorld,
    bullet: type[BulletWorld] = BulletWorld,
) -> Played:
    """One execution. Every changed tree is certified from what was observed, and every tree is kept."""
    loaded, domain, start = room(scene)
    specs = (DisturbanceSpec(disturb),) if disturb else ()
    made: World
    if world == "bullet":
        made = bullet(loaded, seed, specs, goals[0])
    else:
        rng = np.random.default_rng(seed)
        made = symbolic(domain, start, rng, ticks=(2, 6), events=symbolic_events(specs, domain, start, goals[0], rng))
    found = Played(None, [goal_tree(goals)])  # type: ignore[arg-type]

    def keep(change: Change) -> str:
        found.changes.append(change)
        found.trees.append(change.grown.tree)
        again = rollout(change.grown.tree, domain.for_state(change.facts), change.facts, goals)
        assert isinstance(again, Certificate)
        return f"v{len(found.changes):03d}"

    try:
        found.result = execute(made, domain, found.trees[0], goals, keep=keep, settings=settings)
        found.disturbed = len(made.disturbances())
    finally:
        if isinstance(made, BulletWorld):
            made.close()
    assert found.disturbed == bool(disturb)
    return found


@WORLDS
def test_expand(world: str) -> None:
    found = play(world, ONE)
    assert found.result.outcome is Outcome.SUCCESS and found.result.planner_calls == 0
    assert found.kinds == ["expand", "expand"]
    assert found.done == ["pick(object_1, sorting_area)", "place(object_1, position_12)"]


@WORLDS
def test_expand_again_where_the_thing_lies_elsewhere_now(world: str) -> None:
    """Somebody puts it on the workbench: the tree is kept, and gets a further way to pick it up."""
    found = play(world, TWO, "object_moved")
    assert found.result.outcome is Outcome.SUCCESS and found.result.planner_calls == 0
    assert found.kinds == ["expand"] * 4 + ["re-expand"]
    assert set(found.trees[1].nodes) < set(found.trees[2].nodes)


@WORLDS
def test_what_was_reached_and_is_lost_again_is_brought_about_again(world: str) -> None:
    found = play(world, TWO, "placed_object_moved")
    assert found.result.outcome is Outcome.SUCCESS and len(found.done) == 6
    assert set(found.trees[1].nodes) <= set(found.trees[-1].nodes)


@WORLDS
def test_a_drop(world: str) -> None:
    found = play(world, TWO, "drop")
    assert found.result.outcome is Outcome.SUCCESS
    assert len([a for a in found.result.actions if a.call.name == "pick"]) == 3


@WORLDS
def test_move_what_frees_the_place_before_what_fills_the_hand(world: str) -> None:
    found = play(world, TWO, "obstacle_at_place")
    assert found.result.outcome is Outcome.SUCCESS
    assert "move" in found.kinds
    assert set(found.trees[1].nodes) < set(found.trees[-1].nodes), "moved, not copied, and nothing lost"
    assert [a for a in found.done if a.startswith("move_aside(obstacle_")]


@WORLDS
def test_what_stands_before_a_thing_is_cleared_away(world: str) -> None:
    found = play(world, TWO, "obstacle_at_pick")
    assert found.result.outcome is Outcome.SUCCESS
    assert [a for a in found.done if a.startswith("clear_away(obstacle_")]


LEVEL_BUT = ((on("object_4", "shelf_level_2"), ~on("object_4", "position_21")),)
"""The place that comes to mind first is the one that is not wanted; no local edit leads on from there."""


@WORLDS
def test_a_plan_where_the_local_rule_does_not_do(world: str) -> None:
    found = play(world, LEVEL_BUT)
    assert found.result.outcome is Outcome.SUCCESS and found.result.planner_calls == 1
    assert found.kinds[0] == "goals"
    assert found.done[-1] != "place(object_4, position_21)"


@WORLDS
def test_a_plan_as_a_chain(world: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its causal links nest; it is written as rows all the same, and they act."""
    monkeypatch.setattr(loop, "linked_tree", lambda *_: None)
    found = play(world, LEVEL_BUT)
    assert found.result.outcome is Outcome.SUCCESS and found.kinds == ["chain"]
    assert len(found.done) == 2


@WORLDS
@pytest.mark.parametrize(
    "goals",
    [
        ((on("object_1", "position_12"), on("object_2", "position_12")),),
        ((on("object_1", "position_12"), on("object_1", "position_13")),),
        ((C("Holding", ("object_1",)), C("HandEmpty")),),
    ],
    ids=["two things in one place", "one thing in two places", "an empty hand that holds"],
)
def test_unsolvable_before_anything_moves(world: str, goals: Goals) -> None:
    found = play(world, goals)
    assert found.result.outcome is Outcome.UNSOLVABLE
    assert set(found.result.unsolvable) == set(goals[0])
    assert found.result.actions == () and found.changes == []


@WORLDS
def test_unsolvable_from_the_state_that_came_about(world: str) -> None:
    """A thing is taken away while the robot is at work: what is proved is of the state that is seen then."""
    found = play(world, TWO, "object_taken")
    assert found.result.outcome is Outcome.UNSOLVABLE
    (goal,) = found.result.unsolvable
    assert found.result.reason.endswith(f"; no `position` of {goal.args[0]} is known") and found.done


class SymbolicSlips(SymbolicWorld):
    """No place ever succeeds."""

    def start(self, action: ActionCall) -> None:
        super().start(action)
        self._failing = action.name in ("place", "put_down")


class Slips(BulletWorld):
    """Whatever is to be placed is back where it was first, as often as it is tried."""

    home: dict[str, Pose]

    def start(self, action: ActionCall) -> None:
        if not hasattr(self, "home"):
            self.home = {o.id: o.pose for o in self._bench.scene.objects}
        super().start(action)
        self.slipping = action.args[0] if action.name in ("place", "put_down") else ""
        self.left = 8

    def advance(self) -> ActionReport:
        if getattr(self, "slipping", ""):
            self.left -= 1
            if self.left == 0:
                self._bench.put(self.slipping, self.home[self.slipping])
        return super().advance()


@WORLDS
def test_an_action_that_fails_is_tried_three_times_and_then_it_is_said(world: str) -> None:
    found = play(world, ONE, symbolic=SymbolicSlips, bullet=Slips)
    assert found.result.outcome is Outcome.ACTION_FAILED
    tries = [a.result for a in found.result.actions if str(a.call) == "place(object_1, position_12)"]
    assert tries == ["FAILURE"] * 3
    assert "place(object_1, position_12) failed 3 times" in found.result.reason


@WORLDS
def test_one_of_several_goals_will_do(world: str) -> None:
    """The first alternative cannot be; of the others the nearer one is taken."""
    goals: Goals = (
        (on("object_1", "position_12"), on("object_2", "position_12")),
        (on("object_1", "position_12"), on("object_2", "position_13"), on("object_3", "position_22")),
        (on("object_4", "position_14"),),
    )
    found = play(world, goals)
    assert found.result.outcome is Outcome.SUCCESS
    assert found.done == ["pick(object_4, sorting_area)", "place(object_4, position_14)"]
    assert [k for _, k, holds in found.result.goals if holds] == [3]


@WORLDS
@pytest.mark.parametrize(
    ("goals", "last"),
    [
        (((~on("object_1", "sorting_area"),),), "pick(object_1, sorting_area)"),
        (((~on("object_1", "sorting_area"), C("HandEmpty")),), None),
        (((~C("Free", ("position_12",)),),), None),
    ],
    ids=["away from there", "away from there and out of the hand", "a place that is taken"],
)
def test_goals_that_something_does_not_hold(world: str, goals: Goals, last: str | None) -> None:
    found = play(world, goals)
    assert found.result.outcome is Outcome.SUCCESS and found.done
    if last is not None:
        assert found.done[-1] == last


@WORLDS
def test_a_tree_that_grew_too_large_is_pruned_by_a_version_that_says_so(world: str) -> None:
    found = play(world, TWO, "object_moved", settings=Settings(max_nodes=28))
    assert found.result.outcome is Outcome.SUCCESS
    (at,) = [i for i, c in enumerate(found.changes) if {s.kind for s in c.grown.steps} == {"prune"}]
    assert len(found.trees[at + 1]) < len(found.trees[at])
    assert found.changes[at].cause == f"the tree has {len(found.trees[at])} nodes, more than 28"
