"""One tick of a reactive tree: a pure function of the tree, the facts and what the running action reports.

ReactiveSequence and ReactiveFallback keep no memory (BehaviorTree.CPP 4): every tick starts from the first child.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from llmbt_ir.condition import Facts, holds
from llmbt_ir.tree import Kind, Tree

__all__ = ["NodeStatus", "TickRecord", "tick"]


class NodeStatus(StrEnum):
    """What a ticked node returns."""

    SUCCESS = "SUCCESS"
    FAILURE = "FAILURE"
    RUNNING = "RUNNING"


@dataclass(frozen=True, slots=True)
class TickRecord:
    """The root's status, the action node that wants to run (or None), and every ticked node in the order in which
    it returned."""

    status: NodeStatus
    action: str | None
    trace: tuple[tuple[str, NodeStatus], ...]

    def failed_leaves(self) -> tuple[str, ...]:
        """The ids that returned FAILURE, last first."""
        return tuple(id_ for id_, status in reversed(self.trace) if status is NodeStatus.FAILURE)


def tick(
    tree: Tree, facts: Facts, reports: Mapping[str, NodeStatus] | None = None, *, ending: Facts = frozenset()
) -> TickRecord:
    """Tick a tree once.

    Of the facts in `ending` nothing is known: neither they nor their negations hold.

    `reports` holds what an action node returns; an action that is reached and has no report is one to be started, and
    returns RUNNING. At most one action returns RUNNING, since both composites stop at the first child that does.
    """
    reports = reports or {}
    trace: list[tuple[str, NodeStatus]] = []
    running: str | None = None
    stack: list[tuple[str, int]] = [(tree.root, 0)]
    returned: NodeStatus | None = None
    while stack:
        id_, at = stack.pop()
        node = tree.nodes[id_]
        if node.condition is not None:
            known = node.condition.fact not in ending
            returned = NodeStatus.SUCCESS if known and holds(node.condition, facts) else NodeStatus.FAILURE
        elif node.action is not None:
            returned = reports.get(id_, NodeStatus.RUNNING)
            if returned is NodeStatus.RUNNING:
                running = id_
        else:
            go_on = NodeStatus.SUCCESS if node.kind is Kind.SEQUENCE else NodeStatus.FAILURE
            if at == 0:
                returned = go_on
            if at < len(node.children) and returned is go_on:
                stack.append((id_, at + 1))
                stack.append((node.children[at], 0))
                continue
        assert returned is not None
        trace.append((id_, returned))
    assert returned is not None
    return TickRecord(returned, running, tuple(trace))
