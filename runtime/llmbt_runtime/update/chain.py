"""A plan as a reactive tree: the goal regressed through the plan (triangle tables, Fikes, Hart and Nilsson 1972;
teleo-reactive programs, Nilsson 1994)."""

from __future__ import annotations

from llmbt_atl.state import GroundAction
from llmbt_ir.condition import Condition
from llmbt_ir.tree import Kind, Node, Tree, node_id

__all__ = ["chain_tree", "regress"]


def regress(goals: tuple[Condition, ...], plan: tuple[GroundAction, ...]) -> tuple[tuple[Condition, ...], ...]:
    """The rows of a chain: R_n = G, R_(i-1) = (R_i - add(a_i)) + pre(a_i); rows[i] is what must hold before a_(i+1).

    Holds afterwards: from any state with rows[i], actions i+1 to n reach the goals.
    """
    rows = [tuple(dict.fromkeys(goals))]
    for action in reversed(plan):
        kept = [c for c in rows[0] if not action.achieves(c)]
        rows.insert(0, tuple(dict.fromkeys((*action.pre, *kept))))
    return tuple(rows)


def chain_tree(goals: tuple[Condition, ...], plan: tuple[GroundAction, ...], first: int = 1) -> Tree:
    """Fallback(Sequence(G), Sequence(R_(n-1), a_n), ..., Sequence(R_0, a_1)): the row nearest the goal acts.

    The goals are `g<first>` and on: the ids that they have in the initial tree."""
    rows = regress(goals, plan)
    goal_leaves = [Node(f"g{i}", Kind.CONDITION, condition=c) for i, c in enumerate(rows[-1], first)]
    top = Node("root", Kind.SEQUENCE, tuple(n.id for n in goal_leaves))
    nodes = [top, *goal_leaves]
    branches = [top.id]
    for i in range(len(plan) - 1, -1, -1):
        chain = ("chain", *(str(a) for a in plan[i:]))
        leaves = [Node(node_id("root", *chain, str(c)), Kind.CONDITION, condition=c) for c in rows[i]]
        act = Node(node_id("root", *chain, "!"), Kind.ACTION, action=plan[i].call)
        row = Node(node_id("root", *chain), Kind.SEQUENCE, (*(n.id for n in leaves), act.id))
        nodes += [row, *leaves, act]
        branches.append(row.id)
    root = Node(node_id("root", "chain", *(str(a) for a in plan), "?"), Kind.FALLBACK, tuple(branches))
    return Tree(root.id, {n.id: n for n in (root, *nodes)})
