"""One method on one scenario, as a worker runs it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cache
from typing import Any

from llmbt.experiment.cases import Case, load_experiment
from llmbt.experiment.scenario import LIMITS, Scenario, open_world
from llmbt.experiment.study import Done
from llmbt.experiment.trial import judged
from llmbt_ir.diff import diff
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.baselines import STEPS_ONLY, run

__all__ = ["BaselineJob", "measured", "work"]

MAX_COMPARED = 5_000
"""Nodes of two trees together up to which they are compared node by node."""


@dataclass(frozen=True, slots=True)
class BaselineJob:
    """A scenario, a method, and where the scenario's experiment is read from."""

    scenario: Scenario
    method: str
    source: str

    @property
    def key(self) -> str:
        """The trial's name."""
        return f"{self.scenario.key}.{self.method}"


@cache
def _cases(source: str) -> dict[str, Case]:
    return {c.name: c for c in load_experiment(source).cases}


def work(job: BaselineJob) -> Done:
    """Run a method on a scenario; its line."""
    case = _cases(job.source)[job.scenario.case]
    found = measured(job.scenario, case, job.method)
    return Done(job.key, {"key": job.key, "method": job.method, **job.scenario.as_json(), **found})


def measured(scenario: Scenario, case: Case, method: str) -> dict[str, Any]:
    """What a method comes to, judged by the case's condition, by the truth at rest. Times are CPU seconds of this
    process, all else repeats."""
    goals = scenario.conditions()
    trees: list[tuple[float, Tree]] = []
    world = open_world(scenario, case)

    def grew(tree: Tree) -> None:
        trees.append((round(world.time_s, 3), tree))

    began = time.process_time()
    try:
        limits = LIMITS[scenario.world]
        found = run(method, world, case.domain(), goals, limits, grew=grew, clock=time.process_time)
        verdict = judged(case.success, world, found.outcome)
        end_s = world.time_s
        happened = world.disturbances()
    finally:
        world.close()
    seconds = time.process_time() - began
    with_tree = method not in STEPS_ONLY
    return {
        "verdict": "success" if verdict["success_by_truth"] else "failure",
        "outcome": found.outcome.value,
        "blamed": [str(c) for c in found.unsolvable],
        "stuck": found.stuck,
        "reason": found.reason,
        "actions": len(found.actions),
        "failed_actions": sum(a.result == "FAILURE" for a in found.actions),
        "planner_calls": found.planner_calls,
        "expansions": found.expansions,
        "updates": found.updates if with_tree else None,
        "nodes": found.nodes if with_tree else None,
        "changes": _changes(goal_tree(goals), trees) if with_tree and verdict["success_by_truth"] else [],
        "growth": [[at, len(t)] for at, t in trees] if with_tree else [],
        "disturbances": [[d.name, d.target, d.fired_at_s, d.recovered_at_s] for d in happened],
        "sim_time_s": round(end_s, 3),
        "ticks": found.ticks,
        "planning_s": round(found.planning_s, 6),
        "cpu_s": round(seconds, 4),
    }


def _changes(before: Tree, trees: list[tuple[float, Tree]]) -> list[list[float]]:
    """Of each change of the tree the simulated time, and how many nodes were added, removed, moved or changed. Where
    thousands of nodes are made anew all of them count."""
    sizes: list[list[float]] = []
    for at, tree in trees:
        large = len(before) + len(tree) > MAX_COMPARED
        sizes.append([at, len(before) + len(tree) if large else len(diff(before, tree))])
        before = tree
    return sizes
