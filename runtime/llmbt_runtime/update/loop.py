"""The update loop: imagine and certify; otherwise plan, and certify that. Nothing here touches a world."""

from __future__ import annotations

from dataclasses import dataclass, replace

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Facts, Goals
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.search import OutOfBudget, Plan, Unsolvable, h_add, search
from llmbt_runtime.update.chain import chain_tree
from llmbt_runtime.update.edit import remove_achiever
from llmbt_runtime.update.local import Step, drop_excluded, repair
from llmbt_runtime.update.rollout import Certificate, StuckKind, rollout

__all__ = ["Grown", "Kept", "imagine", "prune", "update"]

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
    goals: Goals,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    budget: int = 200_000,
    re_expand: bool = True,
) -> Kept | Grown | Unsolvable | OutOfBudget:
    """The tree to run from an observed state.

    Kept where the tree as it is reaches the goals; otherwise, for the alternatives of the goals from the cheapest on,
    the first of these that is certified: the tree grown by the local rule; grown with the actions of a plan; the goals
    alone so grown; the plan as a chain. Unsolvable is a proof from this state by these templates without the excluded
    actions, for every alternative; OutOfBudget counts state expansions. `re_expand` as in `update.local.repair`.
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
        found = search(domain, facts, goals[k], budget=max(0, budget - spent), excluded=excluded)
        spent += found.expansions
        if isinstance(found, Plan):
            return _planned(tree, domain, facts, goals, k, found.actions, excluded, calls, spent, prelude, re_expand)
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
    calls: int,
    spent: int,
    prelude: tuple[Step, ...],
    re_expand: bool,
) -> Grown:
    """The most readable certified tree that a plan leads to."""
    prefer = frozenset(a.call for a in plan)

    anew = (_note("goals", plan, "grown anew from the goals, in the order in which a plan reaches them"),)
    starts = ((tree, prelude), (_by_plan(goals, k, plan), anew))
    for start, steps in starts if tree.has_actions() else starts[1:]:
        within = _branch(start, goals, k)
        guided = imagine(
            start, domain, facts, goals, excluded=excluded, prefer=prefer, within=within, re_expand=re_expand
        )
        if guided is not None and len(guided.certificate.actions) <= len(plan):
            return Grown(guided.tree, guided.certificate, steps + guided.steps, calls, spent)
    chain = chain_tree(goals[k], plan, 1 + sum(len(set(g)) for g in goals[:k]))
    certificate = rollout(chain, domain, facts, goals, excluded=excluded)
    if not isinstance(certificate, Certificate):
        raise AssertionError(f"a regressed plan does not certify: {certificate.kind}")  # noqa: TRY004 - our own bug
    note = _note("chain", plan, "the local rule finds no tree that certifies: the goal regressed through a plan")
    return Grown(chain, certificate, (note,), calls, spent)


def imagine(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: Goals,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    prefer: frozenset[ActionCall] = frozenset(),
    within: str | None = None,
    re_expand: bool = True,
) -> Grown | None:
    """Grow a tree by the local rule in the symbolic world, until it is certified from `facts`; None where the rule
    ends short of that. `within` is the branch of the alternative that is to be reached."""
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
            dropped = drop_excluded(tree, outcome)
            if dropped is None:
                return None
            tree, step = dropped
        elif outcome.kind is StuckKind.FAILED:
            costs = h_add(domain, outcome.facts, excluded=excluded)
            mended = repair(
                tree,
                outcome,
                domain,
                costs,
                excluded=excluded,
                moved=moved,
                prefer=prefer,
                within=within,
                re_expand=re_expand,
            )
            if mended is None:
                return None
            tree, step, moved = mended.tree, mended.step, mended.moved | moved
        else:
            return None
        steps.append(step)
        # after a move another branch acts first, so what came before it is imagined anew
        state = facts if step.kind == "move" else outcome.facts
    return None


def prune(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: Goals,
    certificate: Certificate,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
) -> Grown | None:
    """The tree without the achievers that its certificate does not run, certified; None where nothing can go.

    What is taken out grows again when it is needed.
    """
    used = set(certificate.nodes)
    steps: list[Step] = []
    smaller = tree
    for node in tuple(tree.preorder()):
        if node.action is None or node.id in used or node.id not in smaller.nodes:
            continue
        branch = smaller.parents.get(node.id)
        fallback = smaller.parents.get(branch) if branch is not None else None
        if branch is None or fallback is None or smaller.head(fallback) is None:
            continue
        inside = {n.id for n in smaller.preorder(branch)}
        if inside & used:
            continue
        head = str(smaller.head(fallback))
        smaller = remove_achiever(smaller, branch)
        steps.append(Step("prune", branch, head, str(node.action), reason="the certificate does not run it"))
    if not steps:
        return None
    found = rollout(smaller, domain, facts, goals, excluded=excluded)
    return Grown(smaller, found, tuple(steps)) if isinstance(found, Certificate) else None


def _with_branches(tree: Tree, goals: Goals) -> tuple[Tree, tuple[Step, ...]]:
    """A tree with a branch for each alternative; an initial tree that states them in another shape is rewritten."""
    if len(goals) == 1 or all(f"alt{k}" in tree.nodes for k in range(1, len(goals) + 1)):
        return tree, ()
    return goal_tree(goals), (Step("goals", "root", "", reason="written as alternatives, each a conjunction"),)


def _branch(tree: Tree, goals: Goals, k: int) -> str | None:
    name = f"alt{k + 1}"
    return name if len(goals) > 1 and name in tree.nodes else None


def _by_plan(goals: Goals, k: int, plan: tuple[GroundAction, ...]) -> Tree:
    """The initial tree with an alternative's goals in the order in which the plan last brings them about.

    Each goal keeps its id."""
    tree = goal_tree(goals)
    top = tree[_branch(tree, goals, k) or tree.root]

    def last(id_: str) -> int:
        goal = tree[id_].condition
        return max((i for i, a in enumerate(plan) if goal is not None and a.achieves(goal)), default=-1)

    return tree.with_nodes(replace(top, children=tuple(sorted(top.children, key=last))))


def _note(kind: str, plan: tuple[GroundAction, ...], why: str) -> Step:
    return Step(kind, "root", "", " ".join(str(a) for a in plan), reason=why)
