"""The complete search: plans and proofs over the ground templates of one scene."""

from llmbt_runtime.search.core import OutOfBudget, Plan, Result, Unsolvable, search
from llmbt_runtime.search.heuristic import HTable, Ranked, h_add

__all__ = ["HTable", "OutOfBudget", "Plan", "Ranked", "Result", "Unsolvable", "h_add", "search"]
