"""The engines against each other, and both against the real BehaviorTree.CPP (behaviortreepy 0.1.4: 4.8.2).

Compared, at every tick of random trees of every node that the engine runs: the root's status, and in their order all
conditions and actions that are ticked with what they return, and all halts. docs/engine.md says what is not the same.

`python -m tests.engine.equality [HUNDREDS]` compares so many hundred trees of each kind, and prints what was equal.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

from llmbt_runtime.engine.incremental import IncrementalEngine
from llmbt_runtime.engine.naive import NaiveEngine
from tests.engine.cases import Case, Event, Told, ours, random_case

UNIT_MS = 100
"""How far ticks are apart in trees with timers."""


class TooBusyError(RuntimeError):
    """The machine does not keep time, so that nothing can be said of timers."""


def without_conditions(told: Told) -> Told:
    return [(status, [e for e in events if e[0] != "tick"]) for status, events in told]


def kinds(told: Told) -> Counter[str]:
    """How often each status and event came about, and how often an action was started while another ran."""
    found = Counter([status for status, _ in told] + [e[0] for _, events in told for e in events])
    for _, events in told:
        verbs = [e[0] for e in events if e[0] != "tick"]
        found["take-over"] += any(pair == ("start", "halt") for pair in pairwise(verbs))
    return found


def compare(seeds: range, unit_ms: int, *, once: bool = False) -> Counter[str]:
    """Naive and incremental on some cases; how often each status and event came about."""
    seen: Counter[str] = Counter()
    for seed in seeds:
        case = random_case(seed, unit_ms=unit_ms, endless=not once)
        naive = _or_endless(case, NaiveEngine, unit_ms, once=once)
        if naive is None:  # two Retries that wake each other for ever, in BehaviorTree.CPP too
            assert _or_endless(case, IncrementalEngine, unit_ms, once=once) is None, seed
            seen["endless"] += 1
            continue
        assert ours(case, IncrementalEngine, unit_ms=unit_ms, once=once) == naive, seed
        quiet = ours(case, IncrementalEngine, unit_ms=unit_ms, once=once, told=False)
        assert quiet == without_conditions(naive), seed
        seen += kinds(naive)
    return seen


def _or_endless(case: Case, engine: type, unit_ms: int, *, once: bool) -> Told | None:
    """What an engine does; None where the tree asks to be ticked again without end."""
    try:
        return ours(case, engine, unit_ms=unit_ms, once=once)
    except RuntimeError as endless:
        if "asks to be ticked again" not in str(endless):
            raise
        return None


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


def compare_with_the_real_one(seeds: range, unit_ms: int, *, once: bool) -> Counter[str]:
    """How many cases were equal, with how many ticks and events; how many have no end in the real engine.

    Timers go by the wall clock there, and a Timeout that halts a Python leaf in the moment of a tick locks both up:
    where ticks or timers came late, what is not equal is repeated with ticks further apart. What differs then differs.
    """
    equal: Counter[str] = Counter()
    endless: set[int] = set()
    pending, wrong = list(seeds), ""
    for unit in (unit_ms, 3 * unit_ms, 10 * unit_ms) if unit_ms else (0,):
        cases, expected, numbers = [], [], []
        for seed in pending:
            case = random_case(seed, unit_ms=unit, endless=not once)
            told = _or_endless(case, NaiveEngine, unit, once=once)
            if told is None:  # the real engine would never come back
                endless.add(seed)
                continue
            assert ours(case, IncrementalEngine, unit_ms=unit, once=once) == told, seed
            expected.append(told)
            cases.append(case)
            numbers.append(seed)
        try:
            late_ms, found = real(cases, unit_ms=unit, once=once, timeout_s=30 + 0.02 * unit)
        except subprocess.TimeoutExpired:
            wrong = "locked up"
            continue
        pending = [n for n, mine, theirs in zip(numbers, expected, found, strict=True) if as_told(theirs) != mine]
        for number, mine in zip(numbers, expected, strict=True):
            if number not in pending:
                equal += kinds(mine)
                equal["trees"] += 1
                equal["ticks"] += len(mine) - 1
        wrong = "late" if unit and late_ms > 0.4 * unit else f"seeds {pending[:5]}"
        equal["endless"] = len(endless)
        if not pending:
            return equal
    if wrong in ("late", "locked up"):
        raise TooBusyError(wrong)
    raise AssertionError(wrong)


def main(hundreds: int) -> None:
    """Compare, and print what was equal."""
    for unit_ms in (0, 2 * UNIT_MS):
        for once in (False, True):
            found: Counter[str] = Counter()
            for k in range(hundreds if unit_ms == 0 else max(1, hundreds // 3)):
                first = 40_000 + 100 * k
                try:
                    found += compare_with_the_real_one(range(first, first + 100), unit_ms, once=once)
                except TooBusyError:
                    found["not compared"] += 100
            told = ", ".join(f"{found[k]} {k}" for k in ("trees", "ticks", "tick", "start", "halt", "take-over"))
            left = f"; left out: {found['endless']} without end, {found['not compared']} as the machine kept no time"
            print(f"{'tickOnce' if once else 'tickExactlyOnce'}, {'with' if unit_ms else 'no'} timers: {told}{left}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 15)
