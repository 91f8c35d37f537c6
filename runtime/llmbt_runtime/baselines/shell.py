"""What the methods share: ticking a tree against a world, starting and halting its actions, and where they differ.

The world is looked at as the executor looks at it (`perceived`), ticks and budgets are counted alike.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Condition, Facts, Goals, satisfied
from llmbt_ir.tree import Tree
from llmbt_runtime.outcome import Executed, Outcome
from llmbt_runtime.tick import NodeStatus, TickRecord, tick
from llmbt_runtime.update.rollout import perceived
from llmbt_runtime.world import Status, World

__all__ = ["Ended", "Limits", "Policy", "Run", "carry_on"]


@dataclass(frozen=True, slots=True)
class Limits:
    """The same for every method: ticks of the world, state expansions of a search, changes and nodes of a tree.

    `attempts`: how often an action may fail before the whole loop excludes it; the other methods try for ever.
    `patience_ticks`: so long a method is let wait for the world to come to rest before its tree is changed, and for
    something to change before it counts as stuck; in a world of facts, where nothing rolls, there is no need to.
    """

    ticks: int = 1_000
    expansions: int = 100_000
    updates: int = 500
    nodes: int = 1_500
    attempts: int = 3
    settle_s: float = 0.5
    patience_ticks: int = 0


@dataclass(frozen=True, slots=True)
class Ended:
    """A method's own verdict. `stuck`: it knows no change of the tree, and claims nothing about the problem."""

    outcome: Outcome
    reason: str
    unsolvable: tuple[Condition, ...] = ()
    stuck: bool = False


@dataclass(frozen=True, slots=True)
class Run:
    """What a method came to. `nodes` is the largest tree that acted; a method that is stuck has the outcome BUDGET.

    `planning_s`: time spent on changing the tree, by the clock that was handed in; 0 without one.
    """

    method: str
    outcome: Outcome
    reason: str
    stuck: bool
    actions: tuple[Executed, ...]
    updates: int
    planner_calls: int
    expansions: int
    nodes: int
    ticks: int
    tree: Tree
    unsolvable: tuple[Condition, ...] = ()
    planning_s: float = 0.0

    @property
    def completed(self) -> tuple[ActionCall, ...]:
        """The actions that succeeded."""
        return tuple(a.call for a in self.actions if a.result == "SUCCESS")


class Policy(Protocol):
    """How one method changes a tree. It may keep a memory of the run; a new one is made for each run."""

    planner_calls: int
    expansions: int

    def objects(self, facts: Facts, running: GroundAction | None, /) -> bool:
        """Whether the tree is to be revised although it does not fail."""

    def revise(self, tree: Tree, domain: Domain, facts: Facts, record: TickRecord, /) -> Tree | Ended:
        """The tree to go on with, from a state at which no action runs."""

    def ended(self, action: GroundAction, success: bool, /) -> None:
        """Hear how an action ended."""


def carry_on(
    method: str,
    policy: Policy,
    world: World,
    domain: Domain,
    tree: Tree,
    goals: Goals,
    limits: Limits,
    keep: Callable[[Tree], None] = lambda _: None,
    clock: Callable[[], float] = lambda: 0.0,
) -> Run:
    """Run a tree until the goals hold by the truth, the method gives up, or a limit is reached. `keep` hears of every
    changed tree."""
    return _Shell(method, policy, world, domain, tree, goals, limits, keep, clock).run()


