"""The complete part: lazy greedy best-first search with preferred actions.

Helmert, "The Fast Downward planning system", JAIR 26 (2006), section 5.3: a state is judged when it is taken from the
queue, not when it is made; a second queue holds only what a relaxed plan would do, and is asked more often while it
helps. Every state that is not a proven dead end is expanded in the end, so an empty queue is a proof.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from heapq import heappop, heappush

from llmbt_runtime.search.landmarks import Landmarks, Record
from llmbt_runtime.search.problem import Problem
from llmbt_runtime.search.relaxed import relaxed_plan

__all__ = ["Budget", "Verdict", "best_first"]

_BOOST = 1000


class Verdict(Enum):
    """How a search without a plan ended."""

    NONE = "every state that can be reached was looked at"
    SPENT = "the budget is spent"


@dataclass(slots=True)
class Budget:
    """Expansions that may still be spent."""

    left: int
    spent: int = 0

    def take(self) -> bool:
        """Spend one, if there is one."""
        if self.left <= 0:
            return False
        self.pay(1)
        return True

    def pay(self, expansions: int) -> None:
        """Spend several."""
        self.left -= expansions
        self.spent += expansions


def best_first(problem: Problem, budget: Budget, landmarks: Landmarks | None = None) -> tuple[int, ...] | Verdict:
    """A plan, or why there is none. With landmarks their count is a second judge, with queues of its own."""
    init, goal, goal_ids = problem.init, problem.goal, problem.goal_ids
    parent: dict[int, tuple[int, int]] = {init: (-1, -1)}
    records: dict[int, Record] = {init: landmarks.first} if landmarks is not None else {}
    judges = 1 if landmarks is None else 2
    # of each judge a queue of all successors and one of the preferred
    queues: list[list[tuple[int, int, int, int]]] = [[] for _ in range(2 * judges)]
    queues[0].append((0, 0, -1, init))
    credit = [0] * len(queues)
    best = [1 << 60] * judges
    serial = 0
    while any(queues):
        which = min((q for q in range(len(queues)) if queues[q]), key=lambda q: (credit[q], -q))
        credit[which] += 1
        _, _, op, state = heappop(queues[which])
        if op >= 0:
            before, state = state, problem.after(state, op)
            if state in parent:
                continue
            parent[state] = (before, op)
        if state & goal == goal:
            return _path(parent, state)
        if not budget.take():
            return Verdict.SPENT
        relaxed = relaxed_plan(problem, state, goal_ids)
        if relaxed is None:
            continue
        marks = [relaxed.cost]
        if landmarks is not None:
            if op >= 0:
                records[state] = landmarks.accept(records[before], state)
            marks.append(landmarks.count(records[state], state))
        for j, mark in enumerate(marks):
            if mark < best[j]:
                best[j] = mark
                for q in range(judges):
                    credit[2 * q + 1] -= _BOOST
        preferred = set(relaxed.first)
        for a in problem.applicable(state):
            serial += 1
            for j, mark in enumerate(marks):
                heappush(queues[2 * j], (mark, serial, a, state))
                if a in preferred:
                    heappush(queues[2 * j + 1], (mark, serial, a, state))
    return Verdict.NONE


def _path(parent: dict[int, tuple[int, int]], state: int) -> tuple[int, ...]:
    ops: list[int] = []
    while True:
        state, op = parent[state]
        if op < 0:
            return tuple(reversed(ops))
        ops.append(op)
