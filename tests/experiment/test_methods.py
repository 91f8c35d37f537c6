"""What each way of executing can and cannot do, on the smallest scene that shows it."""

from __future__ import annotations

import pytest

from llmbt.experiment.cases import load_experiment
from llmbt_ir.condition import Condition, parse_condition, satisfied
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.tree import Tree
from llmbt_runtime.baselines import EXECUTORS, METHODS, STEPS_ONLY, Limits, Run, run
from llmbt_runtime.chance import chance
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.symbolic import Event, SymbolicWorld

C = Condition
CASE = load_experiment("cargo_sorting").cases[0]
DOMAIN = CASE.domain()
START = facts_of_map(DOMAIN, to_semantic_map(load_scene("cargo_sorting")))
GOALS = (tuple(parse_condition(t) for t in ("On(object_1, position_11)", "On(object_3, position_21)")),)
HELD, FREE = C("Holding", ("object_1",)), C("Free", ("position_11",))
DROP = Event(
    1,
    frozenset({HELD}),
    frozenset({C("HandEmpty"), C("On", ("object_1", "workbench"))}),
    (HELD,),
    "drop",
    "object_1",
)
OBSTACLE = Event(
    1,
    frozenset({FREE}),
    frozenset({C("Clear", ("obstacle_1",)), *DOMAIN.for_state(START).upward(C("On", ("obstacle_1", "position_11")))}),
    (HELD, FREE),
    "obstacle_at_place",
    "position_11",
)
MOVED = Event(
    1,
    frozenset(DOMAIN.upward(C("On", ("object_1", "position_11")))),
    frozenset({FREE, C("On", ("object_1", "workbench"))}),
    (C("On", ("object_1", "position_11")), C("HandEmpty")),
    "placed_object_moved",
    "object_1",
)
EVENTS = {"none": (), "drop": (DROP,), "obstacle": (OBSTACLE,), "moved": (MOVED,)}
LIMITS = Limits(ticks=400, expansions=5_000, updates=60, nodes=10_000, patience_ticks=10)
CAN = {
    "script": {"none"},
    "retry": {"none"},
    "feasible": {"none", "drop", "moved"},
    "fixed": {"none", "drop", "moved"},
    "paper-kind": {"none", "drop", "moved"},
    "pa-bt": set(EVENTS),
    "chain": set(EVENTS),
    "loop": set(EVENTS),
    "loop-uncertified": set(EVENTS),
    "loop-no-re-expansion": set(EVENTS),
    "loop-chain": set(EVENTS),
}
"""What each method masters here. `paper` to the letter and `expansion` are looked at below."""


def executed(method: str, event: str, grew=lambda _: None) -> tuple[Run, bool]:
    world = SymbolicWorld(DOMAIN.for_state(START), START, chance(0, "world"), events=EVENTS[event])
    found = run(method, world, DOMAIN, GOALS, LIMITS, grew=grew)
    assert len(world.disturbances()) == len(EVENTS[event]) or not satisfied(GOALS, world.truth())
    return found, satisfied(GOALS, world.truth())


@pytest.mark.parametrize("event", EVENTS)
@pytest.mark.parametrize("method", CAN)
def test_what_a_method_masters(method, event):
    _, reached = executed(method, event)
    assert reached == (event in CAN[method])


def test_every_method_is_told_of_and_the_suite_s_own_stay():
    assert set(CAN) | {"paper", "expansion"} == set(EXECUTORS)
    assert list(METHODS) == ["paper", "paper-kind", "pa-bt", "local", "chain", "loop"]
    with pytest.raises(KeyError):
        executed("magic", "none")


class TestSteps:
    def test_a_script_runs_every_step_once_and_looks_at_nothing(self):
        found, _ = executed("script", "drop")
        assert [(str(a.call), a.result) for a in found.actions] == [
            ("pick(object_1, sorting_area)", "SUCCESS"),
            ("place(object_1, position_11)", "FAILURE"),
            ("pick(object_3, sorting_area)", "SUCCESS"),
            ("place(object_3, position_21)", "SUCCESS"),
        ]

    def test_a_retry_tries_three_times(self):
        found, _ = executed("retry", "drop")
        assert [a.result for a in found.actions if str(a.call) == "place(object_1, position_11)"] == ["FAILURE"] * 3

    def test_the_feasible_step_is_the_same_skill_from_where_the_thing_is(self):
        found, _ = executed("feasible", "drop")
        assert "pick(object_1, workbench)" in {str(a.call) for a in found.actions}

    def test_no_step_removes_what_was_not_there(self):
        for method in (*STEPS_ONLY, "fixed"):
            found, _ = executed(method, "obstacle")
            assert not any("obstacle_1" in a.call.args for a in found.actions)
            assert found.stuck


def test_a_fixed_tree_is_made_once():
    trees: list[Tree] = []
    executed("fixed", "drop", trees.append)
    assert len(trees) == 1


def test_replanning_plans_at_each_deviation_and_ours_does_not():
    assert executed("chain", "obstacle")[0].planner_calls == 2
    assert executed("loop-chain", "obstacle")[0].planner_calls == 2
    assert executed("loop", "obstacle")[0].planner_calls == 0


def test_re_expansion_is_what_saves_a_plan_after_a_drop():
    assert executed("loop", "drop")[0].planner_calls == 0
    assert executed("loop-no-re-expansion", "drop")[0].planner_calls == 1


def test_bt_expansion_solves_one_goal_and_drowns_in_two():
    world = SymbolicWorld(DOMAIN.for_state(START), START, chance(0, "world"), events=(DROP,))
    one = ((GOALS[0][0],),)
    found = run("expansion", world, DOMAIN, one, LIMITS)
    assert satisfied(one, world.truth())
    assert found.planner_calls == 2  # it stops expanding at the present state, so after the drop it begins anew
    six = (tuple(C("On", (f"object_{o}", f"position_{p}")) for o, p in zip(range(1, 7), range(11, 15), strict=False)),)
    assert "nodes" in run("expansion", SymbolicWorld(DOMAIN, START, chance(0, "w")), DOMAIN, six, LIMITS).reason


def test_a_clock_is_asked_and_without_one_no_time_is_told():
    times = iter(range(1_000))
    world = SymbolicWorld(DOMAIN.for_state(START), START, chance(0, "world"))
    assert run("pa-bt", world, DOMAIN, GOALS, LIMITS, clock=lambda: float(next(times))).planning_s > 0
    assert executed("pa-bt", "none")[0].planning_s == 0
