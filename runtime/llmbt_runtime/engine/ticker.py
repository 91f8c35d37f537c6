"""What `llmbt execute` ticks its reactive trees with: which action is wanted, at the cost of what changed.

The executor knows itself how the running action stands, so that the tick is a function of tree and facts, and the
values of the branches tell all of it.
"""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_ir.condition import Facts
from llmbt_ir.tree import Tree
from llmbt_runtime.engine.facts import change_between
from llmbt_runtime.engine.program import program_of_tree
from llmbt_runtime.engine.values import NEEDS, STATUS, Values
from llmbt_runtime.tick import NodeStatus

__all__ = ["Ticker", "Wanted"]


@dataclass(frozen=True, slots=True)
class Wanted:
    """The root's status, and the id of the action node that wants to run, or None."""

    status: NodeStatus
    action: str | None


class Ticker:
    """Ticks one tree after another in one state after another; says what `llmbt_runtime.tick.tick` says."""

    def __init__(self) -> None:
        self._tree: Tree | None = None
        self._facts: Facts = frozenset()

    def tick(self, tree: Tree, facts: Facts) -> Wanted:
        """Tick a tree of ours once. Costs the difference to the facts before; a new tree costs its nodes."""
        if tree is not self._tree:
            self._tree, self._facts = tree, frozenset()
            self._values = Values(program_of_tree(tree))
        self._values.learn(change_between(self._facts, facts))
        self._facts = facts
        wanted = self._values.wanted()
        if wanted is None:
            value = self._values.value[0]
            assert value != NEEDS
            return Wanted(STATUS[value], None)
        return Wanted(NodeStatus.RUNNING, self._values.program.nodes[wanted].id)
