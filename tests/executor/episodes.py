"""Episodes in the world of facts, run through everything that a real execution goes through."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Condition, Facts, Goals
from llmbt_ir.tree import Tree, goal_tree
from llmbt_ir.tree_xml import GoalRecord
from llmbt_runtime.executor import Change, Settings, execute
from llmbt_runtime.outcome import Happening, Result
from llmbt_runtime.record import RunFolder, result_document, signatures_of, write_result
from llmbt_runtime.symbolic import Event, SymbolicWorld
from llmbt_runtime.update import loop
from llmbt_runtime.update.rollout import Certificate, rollout
from tests.oracle import Cargo
from tests.strategies import cargo_library, domain_for


@dataclass
class Episode:
    """What happened: the result, the changes in order, the story, and how often the search was asked."""

    result: Result
    changes: list[Change] = field(default_factory=list)
    story: list[Happening] = field(default_factory=list)
    searches: int = 0
    disturbances: int = 0
    uncertified: list[str] = field(default_factory=list)

    @property
    def failures(self) -> int:
        return sum(e.result == "FAILURE" for e in self.result.actions)


class Watched(SymbolicWorld):
    """Looks over the executor's shoulder: what is started is the first action that the installed tree's rollout from
    the facts predicts."""

    def watch(self, domain: Domain, goals: Goals, tree: list[Tree], told: list[str]) -> None:
        self.over = (domain, goals, tree, told)

    def start(self, action: ActionCall) -> None:
        domain, goals, tree, told = self.over
        domain = domain.for_state(self.observe())
        self.over = (domain, goals, tree, told)
        found = rollout(tree[-1], domain, self.observe(), goals)
        if not isinstance(found, Certificate):
            told.append(f"{action} started, and the tree is not certified: {found.kind}")
        elif found.actions[0].call != action:
            told.append(f"{action} started, predicted was {found.actions[0]}")
        super().start(action)


def play(
    cargo: Cargo,
    goals: Goals,
    seed: int,
    *,
    ticks: tuple[int, int] = (1, 8),
    failure_rate: float = 0.0,
    events: tuple[Event, ...] = (),
    folder: Path | None = None,
    settings: Settings | None = None,
    world_type: type[Watched] = Watched,
) -> Episode:
    """One episode; with a folder, its versions, its story and its result are written there."""
    domain, facts = domain_for(cargo), cargo.facts()
    world = world_type(
        domain, facts, np.random.default_rng(seed), ticks=ticks, failure_rate=failure_rate, events=events
    )
    trees, told = [goal_tree(goals)], list[str]()
    world.watch(domain, goals, trees, told)
    changes: list[Change] = []
    story: list[Happening] = []
    records = tuple(
        GoalRecord(f"g{i}", c, "", k) for i, (k, c) in enumerate(((k, c) for k, g in enumerate(goals, 1) for c in g), 1)
    )
    run = RunFolder(folder, signatures_of(cargo_library()), records, 0, "", "tree.v000.xml") if folder else None

    def keep(change: Change) -> str:
        changes.append(change)
        trees.append(change.grown.tree)
        return run.keep(change) if run else f"v{len(changes):03d}"

    def tell(happening: Happening) -> None:
        story.append(happening)
        if run:
            run.tell(happening)

    with patch.object(loop, "search", wraps=loop.search) as search:
        result = execute(world, domain, trees[0], goals, keep=keep, tell=tell, settings=settings)
    if run and folder:
        document = result_document(result, world, versions=len(changes) + 1, seed=seed, wall_time_s=0.0, extra={})
        write_result(folder, document)
    return Episode(result, changes, story, search.call_count, len(world.disturbances()), told)


def others(domain: Domain, facts: Facts, rng: np.random.Generator, count: int) -> tuple[Event, ...]:
    """Legal actions of somebody else at random times: things are put elsewhere, moved aside, cleared away."""
    names = ("place", "move_aside", "clear_away", "put_down")
    able = [a for a in domain.actions if a.call.name in names]
    # "cleared away from the shelf" frees no slot in the model (tests/atl/test_state.py, xfail): no legal action
    able = [a for a in able if a.call.name != "clear_away" or domain.fits(a.call.args[2], "spot")]
    events = []
    for _ in range(count if able else 0):
        a = able[int(rng.integers(len(able)))]
        when: tuple[Condition, ...] = a.pre
        events.append(Event(int(rng.integers(1, 40)), a.deletes, a.adds, when, "other", str(a)))
    return tuple(events)


def read(folder: Path) -> dict[str, Any]:
    """The bytes of every file in a run's folder."""
    return {p.name: p.read_bytes() for p in sorted(folder.iterdir())}
