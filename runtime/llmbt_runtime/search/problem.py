"""One search problem over bits: a state is a whole number, an action three masks.

Only what matters is kept: actions that can be reached with deletes ignored, that a goal needs, and that add
something; literals that some kept action or a goal needs and that do not hold for ever. None of it changes whether
there is a plan: a dropped action or literal never stands between a state and the goal.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from math import inf

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.search.heuristic import initial_literals, relaxed_costs
from llmbt_runtime.search.task import Task

__all__ = ["Problem", "Unreachable", "bits", "problem_of"]


@dataclass(frozen=True, slots=True)
class Unreachable:
    """A goal that no sequence of actions brings about, even with all deletes ignored."""

    goal: Condition


@dataclass(frozen=True, eq=False)
class Problem:
    """A problem whose literals are bits `0..n-1`. `ops` are the task's action numbers, in order of preference."""

    task: Task
    literals: tuple[int, ...] = field(repr=False)
    ops: tuple[int, ...] = field(repr=False)
    pre: tuple[int, ...] = field(repr=False)
    add: tuple[int, ...] = field(repr=False)
    keep: tuple[int, ...] = field(repr=False)
    pre_ids: tuple[tuple[int, ...], ...] = field(repr=False)
    add_ids: tuple[tuple[int, ...], ...] = field(repr=False)
    init: int
    goal: int
    goals: tuple[tuple[Condition, int], ...]

    @property
    def n(self) -> int:
        """The number of literals."""
        return len(self.literals)

    @cached_property
    def goal_ids(self) -> tuple[int, ...]:
        """The goals' bits."""
        return tuple(bits(self.goal))

    @cached_property
    def needed_by(self) -> tuple[tuple[int, ...], ...]:
        """For each literal the actions that need it."""
        table: list[list[int]] = [[] for _ in self.literals]
        for a, pre in enumerate(self.pre_ids):
            for p in pre:
                table[p].append(a)
        return tuple(map(tuple, table))

    @cached_property
    def added_by(self) -> tuple[tuple[int, ...], ...]:
        """For each literal the actions that add it."""
        table: list[list[int]] = [[] for _ in self.literals]
        for a, add in enumerate(self.add_ids):
            for p in add:
                table[p].append(a)
        return tuple(map(tuple, table))

    @cached_property
    def pre_counts(self) -> tuple[int, ...]:
        """For each action the number of its preconditions."""
        return tuple(map(len, self.pre_ids))

    @cached_property
    def always(self) -> tuple[int, ...]:
        """The actions without preconditions."""
        return tuple(a for a, pre in enumerate(self.pre_ids) if not pre)

    @cached_property
    def _watched(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """For each literal the actions whose rarest precondition it is, each with its mask."""
        table: list[list[tuple[int, int]]] = [[] for _ in self.literals]
        weight = [len(ops) for ops in self.needed_by]
        for a, pre in enumerate(self.pre_ids):
            if pre:
                rarest = min(pre, key=lambda p: (weight[p], -p))
                table[rarest].append((a, self.pre[a]))
        return tuple(map(tuple, table))

    @cached_property
    def _watch_mask(self) -> int:
        return sum(1 << p for p, ops in enumerate(self._watched) if ops)

    def applicable(self, state: int) -> list[int]:
        """The actions that can be done in a state, in order of preference."""
        found = list(self.always)
        watched = self._watched
        rest = state & self._watch_mask
        while rest:
            low = rest & -rest
            rest ^= low
            for a, pre in watched[low.bit_length() - 1]:
                if state & pre == pre:
                    found.append(a)
        found.sort()
        return found

    def after(self, state: int, op: int) -> int:
        """The state after an action."""
        return state & self.keep[op] | self.add[op]


def bits(mask: int) -> Iterator[int]:
    """The places of the ones, lowest first."""
    while mask:
        low = mask & -mask
        yield low.bit_length() - 1
        mask ^= low


def problem_of(
    task: Task, facts: Facts, goals: Iterable[Condition], excluded: frozenset[ActionCall] = frozenset()
) -> Problem | Unreachable:
    """The problem of reaching all goals from a state, or the first goal that cannot be reached at all."""
    wanted: list[tuple[Condition, int]] = []
    for goal in dict.fromkeys(goals):
        number = task.number.get(goal.fact)
        if number is not None:
            wanted.append((goal, 2 * number + goal.negated))
        elif (goal.fact in facts) == goal.negated:
            return Unreachable(goal)
    negative = task.negative | {g >> 1 for _, g in wanted if g & 1}
    effects = task.effects if negative == task.negative else task.effects_for(negative)
    state = initial_literals(task, facts, negative)
    cost = relaxed_costs(task, list(state), task.excluded_ops(excluded) if excluded else frozenset(), effects)
    for goal, g in wanted:
        if cost[g] == inf:
            return Unreachable(goal)
    return _reduced(task, wanted, negative, effects, state, cost, excluded)


def _reduced(
    task: Task,
    wanted: list[tuple[Condition, int]],
    negative: frozenset[int],
    effects: tuple[tuple[int, ...], ...],
    state: list[int],
    cost: list[float],
    excluded: frozenset[ActionCall],
) -> Problem:
    banned = task.excluded_ops(excluded) if excluded else frozenset()
    reached = [a for a, op in enumerate(task.ops) if a not in banned and all(cost[p] != inf for p in op.pre)]
    # what a goal needs, backwards
    adders: dict[int, list[int]] = {}
    for a in reached:
        for q in effects[a]:
            adders.setdefault(q, []).append(a)
    relevant = {g for _, g in wanted}
    stack = sorted(relevant)
    kept: set[int] = set()
    while stack:
        for a in adders.get(stack.pop(), ()):
            if a not in kept:
                kept.add(a)
                for p in task.ops[a].pre:
                    if p not in relevant:
                        relevant.add(p)
                        stack.append(p)
    # what holds for ever
    ended: set[int] = set()
    for a in kept:
        op = task.ops[a]
        ended.update(2 * f for f in op.deletes)
        if negative:
            ended.update(2 * f + 1 for f in op.adds if f in negative)
    held = set(state)
    literals = tuple(sorted(p for p in relevant if p not in held or p in ended))
    bit = {p: i for i, p in enumerate(literals)}
    ops, pre_m, add_m, keep_m, pre_ids, add_ids = [], [], [], [], [], []
    seen: set[tuple[int, int, int]] = set()
    all_ones = (1 << len(literals)) - 1
    for a in sorted(kept, key=lambda a: (task.ops[a].rank, a)):
        op = task.ops[a]
        pre = tuple(sorted(bit[p] for p in op.pre if p in bit))
        need = sum(1 << p for p in pre)
        gains = tuple(sorted(bit[q] for q in effects[a] if q in bit))
        gain = sum(1 << q for q in gains)
        loss = sum(1 << bit[2 * f] for f in op.deletes if 2 * f in bit)
        if negative:
            loss += sum(1 << bit[2 * f + 1] for f in op.adds if 2 * f + 1 in bit)
        if gain & ~need == 0 or (need, gain, loss) in seen:
            continue
        seen.add((need, gain, loss))
        ops.append(a)
        pre_m.append(need)
        add_m.append(gain)
        keep_m.append(all_ones & ~loss)
        pre_ids.append(pre)
        add_ids.append(gains)
    return Problem(
        task,
        literals,
        tuple(ops),
        tuple(pre_m),
        tuple(add_m),
        tuple(keep_m),
        tuple(pre_ids),
        tuple(add_ids),
        sum(1 << bit[p] for p in held if p in bit),
        sum(1 << bit[g] for _, g in wanted if g in bit),
        tuple((goal, bit[g]) for goal, g in wanted if g in bit),
    )
