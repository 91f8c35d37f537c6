"""What an update of a tree comes to."""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_ir.tree import Tree
from llmbt_runtime.update.rollout import Certificate
from llmbt_runtime.update.step import Step

__all__ = ["Grown", "Kept"]


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
