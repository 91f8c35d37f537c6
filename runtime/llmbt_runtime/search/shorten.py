"""Shorter plans: what a plan can do without is taken out, and short stretches are replaced by shorter ones.

Action elimination: Nakhost and Müller, "Action elimination and plan neighborhood graph search", ICAPS 2010. Stretches:
Siddiqui and Haslum, "Continuing plan quality optimisation", JAIR 54 (2015), in a small form. The result reaches the
goals as the given plan does and is never longer.
"""

from __future__ import annotations

from llmbt_runtime.search.problem import Problem

__all__ = ["shortened"]

_Plan = tuple[int, ...]
EFFORT = 50
"""States that are looked at, for each action of the plan."""


def shortened(problem: Problem, plan: _Plan, *, effort: int = EFFORT) -> _Plan:
    """A plan as good or better; `effort` bounds the states that are looked at, for each action of the plan."""
    effort *= len(plan)
    plan = _without_detours(problem, plan)
    plan = _without_needless(problem, plan)
    plan = _with_shortcuts(problem, plan, effort, 16, own=True)
    return _with_shortcuts(problem, plan, effort, 5, own=False)


def _states(problem: Problem, plan: _Plan) -> list[int]:
    states = [problem.init]
    for a in plan:
        states.append(problem.after(states[-1], a))
    return states


def _without_detours(problem: Problem, plan: _Plan) -> _Plan:
    """Cut what leads back to a state that was there before, and what follows the goal."""
    states = _states(problem, plan)
    goal = problem.goal
    end = next(i for i, s in enumerate(states) if s & goal == goal)
    last = {s: i for i, s in enumerate(states[: end + 1])}
    kept: list[int] = []
    i = 0
    while (i := last[states[i]]) < end:
        kept.append(plan[i])
        i += 1
    return tuple(kept)


def _without_needless(problem: Problem, plan: _Plan) -> _Plan:
    """Leave out an action, and what can then no longer be done, where the goals are reached all the same."""
    goal = problem.goal
    pre = problem.pre
    state = problem.init
    i = 0
    while i < len(plan):
        here = state
        kept: list[int] = []
        for a in plan[i + 1 :]:
            need = pre[a]
            if here & need == need:
                here = problem.after(here, a)
                kept.append(a)
        if here & goal == goal:
            plan = (*plan[:i], *kept)
        else:
            state = problem.after(state, plan[i])
            i += 1
    return plan


def _needs(problem: Problem, plan: _Plan) -> list[int]:
    """What must hold before each action for the rest of the plan to work; at the end the goal."""
    need = problem.goal
    needs = [need]
    for a in reversed(plan):
        need = need & ~problem.add[a] | problem.pre[a]
        needs.append(need)
    needs.reverse()
    return needs


def _with_shortcuts(problem: Problem, plan: _Plan, effort: int, longest: int, *, own: bool) -> _Plan:
    """Replace stretches of up to `longest` actions, with the plan's `own` actions or with all."""
    left = [effort]
    length = 2
    while length <= min(longest, len(plan)) and left[0] > 0:
        improved = False
        i = 0
        states, needs = _states(problem, plan), _needs(problem, plan)
        ops = sorted(set(plan)) if own else None
        while i + length <= len(plan) and left[0] > 0:
            shorter = _way(problem, states[i], needs[i + length], length - 1, left, ops)
            if shorter is not None:
                plan = _without_needless(problem, (*plan[:i], *shorter, *plan[i + length :]))
                states, needs = _states(problem, plan), _needs(problem, plan)
                improved = True
            else:
                i += 1
        length = 2 if improved else length + 1
    return plan


def _way(problem: Problem, start: int, need: int, depth: int, left: list[int], ops: list[int] | None) -> _Plan | None:
    """At most `depth` actions to a state with all that is needed, breadth first."""
    if start & need == need:
        return ()
    pre = problem.pre
    seen = {start}
    layer: list[tuple[int, _Plan]] = [(start, ())]
    for step in range(depth):
        following: list[tuple[int, _Plan]] = []
        for state, path in layer:
            for a in problem.applicable(state) if ops is None else ops:
                if ops is not None and state & pre[a] != pre[a]:
                    continue
                new = problem.after(state, a)
                if new in seen:
                    continue
                if new & need == need:
                    return (*path, a)
                seen.add(new)
                left[0] -= 1
                if step + 1 < depth:
                    following.append((new, (*path, a)))
            if left[0] <= 0:
                return None
        layer = following
    return None
