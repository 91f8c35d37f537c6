"""Proofs that goals cannot be reached: the smallest set of them that was found, and why, in plain words."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.search.best_first import Budget, Verdict, best_first
from llmbt_runtime.search.explain import exclusive, never_complete, together, unreachable
from llmbt_runtime.search.mutex import Mutexes, mutexes_of
from llmbt_runtime.search.problem import Problem, Unreachable, problem_of
from llmbt_runtime.search.result import Unsolvable
from llmbt_runtime.search.task import Task

__all__ = ["quick_proof", "smallest", "unreachable_goal"]

ALONE = 1_000
"""Expansions spent on whether one of two goals that exclude each other could be reached alone, and on why one goal
cannot be."""


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
            return Unsolvable((a, b), f"{a} and {b} exclude each other: {exclusive(mutexes, p >> 1, q >> 1)}")
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
        if isinstance(alone, Unreachable):
            return replace(unreachable_goal(problem.task, facts, goal, excluded), expansions=purse.spent)
        trial = Budget(min(purse.left, ALONE))
        verdict = best_first(alone, trial)
        purse.pay(trial.spent)
        if verdict is Verdict.NONE:
            return smallest(alone, (goal,), purse, facts, excluded)
    return replace(proof, expansions=purse.spent)


def unreachable_goal(task: Task, facts: Facts, goal: Condition, excluded: frozenset[ActionCall]) -> Unsolvable:
    """The proof that needs no search: with all deletes ignored the goal cannot be reached."""
    return Unsolvable((goal,), unreachable(task, facts, goal, excluded))


def smallest(
    problem: Problem, goals: tuple[Condition, ...], purse: Budget, facts: Facts, excluded: frozenset[ActionCall]
) -> Unsolvable:
    """A smallest set among goals that were shown not to be reachable together, and what stands in the way.

    Exactly, where all states can be looked at, else by leaving out one after the other as long as the budget lasts.
    """
    open_goals = tuple(g for g, _ in problem.goals) or goals
    trial = Budget(purse.left if len(open_goals) > 1 else min(purse.left, ALONE))
    states = _states(problem, trial)
    purse.pay(trial.spent)
    if states is not None:
        named = _hitting(open_goals, _achieved(problem, states))
    elif len(open_goals) > 1:
        named = _filtered(problem.task, facts, open_goals, excluded, purse)
    else:
        named = open_goals
    return Unsolvable(named, _in_words(problem, mutexes_of(problem.task, facts), named, states), purse.spent)


def _in_words(problem: Problem, mutexes: Mutexes, goals: tuple[Condition, ...], states: set[int] | None) -> str:
    """Why goals cannot be reached together."""
    bit = dict(problem.goals)
    if len(goals) == 1:
        why = never_complete(problem, bit[goals[0]], states) if states is not None and goals[0] in bit else ""
        return f"{goals[0]} cannot be reached from here" + (f": {why}" if why else "")
    names = f"{', '.join(map(str, goals[:-1]))} and {goals[-1]}"
    why = together(problem, mutexes, *goals) if len(goals) == 2 and set(goals) <= set(bit) else ""
    if not why and states is not None:
        why = f"each can be had, and none of the {len(states)} states that can be reached has them all"
    return f"{names} cannot be had together from here" + (f": {why}" if why else "")


def _states(problem: Problem, purse: Budget) -> set[int] | None:
    """All states that can be reached; None where the budget does not last."""
    seen = {problem.init}
    layer = [problem.init]
    while layer:
        following: list[int] = []
        for state in layer:
            if not purse.take():
                return None
            for a in problem.applicable(state):
                new = problem.after(state, a)
                if new not in seen:
                    seen.add(new)
                    following.append(new)
        layer = following
    return seen


def _achieved(problem: Problem, states: set[int]) -> set[int]:
    """Which sets of goals hold in some state, as masks over `problem.goals`."""
    masks = [1 << bit for _, bit in problem.goals]
    return {sum(1 << i for i, m in enumerate(masks) if state & m) for state in states}


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
