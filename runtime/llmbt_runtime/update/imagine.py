"""Imagination: a tree grown by the local rule in the symbolic world, until it is certified."""

from __future__ import annotations

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Facts, Goals
from llmbt_ir.tree import Tree
from llmbt_runtime.search import HTable, h_add
from llmbt_runtime.search.grounding import task_of
from llmbt_runtime.update.grown import Grown
from llmbt_runtime.update.local import Move, drop_excluded, helpful_goal, repair
from llmbt_runtime.update.rollout import Certificate, StuckKind, rollout
from llmbt_runtime.update.step import Step

__all__ = ["imagine"]

GROWTH_LIMIT = 2_000
"""Edits of one imagination: far above what any scene needs, so that it ends whatever the templates say."""
PATIENCE = 3
"""So many re-expansions one after the other may lead to no action: imaginations that succeed need two at most."""


def imagine(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: Goals,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    plan: tuple[GroundAction, ...] = (),
    within: str | None = None,
    re_expand: bool = True,
) -> Grown | None:
    """Grow a tree by the local rule in the symbolic world, until it is certified from `facts`; None where the rule
    ends short of that.

    `within` is the branch of the alternative that is to be reached; with a `plan` only its actions are used.
    `re_expand` as in `repair`.
    """
    task = task_of(domain, facts)
    if plan:
        task = task.among({a.call for a in plan})
    tables: dict[Facts, HTable] = {}
    state, moved, idle = facts, frozenset[Move](), 0
    steps: list[Step] = []
    while len(steps) < GROWTH_LIMIT and idle <= PATIENCE:
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
            steps.append(step)
            state = outcome.facts
            continue
        if outcome.kind is not StuckKind.FAILED:
            return None
        state = outcome.facts
        costs = tables.get(state)
        if costs is None:
            costs = tables[state] = h_add(domain, state, excluded=excluded, task=task)
        mended = None if plan else helpful_goal(tree, outcome, costs, within or tree.root, moved)
        if mended is None:
            mended = repair(tree, outcome, domain, costs, moved=moved, within=within, re_expand=re_expand)
            if mended is None:
                return None
            if mended.step.kind == "move":
                state = facts  # another branch acts first now, so what came before it is imagined anew
        tree, moved = mended.tree, mended.moved | moved
        steps.append(mended.step)
        idle = idle + 1 if mended.step.kind == "re-expand" and not outcome.actions else 0
    return None
