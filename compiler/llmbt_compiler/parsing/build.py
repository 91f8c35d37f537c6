"""The initial tree: the goals under one ReactiveSequence, in order."""

from __future__ import annotations

from collections.abc import Iterable

from llmbt_ir.condition import Condition
from llmbt_ir.tree import Kind, Node, Tree

from llmbt_compiler.parsing.model import Goal

__all__ = ["ROOT", "build_tree"]

ROOT = "root"


def build_tree(goals: Iterable[Goal | Condition]) -> Tree:
    """Goals to ``root -> g1, g2, ...``; a condition that comes twice is one node, where it came first.

    Raises ValueError where there is no goal: an empty Sequence would succeed at once.
    """
    conditions = dict.fromkeys(g.condition if isinstance(g, Goal) else g for g in goals)
    if not conditions:
        raise ValueError("a tree needs at least one goal")
    leaves = [Node(f"g{i}", Kind.CONDITION, condition=c) for i, c in enumerate(conditions, 1)]
    root = Node(ROOT, Kind.SEQUENCE, tuple(n.id for n in leaves))
    return Tree(ROOT, {n.id: n for n in (root, *leaves)})
