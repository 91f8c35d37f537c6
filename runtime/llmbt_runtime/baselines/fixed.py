"""A tree that was fully expanded beforehand and is never updated, as an expert writes one for a task.

It is the certified tree for the scene as it is at the start, and more: wherever it uses a skill on a thing, it has the
same skill for the same end from every other place of the scene, too. So a thing that fell or was moved is picked from
where it is; what the expert did not think of, an obstacle that the scene did not have, has no branch.
"""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import Facts, Goals
from llmbt_ir.tree import Tree
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.baselines.steps import from_elsewhere
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.search import OutOfBudget, Unsolvable
from llmbt_runtime.tick import TickRecord
from llmbt_runtime.update.edit import achievers_in, expand
from llmbt_runtime.update.loop import Kept, update

__all__ = ["FixedPolicy", "with_every_source"]


def with_every_source(tree: Tree, domain: Domain) -> Tree:
    """The tree with, for each condition that it expands, the same action from everywhere else, last."""
    for node in tuple(tree.preorder()):
        if node.condition is None:
            continue
        calls = [n.action for _, n in achievers_in(tree, node.id) if n.action is not None]
        there = [a for call in calls if (a := domain.action(call)) is not None]
        for action in domain.achievers(node.condition):
            if action not in there and any(from_elsewhere(domain, action, a) for a in there):
                tree = expand(tree, node.id, action)
    return tree


@dataclass
class FixedPolicy:
    """One tree for the whole run."""

    goals: Goals
    budget: int
    planner_calls: int = 0
    expansions: int = 0
    made: bool = False

    def objects(self, _facts: Facts, _running: GroundAction | None) -> bool:
        """It never does."""
        return False

    def revise(self, tree: Tree, domain: Domain, facts: Facts, _record: TickRecord) -> Tree | Ended:
        """The tree, the first time; nothing after that."""
        if self.made:
            return Ended(Outcome.BUDGET, "the tree fails, and it is fixed", stuck=True)
        self.made = True
        found = update(tree, domain, facts, self.goals, budget=self.budget)
        self.planner_calls += 1
        if isinstance(found, Unsolvable):
            return Ended(Outcome.UNSOLVABLE, found.reason, found.goals)
        if isinstance(found, OutOfBudget):
            return Ended(Outcome.BUDGET, f"no plan within {self.budget} expansions")
        return tree if isinstance(found, Kept) else with_every_source(found.tree, domain)

    def ended(self, _action: GroundAction, _success: bool) -> None:
        """Nothing is remembered."""
