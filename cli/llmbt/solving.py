"""Solving a PDDL problem: the update loop in the symbolic world, with all that a run leaves behind."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from llmbt.progress import Progress
from llmbt.recorded import goal_records, recorded
from llmbt_atl.pddl import PddlProblem, import_domain, import_problem, pddl_call, write_library
from llmbt_ir.condition import ActionCall
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import Provenance, write_tree
from llmbt_ir.versions import VersionStore, sha256, write_atomic
from llmbt_runtime.chance import chance
from llmbt_runtime.executor import Settings, execute
from llmbt_runtime.outcome import Happening, Outcome, Result
from llmbt_runtime.record import RunFolder, signatures_of
from llmbt_runtime.search import planner_named, task_of
from llmbt_runtime.symbolic import SymbolicWorld

__all__ = ["read_problem", "solve_problem"]


def read_problem(texts: tuple[str, str], sources: tuple[str, str]) -> PddlProblem:
    """A PDDL domain and problem, small enough to be written out in ground actions. E090-E096."""
    problem = import_problem(texts[1], import_domain(texts[0], sources[0]), sources[1])
    task_of(problem.domain, problem.facts)
    return problem


def solve_problem(
    problem: PddlProblem,
    folder: Path,
    progress: Progress,
    *,
    seed: int,
    budget: int,
    failure_rate: float,
    planner: str = "own",
) -> dict[str, Any]:
    """Run the loop on a PDDL problem; `result.json`'s content, in PDDL's names. E075 for a planner that is not
    installed. A goal that is true or false whatever holds makes no tree."""
    asked = planner_named(planner)
    started = time.monotonic()
    library, goals = problem.domain.library, problem.goals
    signatures, told = signatures_of(library), goal_records(goals)
    write_atomic(folder / "library.xml", write_library(library))
    world = SymbolicWorld(problem.domain, problem.facts, chance(seed, "world"), failure_rate=failure_rate)
    decided = _decided(problem)
    if decided is None:
        tree = goal_tree(goals)
        xml = write_tree(tree, signatures, Provenance(goals=told))
        VersionStore(folder).append(xml, {"parent": None, "problem": problem.name}, 0)
        run = RunFolder(folder, signatures, told, 0, sha256(xml), "tree.v000.xml")
    else:
        run = RunFolder(folder, signatures, told, -1, "", "")

    def act(tell: Callable[[Happening], None]) -> Result:
        if decided is not None:
            text = decided.outcome.value + (f": {decided.reason}" if decided.reason else "")
            tell(Happening("outcome", 0.0, text, {"outcome": decided.outcome.value}))
            return decided
        settings = Settings(budget, max_ticks=200_000)
        return execute(world, problem.domain, tree, goals, keep=run.keep, tell=tell, settings=settings, planner=asked)

    document = recorded(
        act,
        world,
        run,
        progress,
        started=started,
        seed=seed,
        extra={"problem": problem.name, "world": "symbolic", "planner": planner},
        names={name: (t.words.split() or [name])[0] for name, t in library.templates.items()},
    )
    done = [ActionCall(a["template"], tuple(a["args"])) for a in document["actions"] if a["result"] == "SUCCESS"]
    write_atomic(folder / "plan.txt", "".join(f"{pddl_call(library, c)}\n" for c in done).encode())
    return document


def _decided(problem: PddlProblem) -> Result | None:
    """The end of a problem whose goal says nothing of the state: `(and)` holds, `(or)` never does."""
    if problem.goals and () not in problem.goals:
        return None
    if problem.goals:
        return Result(Outcome.SUCCESS, "", (), (), 0, 0, 0, 0, 0.0)
    return Result(Outcome.UNSOLVABLE, "the goal is false whatever holds", (), (), 0, 0, 0, 0, 0.0)
