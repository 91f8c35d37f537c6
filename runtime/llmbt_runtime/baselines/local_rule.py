"""Our local rule without a certificate or a plan: the tree acts as it grows, and is changed only where it fails."""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import Facts, Goals
from llmbt_ir.tree import Tree
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.search import h_add
from llmbt_runtime.tick import TickRecord
from llmbt_runtime.update.local import Move, repair
from llmbt_runtime.update.rollout import Stuck, StuckKind

__all__ = ["LocalPolicy"]


@dataclass
class LocalPolicy:
    """The rule of `update.local`, online; of several alternatives the cheapest that it can mend."""

    goals: Goals
    planner_calls: int = 0
    expansions: int = 0
    moved: frozenset[Move] = frozenset()

    def objects(self, _facts: Facts, _running: GroundAction | None) -> bool:
        """A tree is changed only where it fails."""
        return False

    def revise(self, tree: Tree, domain: Domain, facts: Facts, record: TickRecord) -> Tree | Ended:
        """One edit by the local rule."""
        costs = h_add(domain, facts)
        stuck = Stuck(StuckKind.FAILED, facts, record, ())
        for k in sorted(range(len(self.goals)), key=lambda k: (costs.total(self.goals[k]), k)):
            within = f"alt{k + 1}" if len(self.goals) > 1 else None
            mended = repair(tree, stuck, domain, costs, moved=self.moved, within=within)
            if mended is not None:
                self.moved |= mended.moved
                return mended.tree
        return Ended(Outcome.BUDGET, "the local rule knows no edit", stuck=True)

    def ended(self, _action: GroundAction, _success: bool) -> None:
        """Nothing is remembered."""