class _Shell:
    """The mutable state of one run."""

    def __init__(
        self,
        method: str,
        policy: Policy,
        world: World,
        domain: Domain,
        tree: Tree,
        goals: Goals,
        limits: Limits,
        keep: Callable[[Tree], None],
        clock: Callable[[], float],
    ) -> None:
        self.method, self.policy, self.world, self.limits = method, policy, world, limits
        self.domain, self.tree, self.goals, self.keep, self.clock = domain, tree, goals, keep, clock
        self.ticks = self.updates = self.largest = self.waited = 0
        self.planning_s = 0.0
        self.executed: list[Executed] = []
        self.running: tuple[GroundAction, float] | None = None

    def run(self) -> Run:
        """Tick until the end."""
        while self.ticks < self.limits.ticks:
            ended = self.step()
            if ended is not None:
                self.stop("the end")
                return self.result(ended)
        self.stop("the guard on ticks")
        return self.result(Ended(Outcome.BUDGET, f"no end after {self.ticks} ticks"))

    def step(self) -> Ended | None:
        """One tick of the tree."""
        facts = self.look()
        record = tick(self.tree, facts)
        if record.status is NodeStatus.SUCCESS:
            self.stop("the goals hold")
            return self.check_success()
        objects = self.policy.objects(facts, self.running[0] if self.running else None)
        if objects or record.status is NodeStatus.FAILURE or record.action is None:
            if self.running is not None:
                self.stop("the tree is to be revised")
                return None
            if not self.world.at_rest and self.waited < self.limits.patience_ticks:
                self.wait()
                return None
            return self.revise(facts, record)
        call = self.tree[record.action].action
        assert call is not None
        if self.running is not None and self.running[0].call != call:
            self.stop(f"{call} comes first")
            return None
        if self.running is None:
            action = self.domain.action(call)
            assert action is not None
            self.world.start(call)
            self.running = (action, self.world.time_s)
            self.largest = max(self.largest, len(self.tree))
        self.advance()
        return None

    def look(self) -> Facts:
        return perceived(self.world.observe(), self.running[0] if self.running else None)

    def revise(self, facts: Facts, record: TickRecord) -> Ended | None:
        """Let the method change the tree."""
        if self.updates >= self.limits.updates:
            return Ended(Outcome.BUDGET, f"{self.updates} changes of the tree")
        self.domain = self.domain.for_state(facts)
        began = self.clock()
        found = self.policy.revise(self.tree, self.domain, facts, record)
        self.planning_s += self.clock() - began
        if isinstance(found, Ended):
            if found.stuck and self.waited < self.limits.patience_ticks:
                self.wait()
                return None
            return found
        self.waited = 0
        self.tree = found
        self.updates += 1
        self.keep(found)
        if len(found) > self.limits.nodes:
            return Ended(Outcome.BUDGET, f"a tree of {len(found)} nodes")
        return None

    def wait(self) -> None:
        """Let one tick go by without an action."""
        self.waited += 1
        self.advance()

    def advance(self) -> None:
        report = self.world.advance()
        self.ticks += 1
        if self.running is not None and report.status in (Status.SUCCESS, Status.FAILURE):
            self.finish(report.status is Status.SUCCESS, report.reason)

    def finish(self, success: bool, reason: str) -> None:
        assert self.running is not None
        action, since = self.running
        self.running = None
        result = "SUCCESS" if success else "FAILURE"
        self.executed.append(Executed(action.call, result, reason, since, self.world.time_s))
        self.policy.ended(action, success)

    def stop(self, why: str) -> None:
        """Halt the running action and wait until it has come out of its contact phase."""
        while self.running is not None and not self.world.halt():
            self.advance()
        if self.running is not None:
            action, since = self.running
            self.running = None
            self.executed.append(Executed(action.call, "HALTED", why, since, self.world.time_s))
            self.policy.ended(action, False)

    def check_success(self) -> Ended | None:
        self.world.settle(self.limits.settle_s)
        if satisfied(self.goals, self.world.truth()):
            return Ended(Outcome.SUCCESS, "")
        self.ticks += 1
        return None

    def result(self, ended: Ended) -> Run:
        return Run(
            self.method,
            ended.outcome,
            ended.reason,
            ended.stuck,
            tuple(self.executed),
            self.updates,
            self.policy.planner_calls,
            self.policy.expansions,
            max(self.largest, len(self.tree)),
            self.ticks,
            self.tree,
            ended.unsolvable,
            self.planning_s,
        )
