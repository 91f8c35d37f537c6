"""Relaxed plans: with all deletes ignored, how many actions lead to the goals, and which of them to do first.

Hoffmann and Nebel, "The FF planning system", JAIR 14 (2001); cost-sensitive supporters as in Keyder and Geffner,
"Heuristics for planning with action costs revisited", ECAI 2008.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from llmbt_runtime.search.problem import Problem, bits

__all__ = ["RelaxedPlan", "relaxed_plan"]

_FAR = 1 << 40


@dataclass(frozen=True, slots=True)
class RelaxedPlan:
    """The number of actions of a relaxed plan, those of them that can be done now, and what the nearest goal costs."""

    cost: int
    first: tuple[int, ...]
    nearest: int


def relaxed_plan(problem: Problem, state: int, goals: Collection[int], *, nearest: bool = False) -> RelaxedPlan | None:
    """A relaxed plan to all the goals, or to each of the nearest of them; None where there is none: a dead end.

    Nearest are the ones that cost at most one action more than the cheapest.
    """
    cost = [_FAR] * problem.n
    by = [-1] * problem.n
    first = list(bits(state))
    for p in first:
        cost[p] = 0
    queue: list[list[int]] = [first, []]
    waiting = list(problem.pre_counts)
    so_far = [1] * len(waiting)
    needed_by, add_ids = problem.needed_by, problem.add_ids
    for a in problem.always:
        for q in add_ids[a]:
            if cost[q] > 1:
                cost[q] = 1
                by[q] = a
                queue[1].append(q)
    wanted = set(goals)
    missing = len(wanted)
    reached: list[int] = []
    last = _FAR
    for d, bucket in enumerate(queue):
        if d > last or not missing:
            break
        for p in bucket:
            if cost[p] != d:
                continue
            if p in wanted:
                missing -= 1
                reached.append(p)
                if nearest:
                    last = min(last, d + 1)
                elif not missing:
                    break
            for a in needed_by[p]:
                waiting[a] -= 1
                so_far[a] += d
                if waiting[a]:
                    continue
                c = so_far[a]
                for q in add_ids[a]:
                    if c < cost[q]:
                        cost[q] = c
                        by[q] = a
                        while len(queue) <= c:
                            queue.append([])
                        queue[c].append(q)
    if missing and not (nearest and reached):
        return None
    return _extract(problem, state, reached, by, cost[reached[0]] if reached else 0)


def _extract(problem: Problem, state: int, open_: list[int], by: list[int], nearest: int) -> RelaxedPlan:
    plan: set[int] = set()
    seen: set[int] = set()
    now: list[int] = []
    while open_:
        p = open_.pop()
        a = by[p]
        if p in seen or a < 0:
            continue
        seen.add(p)
        if a not in plan:
            plan.add(a)
            pre = problem.pre[a]
            if state & pre == pre:
                now.append(a)
            open_.extend(problem.pre_ids[a])
    return RelaxedPlan(len(plan), tuple(sorted(now)), nearest)
