"""Which search is asked: our own, Fast Downward, or the one after the other."""

from __future__ import annotations

from typing import Protocol

from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.search.core import search
from llmbt_runtime.search.result import OutOfBudget, Result

__all__ = ["PLANNERS", "Planner", "planner_named"]

PLANNERS = ("own", "fast-downward", "auto")
SHARE = 10
"""Of `auto`: our own search may spend this part of the budget before Fast Downward is asked."""


class Planner(Protocol):
    """A complete search: a plan, a proof that there is none, or neither within the budget of state expansions."""

    def __call__(
        self,
        domain: Domain,
        facts: Facts,
        goals: tuple[Condition, ...],
        *,
        budget: int,
        excluded: frozenset[ActionCall] = frozenset(),
    ) -> Result:
        """Search from a state."""


def planner_named(name: str) -> Planner:
    """One of PLANNERS (KeyError for another word). E075 where Fast Downward is named and not installed."""
    return {"own": _own, "fast-downward": _fast_downward, "auto": _auto}[name]()


def _own() -> Planner:
    return search


def _fast_downward() -> Planner:
    from llmbt_runtime.search.fast_downward import driver, search_fast_downward

    driver()
    return search_fast_downward


def _auto() -> Planner:
    from llmbt_runtime.search.fast_downward import available, search_fast_downward

    if not available():
        return search

    def both(
        domain: Domain,
        facts: Facts,
        goals: tuple[Condition, ...],
        *,
        budget: int,
        excluded: frozenset[ActionCall] = frozenset(),
    ) -> Result:
        found = search(domain, facts, goals, budget=budget // SHARE, excluded=excluded)
        if not isinstance(found, OutOfBudget):
            return found
        return search_fast_downward(domain, facts, goals, budget=budget - found.expansions, excluded=excluded)

    return both
