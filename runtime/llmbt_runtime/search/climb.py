"""The quick part: from landmark to landmark, by small searches.

Enforced hill climbing (Hoffmann and Nebel, JAIR 14, 2001) on the landmark count, with the relaxed plan to the nearest
landmark that may come next for helpful actions (Richter and Westphal, JAIR 39, 2010). It is not complete; what it does
not solve is left to `best_first`.
"""

from __future__ import annotations

from heapq import heappop, heappush

from llmbt_runtime.search.best_first import Budget
from llmbt_runtime.search.landmarks import Landmarks, Record
from llmbt_runtime.search.problem import Problem
from llmbt_runtime.search.relaxed import relaxed_plan

__all__ = ["climb"]

_Path = tuple[int, ...]


def climb(problem: Problem, landmarks: Landmarks, budget: Budget, *, patience: int = 100) -> _Path | None:
    """A plan, or None where a small search of at most `patience` expansions finds no state with fewer landmarks."""
    state, accepted = problem.init, landmarks.first
    plan: list[int] = []
    while state & problem.goal != problem.goal:
        step = _step(problem, landmarks, budget, state, accepted, patience)
        if step is None:
            return None
        path, state, accepted = step
        plan += path
    return tuple(plan)


def _step(
    problem: Problem,
    landmarks: Landmarks,
    budget: Budget,
    start: int,
    accepted: Record,
    patience: int,
) -> tuple[_Path, int, Record] | None:
    """The way to a state with fewer landmarks left, or to the goal."""
    goal = problem.goal
    remaining = landmarks.remaining(accepted)
    now = landmarks.count(accepted, start)
    heap: list[tuple[int, int, int, int, Record, _Path]] = [(now, 0, 0, start, accepted, ())]
    seen = {start}
    serial = 0
    second: tuple[tuple[int, int], _Path, int, Record] | None = None
    for _ in range(patience):
        if not heap:
            break
        if not budget.take():
            return None
        _, depth, _, state, accepted, path = heappop(heap)
        best: tuple[int, _Path, int, Record] | None = None
        children: dict[int, tuple[int, int, Record]] = {}
        for a in problem.applicable(state):
            child = problem.after(state, a)
            if child in seen:
                continue
            reached = landmarks.accept(accepted, child)
            left = landmarks.count(reached, child)
            if child & goal == goal:
                return (*path, a), child, reached
            if left < now and (best is None or left < best[0]):
                best = left, (*path, a), child, reached
            if landmarks.remaining(reached) < remaining and (second is None or (left, depth) < second[0]):
                second = (left, depth), (*path, a), child, reached
            children[a] = left, child, reached
        if best is not None:
            return best[1:]
        relaxed = relaxed_plan(problem, state, landmarks.next(accepted, state), nearest=True)
        if relaxed is None:
            continue
        for a in relaxed.first:
            if a in children:
                left, child, reached = children[a]
                if child in seen:
                    continue
                seen.add(child)
                serial += 1
                heappush(heap, (left, depth + 1, serial, child, reached, (*path, a)))
    return None if second is None else second[1:]
