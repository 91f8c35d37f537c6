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


def climb(problem: Problem, landmarks: Landmarks, budget: Budget, *, patience: int = 200) -> _Path | None:
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
    """The way to a state with fewer landmarks left, or to the goal: helpful actions first, then any.

    Where there is none, a state is taken that has brought about a landmark at the cost of others.
    """
    goal = problem.goal
    remaining = landmarks.remaining(accepted)
    now = landmarks.count(accepted, start)
    heap: list[tuple[bool, int, int, int, int, Record, _Path]] = [(False, now, 0, 0, start, accepted, ())]
    seen = {start}
    expanded: set[int] = set()
    serial = 0
    second: tuple[tuple[int, int], _Path, int, Record] | None = None
    for _ in range(patience):
        while heap and heap[0][4] in expanded:
            heappop(heap)
        if not heap or (second is not None and heap[0][0]):
            break
        if not budget.take():
            return None
        _, _, _, _, state, record, path = heappop(heap)
        depth = len(path)
        expanded.add(state)
        best: tuple[int, _Path, int, Record] | None = None
        children: list[tuple[int, int, int, Record]] = []
        for a in problem.applicable(state):
            child = problem.after(state, a)
            if child in seen:
                continue
            reached = landmarks.accept(record, child)
            if child & goal == goal:
                return (*path, a), child, reached
            left = landmarks.count(reached, child)
            if left < now and (best is None or left < best[0]):
                best = left, (*path, a), child, reached
            if landmarks.remaining(reached) < remaining and (second is None or (left, depth) < second[0]):
                second = (left, depth), (*path, a), child, reached
            children.append((a, left, child, reached))
        if best is not None:
            return best[1:]
        relaxed = relaxed_plan(problem, state, landmarks.next(record, state), nearest=True)
        helpful, far = (relaxed.first, relaxed.nearest) if relaxed is not None else ((), 1 << 30)
        for a, left, child, reached in children:
            if a in helpful:
                seen.add(child)
            serial += 1
            heappush(heap, (a not in helpful, left, far, serial, child, reached, (*path, a)))
    return None if second is None else second[1:]
