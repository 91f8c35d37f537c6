"""One episode by one method: how it ended against what is true, what it cost, and, of the whole loop, whether it keeps
what the design note claims."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np

from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Facts, satisfied
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.baselines import Limits, Run, run
from llmbt_runtime.episodes import Episode, reachable
from llmbt_runtime.executor import Change, execute
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.search import search
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.update import loop
from llmbt_runtime.update.rollout import Certificate, rollout

LIMITS = Limits(ticks=600, expansions=20_000, updates=100, nodes=1_000, attempts=10)
"""Ten attempts: the failures of these episodes are dice, and three in a row would only measure them."""


@dataclass(frozen=True)
class Row:
    """One run, judged. `right`: UNSOLVABLE, and it is so; `wrong`: a verdict that is not true."""

    kind: str
    events: int
    fired: int
    failed: int
    rough: bool
    seed: int
    solvable: bool | None
    method: str
    outcome: Outcome
    reason: str
    stuck: bool
    right: bool
    wrong: bool
    nodes: int
    actions: int
    updates: int
    planner_calls: int
    ms: float
    verified: bool
    moves: int
    linked: bool
    chained: bool
    violations: tuple[str, ...] = ()

    @property
    def solved(self) -> bool:
        return self.outcome is Outcome.SUCCESS


class Watched(SymbolicWorld):
    """A symbolic world that notes each start of an action: when, in which state, and which one."""

    starts: list[tuple[float, Facts, ActionCall]]

    def start(self, action: ActionCall) -> None:
        self.starts.append((self.time_s, self.truth(), action))
        super().start(action)


def watched(episode: Episode) -> Watched:
    """The episode's world, watched."""
    world = Watched(
        episode.domain,
        episode.facts,
        np.random.default_rng([episode.seed, 7]),
        ticks=episode.ticks,
        failure_rate=episode.failure_rate,
        events=episode.events,
    )
    world.starts = []
    return world


def measure(episode: Episode, events: int, method: str, *, check: bool = True, limits: Limits = LIMITS) -> Row:
    """Run a method on an episode."""
    world, domain = watched(episode), episode.fresh()
    changes: list[tuple[int, Change]] = []
    calls = 0

    def counted(*args: object, **kwargs: object) -> object:
        nonlocal calls
        calls += 1
        return search(*args, **kwargs)  # type: ignore[arg-type]

    with patch.object(loop, "search", counted):
        began = time.process_time()
        found = run(method, world, domain, episode.goals, limits, keep=lambda c: changes.append((len(world.starts), c)))
        ms = (time.process_time() - began) * 1000
    right, wrong = _verdict(episode, found, world)
    kinds = [s.kind for _, c in changes for s in c.grown.steps]
    broken: tuple[str, ...] = ()
    if method == "loop" and check:
        broken = (*_judged(episode, found, right, wrong), *violations(episode, found, world, changes, calls))
    return Row(
        episode.kind,
        events,
        len(world.disturbances()),
        sum(a.result == "FAILURE" for a in found.actions),
        episode.failure_rate > 0,
        episode.seed,
        episode.solvable,
        method,
        found.outcome,
        found.reason,
        found.stuck,
        right,
        wrong,
        found.nodes,
        len(found.actions),
        found.updates,
        found.planner_calls,
        ms,
        episode.verified,
        sum(k == "move" for k in kinds),
        any(c.grown.planner_calls and any(s.kind == "goals" for s in c.grown.steps) for _, c in changes),
        "chain" in kinds,
        broken,
    )


def _verdict(episode: Episode, found: Run, world: SymbolicWorld) -> tuple[bool, bool]:
    """Whether an UNSOLVABLE is right, and whether a verdict is wrong, from the state in which it was given."""
    if found.outcome is Outcome.SUCCESS:
        return False, not satisfied(episode.goals, world.truth())
    if found.outcome is not Outcome.UNSOLVABLE:
        return False, False
    truth = reachable(episode.domain, world.truth(), episode.goals)
    if truth is None:
        truth = episode.solvable
    return truth is False, truth is True


