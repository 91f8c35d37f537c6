"""The search behind its interface: a plan, a proof that there is none, or a spent budget."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.search.best_first import Budget, Verdict, best_first
from llmbt_runtime.search.climb import climb
from llmbt_runtime.search.landmarks import landmarks_of
from llmbt_runtime.search.mutex import Mutexes, mutexes_of
from llmbt_runtime.search.problem import Problem, Unreachable, problem_of
from llmbt_runtime.search.shorten import shortened
from llmbt_runtime.search.task import Task, task_of

__all__ = ["OutOfBudget", "Plan", "Result", "Unsolvable", "search"]

DEFAULT_BUDGET = 100_000
ALONE = 1_000
"""Expansions spent on whether one of two goals that exclude each other could be reached alone."""


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
        return Unsolvable((problem.goal,), f"no action leads to {problem.goal} from here")
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
            return smallest(problem, Unsolvable(goals, _all_seen(purse.spent)), purse, facts, excluded)
        found = result
    short = shortened(problem, found)
    return Plan(tuple(task.ground(problem.ops[a]) for a in short), purse.spent)


def _all_seen(n: int) -> str:
    return f"none of the {n} states that can be reached has them all" if n > 1 else "no action leads further"


def quick_proof(
    problem: Problem, mutexes: Mutexes, purse: Budget, facts: Facts, excluded: frozenset[ActionCall]
) -> Unsolvable | None:
    """The proof from two goals that exclude each other, where there are such; the smaller one where one of them cannot
    be reached even alone."""
    proof = _excluding(problem, mutexes, facts)
    return None if proof is None else _either(problem, proof, purse, facts, excluded)


def _excluding(problem: Problem, mutexes: Mutexes, facts: Facts) -> Unsolvable | None:
    """Two goals that contradict or exclude each other."""
    literals = problem.literals
    for (a, i), (b, j) in combinations(problem.goals, 2):
        p, q = literals[i], literals[j]
        if p == q ^ 1:
            return Unsolvable((a, b), f"{a} and {b} contradict each other")
        if not p & 1 and not q & 1 and mutexes.exclusive(p >> 1, q >> 1):
            return Unsolvable((a, b), f"{a} and {b} exclude each other")
        for positive, negative in ((a, b), (b, a)):
            if _implied(problem, mutexes, facts, positive, negative):
                return Unsolvable((a, b), f"{positive} is never without {negative.fact}")
    return None


def _implied(problem: Problem, mutexes: Mutexes, facts: Facts, positive: Condition, negative: Condition) -> bool:
    """Whether a fact is never without another, about a place that contains its own: the first state has both or
    neither, actions add both, and only a change of the state variable ends the other one."""
    task = problem.task
    domain = task.domain
    if positive.negated or not negative.negated or positive.name != negative.name:
        return False
    if negative.fact not in domain.upward(positive):
        return False
    number = task.number[positive]
    return (
        len(mutexes.keys(number)) == len(task.keys[number])
        and not any(d.name == positive.name for t in domain.library.templates.values() for d in t.deletes)
        and all(u in facts for f in facts if f.name == positive.name for u in domain.upward(f))
    )


def _either(
    problem: Problem, proof: Unsolvable, purse: Budget, facts: Facts, excluded: frozenset[ActionCall]
) -> Unsolvable:
    """The proof that two goals exclude each other, or that one of them cannot be reached even alone."""
    for goal in proof.goals:
        alone = problem_of(problem.task, facts, (goal,), excluded)
        trial = Budget(min(purse.left, ALONE))
        verdict = Verdict.NONE if isinstance(alone, Unreachable) else best_first(alone, trial)
        purse.pay(trial.spent)
        if verdict is Verdict.NONE:
            return Unsolvable((goal,), f"{goal} cannot be reached from here", purse.spent)
    return replace(proof, expansions=purse.spent)


def smallest(
    problem: Problem, proof: Unsolvable, purse: Budget, facts: Facts, excluded: frozenset[ActionCall]
) -> Unsolvable:
    """A smallest unsolvable set among the goals: exactly, where all states can be looked at, else by leaving out one
    after the other as long as the budget lasts."""
    goals = tuple(g for g, _ in problem.goals)
    if len(goals) > 1:
        achieved = _achieved(problem, purse)
        if achieved is not None:
            goals = _hitting(goals, achieved)
        else:
            goals = _filtered(problem.task, facts, goals, excluded, purse)
    return replace(proof, goals=goals, expansions=purse.spent)


def _achieved(problem: Problem, purse: Budget) -> set[int] | None:
    """Which sets of goals hold in some state that can be reached, as masks over `problem.goals`; None where the
    budget does not last."""
    masks = [1 << bit for _, bit in problem.goals]
    seen = {problem.init}
    layer = [problem.init]
    found: set[int] = set()
    while layer:
        following: list[int] = []
        for state in layer:
            if not purse.take():
                return None
            found.add(sum(1 << i for i, m in enumerate(masks) if state & m))
            for a in problem.applicable(state):
                new = problem.after(state, a)
                if new not in seen:
                    seen.add(new)
                    following.append(new)
        layer = following
    return found


def _hitting(goals: tuple[Condition, ...], achieved: set[int]) -> tuple[Condition, ...]:
    """The smallest set of goals that no achieved set contains, the first in order; by leaving out where many."""
    n = len(goals)

    def possible(wanted: int) -> bool:
        return any(wanted & have == wanted for have in achieved)

    if n <= 12:
        for size in range(1, n + 1):
            for chosen in combinations(range(n), size):
                if not possible(sum(1 << i for i in chosen)):
                    return tuple(goals[i] for i in chosen)
    wanted = (1 << n) - 1
    for i in range(n):
        if not possible(wanted & ~(1 << i)):
            wanted &= ~(1 << i)
    return tuple(g for i, g in enumerate(goals) if wanted >> i & 1)


def _filtered(
    task: Task, facts: Facts, goals: tuple[Condition, ...], excluded: frozenset[ActionCall], purse: Budget
) -> tuple[Condition, ...]:
    kept = list(goals)
    for goal in goals:
        rest = [g for g in kept if g != goal]
        if len(rest) == len(kept) or not rest:
            continue
        problem = problem_of(task, facts, rest, excluded)
        if isinstance(problem, Unreachable):
            return (problem.goal,)
        if best_first(problem, purse) is Verdict.NONE:
            kept = rest
    return tuple(kept)
