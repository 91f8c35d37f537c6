"""The update loop: imagine and certify; otherwise plan, and certify that. Nothing here touches a world."""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.tree import Tree
from llmbt_runtime.search import OutOfBudget, Plan, Unsolvable, h_add, search
from llmbt_runtime.update.chain import chain_tree
from llmbt_runtime.update.edit import goal_tree
from llmbt_runtime.update.local import Step, drop_excluded, repair
from llmbt_runtime.update.rollout import Certificate, StuckKind, rollout

__all__ = ["Grown", "Kept", "update"]

GROWTH_LIMIT = 2_000
"""Edits of one imagination: far above what any scene needs, so that it ends whatever the templates say."""


@dataclass(frozen=True, slots=True)
class Kept:
    """The tree works as it is, from this state: a new certificate."""

    certificate: Certificate


@dataclass(frozen=True, slots=True)
class Grown:
    """A changed tree with its certificate, the edits that made it, and what the search cost."""

    tree: Tree
    certificate: Certificate
    steps: tuple[Step, ...]
    planner_calls: int = 0
    expansions: int = 0


def update(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: tuple[Condition, ...],
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    budget: int = 200_000,
) -> Kept | Grown | Unsolvable | OutOfBudget:
    """The tree to run from an observed state.

    Kept where the tree as it is reaches the goals; otherwise the first of these that is certified: the tree grown by
    the local rule; grown with the actions of a plan; the goals alone so grown; the plan as a chain. Unsolvable is a
    proof from this state by these templates without the excluded actions; OutOfBudget counts state expansions.
    """
    kept = rollout(tree, domain, facts, goals, excluded=excluded)
    if isinstance(kept, Certificate):
        return Kept(kept)
    grown = imagine(tree, domain, facts, goals, excluded=excluded)
    if grown is not None:
        return grown
    found = search(domain, facts, goals, budget=budget, excluded=excluded)
    if not isinstance(found, Plan):
        return found
    plan = found.actions
    prefer = frozenset(a.call for a in plan)
    ordered = goal_tree(_by_plan(goals, plan))
    for start, steps in ((tree, ()), (ordered, (_planned("goals", plan, "grown anew from the goals"),))):
        guided = imagine(start, domain, facts, goals, excluded=excluded, prefer=prefer)
        if guided is not None and len(guided.certificate.actions) <= len(plan):
            return Grown(guided.tree, guided.certificate, steps + guided.steps, 1, found.expansions)
    chain = chain_tree(goals, plan)
    certificate = rollout(chain, domain, facts, goals, excluded=excluded)
    if not isinstance(certificate, Certificate):
        raise AssertionError(f"a regressed plan does not certify: {certificate.kind}")
    return Grown(
        chain, certificate, (_planned("chain", plan, "the local rule finds no tree that certifies"),), 1, found.expansions
    )


def imagine(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: tuple[Condition, ...],
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    prefer: frozenset[ActionCall] = frozenset(),
) -> Grown | None:
    """Grow a tree by the local rule in the symbolic world, until it is certified from `facts`; None where the rule
    ends short of that."""
    state, moved = facts, frozenset[tuple[str, str]]()
    steps: list[Step] = []
    while len(steps) < GROWTH_LIMIT:
        outcome = rollout(tree, domain, state, goals, excluded=excluded)
        if isinstance(outcome, Certificate):
            if state == facts:
                return Grown(tree, outcome, tuple(steps))
            state = facts
            continue
        if outcome.kind is StuckKind.EXCLUDED:
            tree, step = drop_excluded(tree, outcome)
        elif outcome.kind is StuckKind.FAILED:
            costs = h_add(domain, outcome.facts, excluded=excluded)
            mended = repair(tree, outcome, domain, costs, excluded=excluded, moved=moved, prefer=prefer)
            if mended is None:
                return None
            tree, step, moved = mended.tree, mended.step, mended.moved | moved
        else:
            return None
        steps.append(step)
        # after a move another branch acts first, so what came before it is imagined anew
        state = facts if step.kind == "move" else outcome.facts
    return None


def _by_plan(goals: tuple[Condition, ...], plan: tuple[GroundAction, ...]) -> tuple[Condition, ...]:
    """The goals in the order in which the plan last brings them about."""

    def last(goal: Condition) -> int:
        return max((i for i, a in enumerate(plan) if a.achieves(goal)), default=-1)

    return tuple(sorted(goals, key=last))


def _planned(kind: str, plan: tuple[GroundAction, ...], why: str) -> Step:
    return Step(kind, "root", "", " ".join(str(a) for a in plan), reason=why)
