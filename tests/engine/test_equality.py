"""The engines against each other, and both against the real BehaviorTree.CPP: see tests/engine/equality.py."""

from __future__ import annotations

import pytest

from llmbt_ir.condition import Facts
from llmbt_runtime.engine.engine import OneBody
from llmbt_runtime.engine.incremental import IncrementalEngine
from llmbt_runtime.engine.naive import NaiveEngine
from llmbt_runtime.engine.program import Op
from llmbt_runtime.facts import change_between
from llmbt_runtime.tick import NodeStatus
from tests.engine.cases import Case, Event, Script, facts_of, ours, random_case
from tests.engine.equality import UNIT_MS, TooBusyError, compare, compare_with_the_real_one, without_conditions


def equal_trees(seeds: range, unit_ms: int, *, once: bool) -> int:
    """How many random trees behave as in the real engine; skips where this machine is too busy to keep time."""
    try:
        return compare_with_the_real_one(seeds, unit_ms, once=once)["trees"]
    except TooBusyError as busy:
        pytest.skip(f"this machine is too busy to keep time: {busy}")


@pytest.mark.parametrize("once", [False, True])
@pytest.mark.parametrize("unit_ms", [0, UNIT_MS])
def test_the_incremental_engine_does_what_the_naive_one_does(unit_ms: int, once: bool) -> None:
    seen = compare(range(150), unit_ms, once=once)
    assert min(seen[k] for k in ("SUCCESS", "FAILURE", "RUNNING", "tick", "start", "run", "halt")) > 50
    assert seen["take-over"] > 10
    assert seen["endless"] < 5


@pytest.mark.slow
def test_the_incremental_engine_does_what_the_naive_one_does_on_thousands() -> None:
    for unit_ms in (0, UNIT_MS):
        compare(range(10_000, 10_700), unit_ms)


@pytest.mark.parametrize("once", [False, True])
def test_both_do_what_behaviortree_cpp_does(once: bool) -> None:
    assert equal_trees(range(300), 0, once=once) > 290


@pytest.mark.parametrize("once", [False, True])
def test_both_do_what_behaviortree_cpp_does_with_timers(once: bool) -> None:
    assert equal_trees(range(150), UNIT_MS, once=once) > 140


@pytest.mark.slow
@pytest.mark.parametrize("once", [False, True])
def test_both_do_what_behaviortree_cpp_does_on_thousands(once: bool) -> None:
    assert equal_trees(range(20_000, 21_500), 0, once=once) > 1_450


@pytest.mark.slow
@pytest.mark.parametrize("once", [False, True])
def test_both_do_what_behaviortree_cpp_does_with_timers_on_thousands(once: bool) -> None:
    equal = sum(equal_trees(range(k, k + 300), 2 * UNIT_MS, once=once) for k in (30_000, 31_000))
    assert equal > 550


# -- which leaf decided -----------------------------------------------------------------------------------------------


def test_the_leaf_that_decided_is_the_last_that_was_ticked() -> None:
    """Where it is a condition or an action: the oracle is the trace, which costs what the leaves cost."""
    seen = 0
    for seed in range(400):
        case = random_case(seed, unit_ms=UNIT_MS)
        script = Script(case.program, case.names, case.answers)
        engine = IncrementalEngine(case.program, script)
        engine.trace = trace = []
        before: Facts = frozenset()
        for k, names in enumerate(case.facts):
            trace.clear()
            change, before = change_between(before, facts_of(names)), facts_of(names)
            if engine.tick(change, k * UNIT_MS) is NodeStatus.RUNNING:
                continue
            leaf = engine.last_leaf()
            if case.program.nodes[leaf].op in (Op.CONDITION, Op.ACTION):
                assert trace[-1][0] == leaf, seed
                seen += 1
    assert seen > 300


# -- one body --------------------------------------------------------------------------------------------------------


def active_after(events: list[Event], active: str | None) -> str | None:
    """The action that has the body after some events; fails where two would have it."""
    for verb, leaf, status in events:
        if verb == "start":
            assert active is None, f"{leaf} starts while {active} runs"
        elif verb in ("run", "halt"):
            assert active == leaf
        if verb != "tick":
            active = leaf if status == "RUNNING" else None
    return active


@pytest.mark.parametrize("engine", [NaiveEngine, IncrementalEngine])
def test_one_body_is_halted_before_it_is_started(engine: type) -> None:
    """Never are two actions under way, and every tick in which no action ends at once has the same events otherwise."""
    taken_over = 0
    for seed in range(300):
        case = random_case(seed, endless=False)
        for name in case.answers:
            case.answers[name][:] = ["RUNNING"] * 9 + [case.answers[name][-1]]
        plain = without_conditions(ours(case, engine))
        single = without_conditions(ours(case, engine, wrap=OneBody))
        active: str | None = None
        for (status, events), (bare_status, bare) in zip(single, plain, strict=True):
            active = active_after(events, active)
            assert (status, sorted(events)) == (bare_status, sorted(bare))
            taken_over += events != bare
    assert taken_over > 10


def test_an_action_that_lost_the_body_in_a_tick_is_started_again() -> None:
    """ReactiveSequence[Fallback(P0, a0), a1]: a0 takes the body from a1, ends at once, and a1 is next."""
    xml = (
        '<root BTCPP_format="4"><BehaviorTree ID="M"><ReactiveSequence><ReactiveFallback><P0 name="P0_0"/>'
        '<a0 name="a0_1"/></ReactiveFallback><a1 name="a1_2"/></ReactiveSequence></BehaviorTree></root>'
    )
    case = Case(xml, (("P0",), (), ("P0",)), {"a0_1": ["SUCCESS"], "a1_2": ["RUNNING"]})
    for engine in (NaiveEngine, IncrementalEngine):
        assert without_conditions(ours(case, engine, wrap=OneBody)) == [
            ("RUNNING", [("start", "a1_2", "RUNNING")]),
            ("RUNNING", [("halt", "a1_2", ""), ("start", "a0_1", "SUCCESS"), ("start", "a1_2", "RUNNING")]),
            ("RUNNING", [("run", "a1_2", "RUNNING")]),
            ("", [("halt", "a1_2", "")]),
        ]
        assert without_conditions(ours(case, engine))[1] == (
            "RUNNING",
            [("start", "a0_1", "SUCCESS"), ("run", "a1_2", "RUNNING")],
        )


def test_a_script_answers_in_a_circle() -> None:
    case = random_case(3)
    name = next(iter(case.answers), None)
    script = Script(case.program, [name or ""] * len(case.program), {name or "": ["SUCCESS", "FAILURE"]})
    assert [script.start(0).value, script.poll(0).value, script.poll(0).value] == ["SUCCESS", "FAILURE", "SUCCESS"]
