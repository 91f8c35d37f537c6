"""The update loop: imagine and certify; otherwise plan, and certify that. Nothing here touches a world."""

from __future__ import annotations

from dataclasses import replace

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Facts, Goals
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.search import OutOfBudget, Plan, Planner, Unsolvable, h_add, search
from llmbt_runtime.update.chain import chain_tree
from llmbt_runtime.update.grown import Grown, Kept
from llmbt_runtime.update.imagine import imagine
from llmbt_runtime.update.links import linked_tree
from llmbt_runtime.update.rollout import Certificate, rollout
from llmbt_runtime.update.step import Step

__all__ = ["Grown", "Kept", "update"]

LARGER = 2.0
"""The installed tree is given up where mending it would take so many times the nodes of one made anew."""


def update(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: Goals,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    budget: int = 200_000,
    planner: Planner | None = None,
    re_expand: bool = True,
) -> Kept | Grown | Unsolvable | OutOfBudget:
    """The tree to run from an observed state.

    Kept where the tree as it is reaches the goals; otherwise, for the alternatives of the goals from the cheapest on,
    the first of these that is certified: the tree grown by the local rule; grown so with the actions of a plan alone;
    the plan as a tree along its causal links; the plan as a chain. Unsolvable is a proof from this state by these
    templates without the excluded actions, for every alternative; OutOfBudget counts state expansions. `re_expand` as
    in `update.local.repair`.
    """
    domain = domain.for_state(facts)
    kept = rollout(tree, domain, facts, goals, excluded=excluded)
    if isinstance(kept, Certificate):
        return Kept(kept)
    tree, prelude = _with_branches(tree, goals)
    costs = h_add(domain, facts, excluded=excluded)
    order = sorted(range(len(goals)), key=lambda k: (costs.total(goals[k]), k))
    for k in order:
        within = _branch(tree, goals, k)
        grown = imagine(tree, domain, facts, goals, excluded=excluded, within=within, re_expand=re_expand)
        if grown is not None:
            return Grown(grown.tree, grown.certificate, prelude + grown.steps)
    spent, dead, starved = 0, list[Unsolvable](), False
    for calls, k in enumerate(order, 1):
        found = (planner or search)(domain, facts, goals[k], budget=max(0, budget - spent), excluded=excluded)
        spent += found.expansions
        if isinstance(found, Plan):
            made = _planned(tree, domain, facts, goals, k, found.actions, excluded, re_expand)
            return replace(made, steps=prelude + made.steps, planner_calls=calls, expansions=spent)
        if isinstance(found, Unsolvable):
            dead.append(found)
        else:
            starved = True
    return OutOfBudget(spent) if starved else Unsolvable(dead[0].goals, _why(dead), spent)


def _why(dead: list[Unsolvable]) -> str:
    return dead[0].reason if len(dead) == 1 else "no alternative can be reached: " + "; ".join(d.reason for d in dead)


def _planned(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: Goals,
    k: int,
    plan: tuple[GroundAction, ...],
    excluded: frozenset[ActionCall],
    re_expand: bool,
) -> Grown:
    """The installed tree mended with the actions of a plan, or else a tree made of the plan, whichever certifies.

    Mended it stays, unless it then has more than `LARGER` times the nodes of the other.
    """
    anew = _anew(domain, facts, goals, k, plan, excluded)
    if tree.has_actions():
        within = _branch(tree, goals, k)
        mended = imagine(tree, domain, facts, goals, excluded=excluded, plan=plan, within=within, re_expand=re_expand)
        if (
            mended is not None
            and len(mended.certificate.actions) <= len(plan)
            and len(mended.tree) <= LARGER * len(anew.tree)
        ):
            return mended
    return anew


def _anew(
    domain: Domain, facts: Facts, goals: Goals, k: int, plan: tuple[GroundAction, ...], excluded: frozenset[ActionCall]
) -> Grown:
    """The plan as a tree along its causal links; as a chain where they do not nest."""
    linked = linked_tree(goals, k, plan, facts)
    if linked is not None:
        tree, steps = linked
        certificate = rollout(tree, domain, facts, goals, excluded=excluded)
        if isinstance(certificate, Certificate):
            note = _note("goals", plan, "grown anew from the goals, in the order in which a plan reaches them")
            return Grown(tree, certificate, (note, *steps))
    chain = chain_tree(goals[k], plan, 1 + sum(len(set(g)) for g in goals[:k]))
    certificate = rollout(chain, domain, facts, goals, excluded=excluded)
    if not isinstance(certificate, Certificate):
        raise AssertionError(f"a regressed plan does not certify: {certificate.kind}")  # noqa: TRY004 - our own bug
    note = _note("chain", plan, "the causal links of the plan do not nest: the goals regressed through it")
    return Grown(chain, certificate, (note,))


def _with_branches(tree: Tree, goals: Goals) -> tuple[Tree, tuple[Step, ...]]:
    """A tree with a branch for each alternative; an initial tree that states them in another shape is rewritten."""
    if len(goals) == 1 or all(f"alt{k}" in tree.nodes for k in range(1, len(goals) + 1)):
        return tree, ()
    return goal_tree(goals), (Step("goals", "root", "", reason="written as alternatives, each a conjunction"),)


def _branch(tree: Tree, goals: Goals, k: int) -> str | None:
    name = f"alt{k + 1}"
    return name if len(goals) > 1 and name in tree.nodes else None


def _note(kind: str, plan: tuple[GroundAction, ...], why: str) -> Step:
    return Step(kind, "root", "", " ".join(str(a) for a in plan), reason=why)
