"""What an engine ticks: a flat table of immutable nodes in pre-order, with SubTrees and ports written out.

The nodes are those of BehaviorTree.CPP 4 and behave as there (docs/engine.md). Run state is kept by the engines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.tree import Kind, Tree

__all__ = ["FALLBACKS", "REACTIVE", "SEQUENCES", "Op", "Program", "ProgramNode", "program_of_tree"]


class Op(StrEnum):
    """What a node does; the value is its name in BehaviorTree.CPP (leaves of the robot go by their own names)."""

    CONDITION = "Condition"
    ACTION = "Action"
    ALWAYS_SUCCESS = "AlwaysSuccess"
    ALWAYS_FAILURE = "AlwaysFailure"
    SEQUENCE = "Sequence"
    FALLBACK = "Fallback"
    REACTIVE_SEQUENCE = "ReactiveSequence"
    REACTIVE_FALLBACK = "ReactiveFallback"
    INVERTER = "Inverter"
    FORCE_SUCCESS = "ForceSuccess"
    FORCE_FAILURE = "ForceFailure"
    RETRY = "RetryUntilSuccessful"
    REPEAT = "Repeat"
    TIMEOUT = "Timeout"
    DELAY = "Delay"


SEQUENCES = frozenset({Op.SEQUENCE, Op.REACTIVE_SEQUENCE})
FALLBACKS = frozenset({Op.FALLBACK, Op.REACTIVE_FALLBACK})
REACTIVE = frozenset({Op.REACTIVE_SEQUENCE, Op.REACTIVE_FALLBACK})


@dataclass(frozen=True, slots=True)
class ProgramNode:
    """One node. `amount` is what a decorator counts: attempts (Retry), cycles (Repeat; -1: without end, both),
    milliseconds (Timeout, Delay). `condition` and `action` are those of a leaf; `line` is 0 where no file tells."""

    op: Op
    id: str
    children: tuple[int, ...] = ()
    condition: Condition | None = None
    action: ActionCall | None = None
    amount: int = 0
    line: int = 0


@dataclass(frozen=True)
class Program:
    """A tree to be ticked: node 0 is the root, children are numbers of nodes and greater than their parent's.

    Every composite has a child, every decorator one.
    """

    nodes: tuple[ProgramNode, ...]

    def __len__(self) -> int:
        return len(self.nodes)

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """The parent of each node; -1 for the root."""
        found = [-1] * len(self.nodes)
        for i, node in enumerate(self.nodes):
            for child in node.children:
                found[child] = i
        return tuple(found)

    @cached_property
    def ranks(self) -> tuple[int, ...]:
        """Which child of its parent each node is, from 0."""
        found = [0] * len(self.nodes)
        for node in self.nodes:
            for rank, child in enumerate(node.children):
                found[child] = rank
        return tuple(found)

    @cached_property
    def readers(self) -> Mapping[Condition, tuple[int, ...]]:
        """The condition leaves that look at each fact (a positive literal)."""
        found: dict[Condition, list[int]] = {}
        for i, node in enumerate(self.nodes):
            if node.condition is not None:
                found.setdefault(node.condition.fact, []).append(i)
        return {fact: tuple(leaves) for fact, leaves in found.items()}


OPS = {Kind.SEQUENCE: Op.REACTIVE_SEQUENCE, Kind.FALLBACK: Op.REACTIVE_FALLBACK}


def program_of_tree(tree: Tree) -> Program:
    """One of our reactive trees, its ids kept. ValueError where a composite has no child."""
    order = tuple(tree.preorder())
    numbers = {node.id: i for i, node in enumerate(order)}
    if any(node.kind in OPS and not node.children for node in order):
        raise ValueError("a composite without a child")
    return Program(
        tuple(
            ProgramNode(
                OPS.get(node.kind) or Op(node.kind.value),
                node.id,
                tuple(numbers[c] for c in node.children),
                node.condition,
                node.action,
            )
            for node in order
        )
    )
