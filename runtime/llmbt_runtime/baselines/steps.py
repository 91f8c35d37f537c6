"""A list of steps without a tree: one after another without feedback, with a retry, or the most feasible of those left.

The list is that of the plan for the scene as it is at the start, so it is right as long as nothing happens: more than a
language model's steps can promise. `Script` is how code that a model writes against a declared API runs (ChatGPT for
Robotics, Vemprala et al. 2023); `Feasible` chooses at each turn among its skills one that helps and can be done now,
wherever things are now, as SayCan (Ahn et al. 2022) and PaLM-E (Driess et al. 2023) do. Neither knows a step that was
not in the list.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from llmbt_atl.state import Domain, GroundAction, applicable
from llmbt_atl.template import Role
from llmbt_ir.condition import Condition, Facts, Goals, holds, satisfied
from llmbt_ir.tree import Kind, Node, Tree, goal_tree
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.search import OutOfBudget, Unsolvable
from llmbt_runtime.tick import TickRecord
from llmbt_runtime.update.loop import Kept, update

__all__ = ["FeasiblePolicy", "ScriptPolicy", "Steps", "from_elsewhere", "steps_for"]


@dataclass(frozen=True)
class Steps:
    """A plan with what each step is there for."""

    actions: tuple[GroundAction, ...]
    goals: tuple[Condition, ...]

    @cached_property
    def links(self) -> tuple[tuple[tuple[Condition, int | None], ...], ...]:
        """Of each step the facts that it brings about for a later step (its number), or for the goals (None)."""
        found: list[list[tuple[Condition, int | None]]] = [[] for _ in self.actions]
        wanted: list[tuple[int | None, tuple[Condition, ...]]] = [(j, a.pre) for j, a in enumerate(self.actions)]
        for j, conditions in [*wanted, (None, self.goals)]:
            for condition in conditions:
                before = range(len(self.actions) if j is None else j)
                maker = max((i for i in before if self.actions[i].achieves(condition)), default=None)
                if maker is not None:
                    found[maker].append((condition, j))
        return tuple(map(tuple, found))


def steps_for(domain: Domain, facts: Facts, goals: Goals, budget: int) -> Steps | Ended:
    """The steps from a state to the goals, as our own loop plans them; none where the goals hold."""
    found = update(goal_tree(goals), domain, facts, goals, budget=budget)
    if isinstance(found, Unsolvable):
        return Ended(Outcome.UNSOLVABLE, found.reason, found.goals)
    if isinstance(found, OutOfBudget):
        return Ended(Outcome.BUDGET, f"no plan within {budget} expansions")
    actions = () if isinstance(found, Kept) else found.certificate.actions
    return Steps(actions, goals[0])


def from_elsewhere(domain: Domain, action: GroundAction, other: GroundAction) -> bool:
    """Whether two actions are the same skill on the same thing to the same destination, from different places. Where a
    template does not say which parameter is which, the first is the thing."""
    if action.call.name != other.call.name or action.call == other.call:
        return False
    params = domain.library.templates[action.call.name].params
    same = [i for i, p in enumerate(params) if p.role in (Role.TARGET, Role.DESTINATION)] or [0]
    return bool(params) and all(action.call.args[i] == other.call.args[i] for i in same)


def _alone(action: GroundAction) -> Tree:
    """A tree that is this action."""
    return Tree("step", {"step": Node("step", Kind.ACTION, action=action.call)})


@dataclass
class ScriptPolicy:
    """The steps in their order, whatever is seen; one that fails is tried `attempts` times before the next."""

    goals: Goals
    budget: int
    attempts: int = 1
    planner_calls: int = 0
    expansions: int = 0
    steps: Steps | None = None
    at: int = 0
    tried: int = 0
    chosen: bool = False

    def objects(self, _facts: Facts, running: GroundAction | None) -> bool:
        """Between two steps the next one is to be chosen."""
        return running is None and not self.chosen

    def revise(self, _tree: Tree, domain: Domain, facts: Facts, _record: TickRecord) -> Tree | Ended:
        """The next step."""
        if self.steps is None:
            found = steps_for(domain, facts, self.goals, self.budget)
            self.planner_calls += 1
            if isinstance(found, Ended):
                return found
            self.steps = found
        while self.at < len(self.steps.actions):
            action = self.steps.actions[self.at]
            if domain.action(action.call) is not None:
                self.chosen = True
                return _alone(action)
            self.at += 1
        return Ended(Outcome.BUDGET, "the steps are done", stuck=True)

    def ended(self, _action: GroundAction, success: bool) -> None:
        """On to the next step, or the same again."""
        self.chosen = False
        self.tried += 1
        if success or self.tried >= self.attempts:
            self.at, self.tried = self.at + 1, 0


@dataclass
class FeasiblePolicy:
    """At each turn the first step that still helps and can be done now, on the same thing wherever it now is."""

    goals: Goals
    budget: int
    planner_calls: int = 0
    expansions: int = 0
    steps: Steps | None = None
    chosen: bool = False

    def objects(self, _facts: Facts, running: GroundAction | None) -> bool:
        """Between two steps the next one is to be chosen."""
        return running is None and not self.chosen

    def revise(self, _tree: Tree, domain: Domain, facts: Facts, _record: TickRecord) -> Tree | Ended:
        """A helpful step; the goals themselves once none is missing, so that the end is seen."""
        if self.steps is None:
            found = steps_for(domain, facts, self.goals, self.budget)
            self.planner_calls += 1
            if isinstance(found, Ended):
                return found
            self.steps = found
        missing = self._missing(self.steps, facts)
        if not missing:
            lost = Ended(Outcome.BUDGET, "what no step brings about is missing", stuck=True)
            return goal_tree(self.goals) if satisfied(self.goals, facts) else lost
        for at in sorted(missing):
            for action in self._ways(domain, self.steps.actions[at], missing[at]):
                if applicable(action, facts):
                    self.chosen = True
                    return _alone(action)
        return Ended(Outcome.BUDGET, "no step that is left can be done", stuck=True)

    @staticmethod
    def _missing(steps: Steps, facts: Facts) -> dict[int, tuple[Condition, ...]]:
        """The steps that still help, each with what it would bring about: for the goals, or for a step that helps."""
        found: dict[int, tuple[Condition, ...]] = {}
        for at in reversed(range(len(steps.actions))):
            helps = (c for c, j in steps.links[at] if (j is None or j in found) and not holds(c, facts))
            needed = tuple(dict.fromkeys(helps))
            if needed:
                found[at] = needed
        return found

    @staticmethod
    def _ways(domain: Domain, step: GroundAction, needed: tuple[Condition, ...]) -> Iterator[GroundAction]:
        """The step as it is in the list, then the same from elsewhere."""
        yield step
        for action in domain.achievers(needed[0]):
            if from_elsewhere(domain, action, step) and all(map(action.achieves, needed)):
                yield action

    def ended(self, _action: GroundAction, _success: bool) -> None:
        """Look again."""
        self.chosen = False
