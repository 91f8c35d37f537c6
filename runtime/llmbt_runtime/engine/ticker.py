"""What `llmbt execute` ticks its reactive trees with: which action is wanted, at the cost of what changed.

The executor knows itself how the running action stands, so that the tick is a function of tree and facts, and the
values of the branches tell all of it.
"""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_ir.tree import Tree
from llmbt_runtime.engine.program import program_of_tree
from llmbt_runtime.engine.values import NEEDS, STATUS, Values
from llmbt_runtime.facts import Change, FactBase
from llmbt_runtime.tick import NodeStatus

__all__ = ["Ticker", "Wanted"]


@dataclass(frozen=True, slots=True)
class Wanted:
    """The root's status, and the id of the action node that wants to run, or None."""

    status: NodeStatus
    action: str | None


class Ticker:
    """Ticks one tree after another over facts that are written to; says what `llmbt_runtime.tick.tick` says."""

    def __init__(self) -> None:
        self._tree: Tree | None = None
        self._facts: FactBase | None = None

    def tick(self, tree: Tree, facts: FactBase) -> Wanted:
        """Tick a tree of ours once. Costs what changed since the tick before; a new tree costs its nodes."""
        change = facts.take()
        if tree is not self._tree or facts is not self._facts:
            self._tree, self._facts = tree, facts
            self._values = Values(program_of_tree(tree))
            change = Change(facts.facts)
        self._values.learn(change)
        wanted = self._values.wanted()
        if wanted is None:
            value = self._values.value[0]
            assert value != NEEDS
            return Wanted(STATUS[value], None)
        return Wanted(NodeStatus.RUNNING, self._values.program.nodes[wanted].id)
