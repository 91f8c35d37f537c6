"""The same question put to Fast Downward, for the largest problems: an extra (`pip install llm-bt[planners]`).

Helmert, "The Fast Downward planning system", JAIR 26 (2006); Richter and Westphal, "The LAMA planner", JAIR 39 (2010).
The compiled problem is written in Fast Downward's own input format, with the mutexes that can be relied on as its
variables, so that its translator is not needed. It is run as a process of its own.
"""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError
from llmbt_runtime.search.best_first import Budget
from llmbt_runtime.search.core import DEFAULT_BUDGET
from llmbt_runtime.search.grounding import task_of
from llmbt_runtime.search.mutex import Mutexes, mutexes_of
from llmbt_runtime.search.problem import Problem, Unreachable, bits, problem_of
from llmbt_runtime.search.proof import quick_proof, smallest, unreachable_goal
from llmbt_runtime.search.result import OutOfBudget, Plan, Result
from llmbt_runtime.search.shorten import shortened

__all__ = ["available", "driver", "search_fast_downward"]

_EXPANDED = re.compile(r"Expanded (\d+) state")
_SOLVED, _UNSOLVABLE = 0, (11, 12)
_OUT_OF_RESOURCES = (20, 21, 22, 23, 24)


def available() -> bool:
    """Whether Fast Downward is installed."""
    return _script() is not None


def _script() -> Path | None:
    spec = importlib.util.find_spec("up_fast_downward")
    if spec is None or not spec.submodule_search_locations:
        return None
    script = Path(next(iter(spec.submodule_search_locations))) / "downward" / "fast-downward.py"
    return script if script.is_file() else None


def driver() -> Path:
    """Fast Downward's own command. E075 where it is not installed."""
    script = _script()
    if script is None:
        raise LlmbtError(
            Diagnostic("E075", "Fast Downward is not installed", help="pip install llm-bt[planners]"),
            exit_code=ExitCode.USAGE,
        )
    return script


def search_fast_downward(
    domain: Domain,
    facts: Facts,
    goals: tuple[Condition, ...],
    *,
    budget: int = DEFAULT_BUDGET,
    excluded: frozenset[ActionCall] = frozenset(),
    seconds: int = 300,
    alias: str = "lama-first",
) -> Result:
    """As `search`, by Fast Downward. It does not count expansions beforehand: its limit is `seconds`.

    `budget` is for the proof that a set of goals is a smallest unsolvable one. E075 where it is not installed.
    """
    script = driver()
    task = task_of(domain, facts)
    problem = problem_of(task, facts, goals, excluded)
    if isinstance(problem, Unreachable):
        return unreachable_goal(task, facts, problem.goal, excluded)
    mutexes = mutexes_of(task, facts)
    purse = Budget(budget)
    proof = quick_proof(problem, mutexes, purse, facts, excluded)
    if proof is not None:
        return proof
    if problem.init & problem.goal == problem.goal:
        return Plan(())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "task.sas").write_text("\n".join(_sas(problem, _variables(problem, mutexes))) + "\n")
        options = ["--plan-file", "plan", "--alias", alias, "--search-time-limit", str(seconds)]
        done = subprocess.run(
            [sys.executable, str(script), *options, "task.sas"], cwd=folder, capture_output=True, text=True, check=False
        )
        counts = _EXPANDED.findall(done.stdout)
        expansions = int(counts[-1]) if counts else 0
        if done.returncode == _SOLVED and (folder / "plan").is_file():
            lines = (folder / "plan").read_text().splitlines()
            found = tuple(int(line.strip("()").split()[0][1:]) for line in lines if line.startswith("("))
            return Plan(tuple(task.ground(problem.ops[a]) for a in shortened(problem, found)), expansions)
    if done.returncode in _UNSOLVABLE:
        return smallest(problem, goals, purse, facts, excluded)
    if done.returncode in _OUT_OF_RESOURCES:
        return OutOfBudget(expansions)
    raise LlmbtError(
        Diagnostic("E076", f"Fast Downward failed ({done.returncode})", notes=tuple(done.stderr.splitlines()[-5:])),
        exit_code=ExitCode.INTERNAL,
    )


@dataclass(frozen=True, slots=True)
class _Variables:
    """The bits of each variable; its last value is that none of them holds."""

    members: tuple[tuple[int, ...], ...]
    place: dict[int, tuple[int, int]]


def _variables(problem: Problem, mutexes: Mutexes) -> _Variables:
    """Large groups of mutually exclusive literals first, then every literal for itself."""
    bit = {p: i for i, p in enumerate(problem.literals)}
    groups: dict[tuple[int, ...], list[int]] = {}
    for p, i in bit.items():
        if not p & 1 and not mutexes.task.related.get(p >> 1):
            for key in mutexes.keys(p >> 1):
                groups.setdefault(key, []).append(i)
    left = set(range(problem.n))
    members: list[tuple[int, ...]] = []
    for _, group in sorted(groups.items(), key=lambda kv: (-len(kv[1]), kv[0])):
        free = tuple(i for i in group if i in left)
        if len(free) > 1:
            members.append(free)
            left.difference_update(free)
    members += [(i,) for i in sorted(left)]
    return _Variables(tuple(members), {i: (v, k) for v, group in enumerate(members) for k, i in enumerate(group)})


def _sas(problem: Problem, variables: _Variables) -> Iterator[str]:
    """The task in the translator's output format, version 3."""
    members, place = variables.members, variables.place
    yield from ("begin_version", "3", "end_version", "begin_metric", "0", "end_metric", str(len(members)))
    for v, group in enumerate(members):
        yield from ("begin_variable", f"var{v}", "-1", str(len(group) + 1))
        yield from (f"Atom l{i}()" for i in group)
        yield from ("<none of those>", "end_variable")
    yield "0"
    yield "begin_state"
    for group in members:
        yield str(next((k for k, i in enumerate(group) if problem.init >> i & 1), len(group)))
    yield "end_state"
    yield from ("begin_goal", str(problem.goal.bit_count()))
    yield from (f"{place[i][0]} {place[i][1]}" for i in bits(problem.goal))
    yield "end_goal"
    operators = [lines for a in range(len(problem.ops)) if (lines := _operator(problem, variables, a)) is not None]
    yield str(len(operators))
    for lines in operators:
        yield from lines
    yield "0"


def _operator(problem: Problem, variables: _Variables, a: int) -> list[str] | None:
    """One action; None where it needs two values of a variable."""
    members, place = variables.members, variables.place
    before: dict[int, int] = {}
    for i in problem.pre_ids[a]:
        v, k = place[i]
        if v in before:
            return None
        before[v] = k
    after = {place[i][0]: place[i][1] for i in problem.add_ids[a]}
    effects = [f"0 {v} {before.get(v, -1)} {k}" for v, k in after.items() if before.get(v) != k]
    ended: dict[int, list[int]] = {}
    for i in bits(~problem.keep[a] & ((1 << problem.n) - 1)):
        v, k = place[i]
        if v not in after:
            ended.setdefault(v, []).append(k)
    for v, values in ended.items():
        none = len(members[v])
        if v in before:
            if before[v] in values:
                effects.append(f"0 {v} {before[v]} {none}")
                after[v] = none
        elif len(values) == none:
            effects.append(f"0 {v} -1 {none}")
        else:
            effects += [f"1 {v} {k} {v} -1 {none}" for k in values]
    prevail = [f"{v} {k}" for v, k in before.items() if after.get(v, k) == k]
    return [
        "begin_operator",
        f"a{a}",
        str(len(prevail)),
        *prevail,
        str(len(effects)),
        *effects,
        "1",
        "end_operator",
    ]
