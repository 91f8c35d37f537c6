"""The complete search alone: at the start and at each deviation a plan, acted out as a chain (triangle tables, Fikes,
Hart and Nilsson 1972); no tree is grown or kept."""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_atl.state import Domain, GroundAction, apply
from llmbt_ir.condition import Facts, Goals
from llmbt_ir.tree import Tree
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.search import OutOfBudget, Plan, Unsolvable, h_add, search
from llmbt_runtime.tick import TickRecord
from llmbt_runtime.update.chain import chain_tree

__all__ = ["ChainPolicy"]


@dataclass
class ChainPolicy:
    """Plans anew whenever what is seen is not what the plan predicts."""

    goals: Goals
    budget: int
    planner_calls: int = 0
    expansions: int = 0
    believed: Facts | None = None

    def objects(self, facts: Facts, running: GroundAction | None) -> bool:
        """Whether the state is another one than the plan leads through."""
        if self.believed is None:
            return True
        ends = running.deletes if running is not None else frozenset()
        return not (facts <= self.believed and self.believed - facts <= ends)

    def revise(self, _tree: Tree, domain: Domain, facts: Facts, _record: TickRecord) -> Tree | Ended:
        """A new chain for the cheapest alternative that has a plan."""
        costs = h_add(domain, facts)
        dead: list[Unsolvable] = []
        starved = False
        for k in sorted(range(len(self.goals)), key=lambda k: (costs.total(self.goals[k]), k)):
            found = search(domain, facts, self.goals[k], budget=max(0, self.budget - self.expansions))
            self.planner_calls += 1
            self.expansions += found.expansions
            if isinstance(found, Plan):
                self.believed = facts
                return chain_tree(self.goals[k], found.actions)
            if isinstance(found, Unsolvable):
                dead.append(found)
            starved = starved or isinstance(found, OutOfBudget)
        if starved:
            return Ended(Outcome.BUDGET, f"no plan within {self.budget} expansions")
        return Ended(Outcome.UNSOLVABLE, "; ".join(d.reason for d in dead), dead[0].goals)

    def ended(self, action: GroundAction, success: bool) -> None:
        """A success leads to the predicted state, anything else to a new plan."""
        self.believed = apply(action, self.believed) if success and self.believed is not None else None
