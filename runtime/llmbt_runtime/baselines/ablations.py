"""Our own loop with a part taken out: the plan's chain alone, no re-expansion, no certificate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Facts, Goals
from llmbt_ir.tree import Tree
from llmbt_runtime.baselines.local_rule import LocalPolicy
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.search import OutOfBudget, Plan, Planner, Unsolvable, h_add, search
from llmbt_runtime.tick import TickRecord
from llmbt_runtime.update.chain import chain_tree
from llmbt_runtime.update.loop import Grown, Kept, update
from llmbt_runtime.update.rollout import Certificate, rollout
from llmbt_runtime.update.step import Step

__all__ = ["UncertifiedPolicy", "chain_only", "without_re_expansion"]

without_re_expansion = partial(update, re_expand=False)
"""The whole loop, but a condition is never given a further achiever: where it fails anew, a plan has to help."""


def chain_only(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: Goals,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    budget: int = 200_000,
    planner: Planner | None = None,
) -> Kept | Grown | Unsolvable | OutOfBudget:
    """The loop without the local rule: a tree that does not certify becomes the chain of a new plan."""
    domain = domain.for_state(facts)
    kept = rollout(tree, domain, facts, goals, excluded=excluded)
    if isinstance(kept, Certificate):
        return Kept(kept)
    costs = h_add(domain, facts, excluded=excluded)
    dead: list[Unsolvable] = []
    starved, spent = False, 0
    for calls, k in enumerate(sorted(range(len(goals)), key=lambda k: (costs.total(goals[k]), k)), 1):
        found = (planner or search)(domain, facts, goals[k], budget=max(0, budget - spent), excluded=excluded)
        spent += found.expansions
        if isinstance(found, Plan):
            chain = chain_tree(goals[k], found.actions, 1 + sum(len(set(g)) for g in goals[:k]))
            certificate = rollout(chain, domain, facts, goals, excluded=excluded)
            assert isinstance(certificate, Certificate)
            return Grown(chain, certificate, (Step("chain", "root", "", reason="a new plan"),), calls, spent)
        if isinstance(found, Unsolvable):
            dead.append(found)
        else:
            starved = True
    return OutOfBudget(spent) if starved else Unsolvable(dead[0].goals, dead[0].reason, spent)


@dataclass
class UncertifiedPolicy(LocalPolicy):
    """The local rule, and where it knows no edit the chain of a plan; acted on as it grows, nothing is shown first."""

    budget: int = 100_000

    def revise(self, tree: Tree, domain: Domain, facts: Facts, record: TickRecord) -> Tree | Ended:
        """One edit by the local rule, or a chain."""
        found = super().revise(tree, domain, facts, record)
        if isinstance(found, Tree):
            return found
        ended: Ended | None = None
        for goals in self.goals:
            planned = search(domain, facts, goals, budget=max(0, self.budget - self.expansions))
            self.planner_calls += 1
            self.expansions += planned.expansions
            if isinstance(planned, Plan):
                return chain_tree(goals, planned.actions)
            if isinstance(planned, OutOfBudget):
                ended = Ended(Outcome.BUDGET, f"no plan within {self.budget} expansions")
            else:
                ended = ended or Ended(Outcome.UNSOLVABLE, planned.reason, planned.goals)
        assert ended is not None
        return ended
