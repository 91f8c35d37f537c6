"""The search behind its interface: a plan, a proof that there is none, or a spent budget."""

from __future__ import annotations

from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.search.best_first import Budget, Verdict, best_first
from llmbt_runtime.search.climb import climb
from llmbt_runtime.search.grounding import task_of
from llmbt_runtime.search.landmarks import landmarks_of
from llmbt_runtime.search.mutex import mutexes_of
from llmbt_runtime.search.problem import Unreachable, problem_of
from llmbt_runtime.search.proof import quick_proof, smallest, unreachable_goal
from llmbt_runtime.search.result import OutOfBudget, Plan, Result
from llmbt_runtime.search.shorten import shortened

__all__ = ["DEFAULT_BUDGET", "search"]

DEFAULT_BUDGET = 100_000


def search(
    domain: Domain,
    facts: Facts,
    goals: tuple[Condition, ...],
    *,
    budget: int = DEFAULT_BUDGET,
    excluded: frozenset[ActionCall] = frozenset(),
) -> Result:
    """Find actions after which all goals hold, or prove that there are none.

    Deterministic: the same call gives the same answer in every process. The budget counts expanded states.
    """
    task = task_of(domain, facts)
    goals = tuple(dict.fromkeys(goals))
    purse = Budget(budget)
    problem = problem_of(task, facts, goals, excluded)
    if isinstance(problem, Unreachable):
        return unreachable_goal(task, facts, problem.goal, excluded)
    mutexes = mutexes_of(task, facts)
    proof = quick_proof(problem, mutexes, purse, facts, excluded)
    if proof is not None:
        return proof
    landmarks = landmarks_of(problem, mutexes)
    found = climb(problem, landmarks, purse)
    if found is None:
        result = best_first(problem, purse, landmarks)
        if isinstance(result, Verdict):
            if result is Verdict.SPENT:
                return OutOfBudget(purse.spent)
            return smallest(problem, goals, purse, facts, excluded)
        found = result
    short = shortened(problem, found)
    return Plan(tuple(task.ground(problem.ops[a]) for a in short), purse.spent)
