"""Ticks a tree against a world and lets it grow: no action starts before the installed tree is certified.

Each tick (0.1 s simulated): the world goes on, the facts are looked at, and where they are not what the certificate
predicts the tree is certified anew from them, changed only if that fails (docs/update-loop.md).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Condition, Facts, Goals, holds, satisfied
from llmbt_ir.tree import Tree
from llmbt_runtime.engine.ticker import Ticker
from llmbt_runtime.failures import Failures, shortfall
from llmbt_runtime.outcome import Executed, Happening, Outcome, Result
from llmbt_runtime.search import OutOfBudget, Planner, Unsolvable
from llmbt_runtime.tick import NodeStatus
from llmbt_runtime.update.loop import Grown, Kept, update
from llmbt_runtime.update.prune import prune
from llmbt_runtime.view import View
from llmbt_runtime.world import ActionReport, Status, World, WorldLostError

__all__ = ["Change", "Settings", "Updater", "execute"]


@dataclass(frozen=True, slots=True)
class Settings:
    """Limits. `budget` counts state expansions of the search over the whole run; `max_ticks` guards against a world
    that never comes to an end; `attempts` is how often an action may fail before it is excluded; a tree of more than
    `max_nodes` nodes is pruned of what its certificate does not run; so many times in a row what is seen and the truth
    may disagree about the goals before the run ends."""

    budget: int = 200_000
    max_ticks: int = 20_000
    attempts: int = 3
    calm_ticks: int = 3
    patience_ticks: int = 40
    settle_s: float = 0.5
    disagreements: int = 10
    max_nodes: int = 400


class Updater(Protocol):
    """`llmbt_runtime.update.loop.update`, or what stands in its place."""

    def __call__(
        self,
        tree: Tree,
        domain: Domain,
        facts: Facts,
        goals: Goals,
        *,
        excluded: frozenset[ActionCall] = frozenset(),
        budget: int = 200_000,
        planner: Planner | None = None,
    ) -> Kept | Grown | Unsolvable | OutOfBudget:
        """The tree to run from an observed state."""


@dataclass(frozen=True, slots=True)
class Change:
    """A change of the tree to be kept as a version: what was observed, and the certified tree that follows. Planner
    calls and expansions are all since the version before, those that led to no version too."""

    tick: int
    time_s: float
    cause: str
    began: Facts
    ended: Facts
    facts: Facts
    grown: Grown
    planner_calls: int = 0
    expansions: int = 0


def execute(
    world: World,
    domain: Domain,
    tree: Tree,
    goals: Goals,
    *,
    keep: Callable[[Change], str],
    tell: Callable[[Happening], None] = lambda _: None,
    settings: Settings | None = None,
    planner: Planner | None = None,
    updater: Updater = update,
) -> Result:
    """Run a tree until the goals hold by the truth, or it is shown that they cannot be reached.

    `keep` stores a changed tree before anything acts on it and returns the version's name; `tell` hears the story;
    `planner` is asked in place of our own search; `updater` says what becomes of a tree (another than `update` is for
    comparison only).
    KeyboardInterrupt is passed on after the world was halted.
    """
    return _Run(world, domain, tree, goals, keep, tell, settings or Settings(), planner, updater).run()


class _Run:
    """The mutable state of one execution."""

    def __init__(
        self,
        world: World,
        domain: Domain,
        tree: Tree,
        goals: Goals,
        keep: Callable[[Change], str],
        tell: Callable[[Happening], None],
        settings: Settings,
        planner: Planner | None,
        updater: Updater,
    ) -> None:
        self.world, self.domain, self.tree, self.goals = world, domain, tree, goals
        self.keep, self.tell, self.settings, self.planner, self.updater = keep, tell, settings, planner, updater
        self.ticker = Ticker()
        self.ticks = self.updates = self.planner_calls = self.expansions = 0
        self.executed: list[Executed] = []
        self.running: tuple[str, GroundAction, float] | None = None
        self.view = View(world)
        self.certified = False
        self.began: Facts = frozenset()
        self.failures = Failures(settings.attempts)
        self.told_disturbances = self.disagreed = 0
        self.told_search = 0, 0

    # -- the loop -------------------------------------------------------------------------------------------------

    def run(self) -> Result:
        """Tick until the end."""
        try:
            while self.ticks < self.settings.max_ticks:
                result = self.step()
                if result is not None:
                    return result
        except KeyboardInterrupt:
            self.stop("interrupted")
            return self.end(Outcome.INTERRUPTED, "interrupted by the user")
        except WorldLostError as lost:
            return self.end(Outcome.WORLD_LOST, str(lost))
        under_way = f"; {self.running[1].call} is under way" if self.running else ""
        self.stop("the guard on ticks")
        return self.end(Outcome.BUDGET, f"no end after {self.ticks} ticks{under_way}")

    def step(self) -> Result | None:
        """One tick of the tree; None while there is more to do."""
        self.view.look()
        if not (self.certified and self.view.as_expected(self.running[1] if self.running else None)):
            ended = self.certify()
            if ended is not None:
                return ended
            if not self.certified:
                # nothing is certified: go on with what runs, and start nothing
                self.advance()
                return None
            self.view.look()
        record = self.ticker.tick(self.tree, self.view.shown)
        if record.status is NodeStatus.SUCCESS:
            self.stop("the goals hold")
            return self.check_success()
        if record.action is None:
            # what was certified fails all the same: observe and certify again
            self.certified = False
            self.advance()
            return None
        call = self.tree[record.action].action
        assert call is not None
        if self.running is None or self.running[1].call != call:
            if self.running is not None:
                self.stop(f"{call} comes first")
                return None
            self.begin(record.action, call)
        self.advance()
        return None

    def advance(self) -> None:
        """One tick of the world; the end of an action is noted."""
        report = self.world.advance()
        self.ticks += 1
        self.note_disturbances()
        if self.running is not None and report.status in (Status.SUCCESS, Status.FAILURE):
            self.finish(report)

    # -- actions --------------------------------------------------------------------------------------------------

    def begin(self, node: str, call: ActionCall) -> None:
        action = self.domain.action(call)
        assert action is not None
        self.began = self.world.observe()
        self.world.start(call)
        self.running = (node, action, self.world.time_s)
        self.view.runs(action)
        self.say("started", str(call), action=str(call), node=node)

    def finish(self, report: ActionReport) -> None:
        """Note how the running action ended; a success that did not bring its Post about counts as a failure."""
        assert self.running is not None
        _, action, since = self.running
        self.running = None
        self.view.runs(None)
        observed = self.world.observe()
        reason = shortfall(action, self.began, observed, report) or self.failures.came_back(observed)
        result = "FAILURE" if reason else "SUCCESS"
        self.executed.append(Executed(action.call, result, reason, since, self.world.time_s))
        text = f"{action.call}: {result}" + (f" ({reason})" if reason else "")
        self.say("ended", text, result=result, reason=reason)
        if reason:
            self.certified = False
            self.failures.failure(action.call, reason, observed, report.denies)
            return
        self.failures.success(action.call)
        if self.certified:
            self.view.expect(action)

    def stop(self, why: str) -> None:
        """Halt the running action and wait until it has come out of its contact phase."""
        if self.running is None:
            return
        _, action, since = self.running
        while not self.world.halt():
            report = self.world.advance()
            self.ticks += 1
            if report.status in (Status.SUCCESS, Status.FAILURE):
                self.finish(report)
                return
        self.running = None
        self.view.runs(None)
        self.certified = False
        self.executed.append(Executed(action.call, "HALTED", why, since, self.world.time_s))
        self.say("ended", f"{action.call}: HALTED ({why})", result="HALTED", reason=why)

    # -- prediction and update ------------------------------------------------------------------------------------

    def certify(self) -> Result | None:
        """Certify the installed tree from what is seen, or install one that is; None when it may act."""
        facts = self.view.facts
        found = self.updated(facts)
        if found is None:
            return None
        if self.running is not None and isinstance(found, Grown) and self.goes_on(found):
            # what changed concerns later actions: the running one is not halted for it
            if self.world.at_rest:
                self.install(found, facts)
            return None
        # the tree does not serve: stop, and let things come to rest before anything is concluded
        asked = facts, frozenset(self.failures.excluded)
        self.stop("the tree no longer leads to the goals")
        facts = self.calm()
        if satisfied(self.goals, facts):
            return self.check_success()
        if (facts, frozenset(self.failures.excluded)) != asked:
            found = self.updated(facts)
        if found is None:
            return None
        if isinstance(found, Grown):
            self.install(found, facts)
            return None
        self.note_deviation("no tree is found")
        if isinstance(found, OutOfBudget):
            return self.end(Outcome.BUDGET, f"no plan within {self.settings.budget} expansions")
        if self.failures.excluded:
            anyway = self.asked(facts, frozenset())
            if not isinstance(anyway, Unsolvable):
                return self.end(Outcome.ACTION_FAILED, self.failures.told())
            found = anyway
        if denied := self.failures.denied_in(facts):
            anyway = self.asked(facts | set(denied), frozenset())
            if not isinstance(anyway, Unsolvable):
                return self.end(Outcome.ACTION_FAILED, self.failures.told_of(denied))
        return self.end(Outcome.UNSOLVABLE, found.reason, found.goals)

    def goes_on(self, found: Grown) -> bool:
        """Whether a changed tree begins with the action that is running."""
        assert self.running is not None
        actions = found.certificate.actions
        return bool(actions) and actions[0].call == self.running[1].call

    def install(self, found: Grown, facts: Facts) -> None:
        """Keep a certified tree as a version, then let it act."""
        first = not self.view.expects
        began, ended = self.view.began, self.view.ended
        cause = "the goals do not hold yet" if first else self.cause(began, ended)
        calls, expansions = self.planner_calls - self.told_search[0], self.expansions - self.told_search[1]
        self.told_search = self.planner_calls, self.expansions
        change = Change(self.ticks, self.world.time_s, cause, began, ended, facts, found, calls, expansions)
        version = self.keep(change)
        self.put(found, version, cause)
        if len(self.tree) > self.settings.max_nodes:
            self.prune(found, facts)

    def put(self, found: Grown, version: str, cause: str) -> None:
        self.tree = found.tree
        self.updates += 1
        self.accept()
        edits = [s.told() for s in found.steps]
        self.say("update", f"{version}: {cause}", version=version, nodes=len(found.tree), edits=edits)

    def prune(self, found: Grown, facts: Facts) -> None:
        """Take out what the certificate does not run, as a version of its own."""
        excluded = frozenset(self.failures.excluded)
        smaller = prune(self.tree, self.domain, facts, self.goals, found.certificate, excluded=excluded)
        if smaller is not None:
            cause = f"the tree has {len(self.tree)} nodes, more than {self.settings.max_nodes}"
            nothing: Facts = frozenset()
            version = self.keep(Change(self.ticks, self.world.time_s, cause, nothing, nothing, facts, smaller))
            self.put(smaller, version, cause)

    def updated(self, facts: Facts) -> Grown | Unsolvable | OutOfBudget | None:
        """What the update loop says of the tree from these facts; None where it serves as it is."""
        self.failures.forgive(facts)
        found = self.asked(facts, frozenset(self.failures.excluded))
        if isinstance(found, Kept):
            self.note_deviation("the tree serves as it is")
            self.accept()
            return None
        return found

    def asked(self, facts: Facts, excluded: frozenset[ActionCall]) -> Kept | Grown | Unsolvable | OutOfBudget:
        """What the update loop says without some actions; what the search for it cost is noted."""
        self.domain = self.domain.for_state(facts)
        found = self.updater(
            self.tree,
            self.domain,
            facts,
            self.goals,
            excluded=excluded,
            budget=max(0, self.settings.budget - self.expansions),
            planner=self.planner,
        )
        if not isinstance(found, Kept):
            self.planner_calls += found.planner_calls if isinstance(found, Grown) else len(self.goals)
            self.expansions += found.expansions
        return found

    def note_deviation(self, so: str) -> None:
        """Tell what was not predicted where no other tree comes of it."""
        under_way = self.running[1].deletes if self.running else frozenset()
        began, ended = self.view.began, self.view.ended - under_way
        if began or ended:
            text = f"{self.cause(began, ended)}: {so}"
            self.say("deviation", text, began=[str(f) for f in sorted(began)], ended=[str(f) for f in sorted(ended)])

    def accept(self) -> None:
        """From what is seen now the installed tree is certified."""
        self.view.accept()
        self.certified = True

    def calm(self) -> Facts:
        """The facts once they have stayed the same for a while and nothing moves, or after a bounded wait."""
        facts, same = self.view.look().facts, 0
        for _ in range(self.settings.patience_ticks):
            if same >= self.settings.calm_ticks and self.world.at_rest:
                break
            self.advance()
            now = self.view.look().facts
            same = same + 1 if now == facts else 0
            facts = now
        return facts

    def cause(self, began: Facts, ended: Facts) -> str:
        """The difference between what was expected and what is observed, in words."""
        parts = [f"no longer {self.some(ended)}"] if ended else []
        parts += [f"now {self.some(began)}"] if began else []
        return "; ".join(parts) or self.failures.last or "the tree failed"

    def some(self, facts: Facts) -> str:
        """A few facts; what another of them implies by containment is left out."""
        implied = {u for f in facts for u in self.domain.upward(f) if u != f}
        named = [str(f) for f in sorted(facts - implied)]
        return ", ".join(named[:4]) + (", ..." if len(named) > 4 else "")

    # -- the end --------------------------------------------------------------------------------------------------

    def check_success(self) -> Result | None:
        """The goals by the truth, after a settling time; None where one does not hold after all."""
        self.world.settle(self.settings.settle_s)
        self.note_disturbances()
        truth = self.world.truth()
        if satisfied(self.goals, truth):
            return self.end(Outcome.SUCCESS, "")
        self.certified = False
        self.ticks += 1
        self.disagreed = self.disagreed + 1 if satisfied(self.goals, self.world.observe()) else 0
        if self.disagreed < self.settings.disagreements:
            return None
        wrong = ", ".join(str(g) for goals in self.goals for g in goals if not holds(g, truth))
        return self.end(Outcome.ACTION_FAILED, f"by what is seen the goals hold, by the truth not: {wrong}")

    def end(self, outcome: Outcome, reason: str, unsolvable: tuple[Condition, ...] = ()) -> Result:
        truth = self.world.truth()
        self.say("outcome", outcome.value + (f": {reason}" if reason else ""), outcome=outcome.value)
        return Result(
            outcome,
            reason,
            tuple((g, k, holds(g, truth)) for k, goals in enumerate(self.goals, 1) for g in goals),
            tuple(self.executed),
            self.updates,
            self.ticks,
            self.planner_calls,
            self.expansions,
            self.world.time_s,
            unsolvable,
        )

    def note_disturbances(self) -> None:
        log = self.world.disturbances()
        for d in log[self.told_disturbances :]:
            broke = ", ".join(str(c) for c in d.broke)
            self.say("disturbance", f"{d.name} of {d.target}" + (f": ended {broke}" if broke else ""), d.fired_at_s)
        self.told_disturbances = len(log)

    def say(self, kind: str, text: str, at_s: float | None = None, **details: object) -> None:
        self.tell(Happening(kind, self.world.time_s if at_s is None else at_s, text, details))
