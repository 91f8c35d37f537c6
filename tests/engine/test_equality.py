"""The engines against each other, and both against the real BehaviorTree.CPP (behaviortreepy 0.1.4: 4.8.2).

Compared, at every tick of random trees of every node that the engine runs: the root's status, and in their order all
conditions and actions that are ticked with what they return, and all halts. docs/engine.md says what is not the same.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from llmbt_runtime.engine.engine import OneBody
from llmbt_runtime.engine.incremental import IncrementalEngine
from llmbt_runtime.engine.naive import NaiveEngine
from tests.engine.cases import Case, Event, Script, Told, ours, random_case

UNIT_MS = 100
"""How far ticks are apart in trees with timers."""


def without_conditions(told: Told) -> Told:
    return [(status, [e for e in events if e[0] != "tick"]) for status, events in told]


def kinds(told: Told) -> Counter[str]:
    """How often each status and event came about, and how often an action was started while another ran."""
    found = Counter([status for status, _ in told] + [e[0] for _, events in told for e in events])
    for _, events in told:
        verbs = [e[0] for e in events if e[0] != "tick"]
        found["take-over"] += any(pair == ("start", "halt") for pair in pairwise(verbs))
    return found


# -- naive and incremental -------------------------------------------------------------------------------------------


def compare(seeds: range, unit_ms: int, *, once: bool = False) -> Counter[str]:
    """Both engines on some cases; how often each status and event came about."""
    seen: Counter[str] = Counter()
    for seed in seeds:
        case = random_case(seed, unit_ms=unit_ms, endless=not once)
        try:
            naive = ours(case, NaiveEngine, unit_ms=unit_ms, once=once)
        except RuntimeError:  # two Retries that wake each other for ever, in BehaviorTree.CPP too
            with pytest.raises(RuntimeError, match="asks to be ticked again"):
                ours(case, IncrementalEngine, unit_ms=unit_ms, once=once)
            seen["endless"] += 1
            continue
        assert ours(case, IncrementalEngine, unit_ms=unit_ms, once=once) == naive, seed
        quiet = ours(case, IncrementalEngine, unit_ms=unit_ms, once=once, told=False)
        assert quiet == without_conditions(naive), seed
        seen += kinds(naive)
    return seen


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


# -- the real engine -------------------------------------------------------------------------------------------------


def real(cases: list[Case], *, unit_ms: int, once: bool, timeout_s: float = 60) -> tuple[float, list[Any]]:
    """What BehaviorTree.CPP does, in a process of its own with a time limit, and by how many ms it was late."""
    given = {
        "unit_ms": unit_ms,
        "once": once,
        "cases": [{"xml": c.xml, "facts": c.facts, "answers": c.answers} for c in cases],
    }
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("real.py"))],
        input=json.dumps(given),
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    document = json.loads(done.stdout.splitlines()[-1])
    return document["late_ms"], document["told"]


def as_told(rows: Any) -> Told:
    assert isinstance(rows, list), rows
    found = []
    for status, events in rows:
        typed: list[Event] = [(verb, leaf, result) for verb, leaf, result in events]
        found.append((status, typed))
    return found


def compare_with_the_real_one(seeds: range, unit_ms: int, *, once: bool) -> int:
    """How many cases were equal.

    Timers go by the wall clock there, and a Timeout that halts a Python leaf in the moment of a tick locks both up:
    where ticks or timers came late, what is not equal is repeated with ticks further apart. What differs then differs.
    """
    equal, pending, wrong = 0, list(seeds), ""
    for unit in (unit_ms, 3 * unit_ms, 10 * unit_ms) if unit_ms else (0,):
        cases, expected, numbers = [], [], []
        for seed in pending:
            case = random_case(seed, unit_ms=unit, endless=not once)
            try:
                expected.append(ours(case, NaiveEngine, unit_ms=unit, once=once))
            except RuntimeError:
                continue  # the real engine would never come back
            cases.append(case)
            numbers.append(seed)
        try:
            late_ms, told = real(cases, unit_ms=unit, once=once, timeout_s=30 + 0.02 * unit)
        except subprocess.TimeoutExpired:
            wrong = "locked up"
            continue
        pending = [n for n, mine, theirs in zip(numbers, expected, told, strict=True) if as_told(theirs) != mine]
        equal += len(numbers) - len(pending)
        wrong = "late" if unit and late_ms > 0.4 * unit else f"seeds {pending[:5]}"
        if not pending:
            return equal
    if wrong in ("late", "locked up"):
        pytest.skip(f"this machine is too busy to keep time: {wrong}")
    raise AssertionError(wrong)


@pytest.mark.parametrize("once", [False, True])
def test_both_do_what_behaviortree_cpp_does(once: bool) -> None:
    assert compare_with_the_real_one(range(300), 0, once=once) > 290


@pytest.mark.parametrize("once", [False, True])
def test_both_do_what_behaviortree_cpp_does_with_timers(once: bool) -> None:
    assert compare_with_the_real_one(range(150), UNIT_MS, once=once) > 140


@pytest.mark.slow
@pytest.mark.parametrize("once", [False, True])
def test_both_do_what_behaviortree_cpp_does_on_thousands(once: bool) -> None:
    assert compare_with_the_real_one(range(20_000, 21_500), 0, once=once) > 1_450


@pytest.mark.slow
@pytest.mark.parametrize("once", [False, True])
def test_both_do_what_behaviortree_cpp_does_with_timers_on_thousands(once: bool) -> None:
    equal = sum(compare_with_the_real_one(range(k, k + 300), 2 * UNIT_MS, once=once) for k in (30_000, 31_000))
    assert equal > 550


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
