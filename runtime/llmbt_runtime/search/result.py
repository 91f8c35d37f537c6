"""What a search comes to."""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_atl.state import GroundAction
from llmbt_ir.condition import Condition

__all__ = ["OutOfBudget", "Plan", "Result", "Unsolvable"]


@dataclass(frozen=True, slots=True)
class Plan:
    """Actions that lead from the state to the goals."""

    actions: tuple[GroundAction, ...]
    expansions: int = 0


@dataclass(frozen=True, slots=True)
class Unsolvable:
    """A proof, from this state and by these templates: `goals` cannot hold together (or the one cannot be reached).

    It is the smallest set of goals that was found: the search has shown for it, too, that there is no plan.
    """

    goals: tuple[Condition, ...]
    reason: str
    expansions: int = 0


@dataclass(frozen=True, slots=True)
class OutOfBudget:
    """Neither a plan nor a proof within the budget."""

    expansions: int


Result = Plan | Unsolvable | OutOfBudget
