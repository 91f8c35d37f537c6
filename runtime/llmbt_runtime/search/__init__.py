"""The complete search: plans and proofs over the ground templates of one scene."""

from llmbt_runtime.search.core import search
from llmbt_runtime.search.grounding import task_of
from llmbt_runtime.search.heuristic import HTable, Ranked, h_add
from llmbt_runtime.search.planner import PLANNERS, Planner, planner_named
from llmbt_runtime.search.result import OutOfBudget, Plan, Result, Unsolvable

__all__ = [
    "PLANNERS",
    "HTable",
    "OutOfBudget",
    "Plan",
    "Planner",
    "Ranked",
    "Result",
    "Unsolvable",
    "h_add",
    "planner_named",
    "search",
    "task_of",
]