def _judged(episode: Episode, found: Run, right: bool, wrong: bool) -> list[str]:
    """UNSOLVABLE where it is so and only there; and the goals where they can be reached."""
    broken = []
    if wrong:
        broken.append(f"wrong verdict {found.outcome}: {found.reason}")
    if episode.solvable is True and found.outcome is not Outcome.SUCCESS:
        broken.append(f"solvable, but {found.outcome}: {found.reason}")
    if episode.solvable is not True and not right and found.outcome is not Outcome.SUCCESS:
        broken.append(f"no verdict where one is due: {found.outcome}: {found.reason}")
    return broken


def violations(
    episode: Episode, found: Run, world: Watched, changes: list[tuple[int, Change]], calls: int
) -> list[str]:
    """What is claimed of the whole loop and does not hold of this run."""
    broken = []
    failures = sum(a.result == "FAILURE" for a in found.actions)
    fired = world.disturbances()
    allowed = (1 + len(fired) + failures) * len(episode.goals)
    if found.planner_calls > allowed:
        broken.append(f"{found.planner_calls} planner calls, {allowed} allowed")
    if calls > allowed:
        broken.append(f"{calls} searches made, {allowed} allowed ({found.planner_calls} reported)")
    broken += _too_long(episode, found, world, changes)
    broken += _restarts(episode, [c for _, c in changes])
    broken += _lost(episode, [c for _, c in changes])
    return broken


def _too_long(episode: Episode, found: Run, world: Watched, changes: list[tuple[int, Change]]) -> list[str]:
    """Actions after the last disturbance or failure, against the certificate from where it left things."""
    if found.outcome is not Outcome.SUCCESS:
        return []
    last = max(
        [d.fired_at_s for d in world.disturbances()] + [a.ended_s for a in found.actions if a.result == "FAILURE"],
        default=0.0,
    )
    after = [k for k, (at, _, _) in enumerate(world.starts) if at >= last]
    if not after:
        return []
    first = after[0]
    tree: Tree = goal_tree(episode.goals)
    for starts, change in changes:
        if starts <= first:
            tree = change.grown.tree
    facts = world.starts[first][1]
    certificate = rollout(tree, episode.domain.for_state(facts), facts, episode.goals)
    if not isinstance(certificate, Certificate):
        return [f"acts with a tree that does not certify: {certificate.kind}"]
    done = [call for _, _, call in world.starts[first:]]
    if len(done) > len(certificate.actions):
        return [f"{len(done)} actions after the last disturbance, the certificate has {len(certificate.actions)}"]
    predicted = [a.call for a in certificate.actions]
    if done != predicted:
        return ["the actions after the last disturbance are not those of the certificate"]
    return []


def _restarts(episode: Episode, changes: list[Change]) -> list[str]:
    """Every version, from the state it was made for, in a world where nothing else happens."""
    broken = []
    for number, change in enumerate(changes, 1):
        domain: Domain = replace(episode.domain.for_state(change.facts))
        world = SymbolicWorld(domain, change.facts, np.random.default_rng([episode.seed, number]), ticks=episode.ticks)
        result = execute(world, domain, change.grown.tree, episode.goals, keep=lambda _: "changed")
        predicted = [a.call for a in change.grown.certificate.actions]
        if result.outcome is not Outcome.SUCCESS:
            broken.append(f"version {number}, restarted, ends with {result.outcome}: {result.reason}")
        elif result.updates or [a.call for a in result.actions] != predicted:
            broken.append(f"version {number}, restarted, does something else than its certificate")
    return broken


def _lost(episode: Episode, changes: list[Change]) -> list[str]:
    """Nodes that are gone from a version without a step that says so."""
    broken = []
    before = goal_tree(episode.goals)
    for number, change in enumerate(changes, 1):
        tree = change.grown.tree
        gone = {n.id for n in before.preorder()} - {n.id for n in tree.preorder()}
        if gone and not {s.kind for s in change.grown.steps} & {"remove", "prune", "chain", "goals"}:
            broken.append(f"version {number} lost {len(gone)} nodes and does not say so")
        before = tree
    return broken
