"""What literals cost at least about: the additive heuristic over a compiled task.

h_add: Bonet and Geffner, "Planning as heuristic search", Artificial Intelligence 129 (2001). `inf` is a proof:
a literal that cannot be reached with all deletes ignored cannot be reached at all.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.search.grounding import task_of
from llmbt_runtime.search.task import Task

__all__ = ["HTable", "Ranked", "h_add", "relaxed_costs"]


class Ranked(NamedTuple):
    """An achiever, in the order of preference: the cost of its preconditions, how many facts it ends, its rank."""

    cost: float
    ends: int
    rank: int
    template: str
    args: tuple[str, ...]
    op: int

    @property
    def call(self) -> ActionCall:
        """Its name and arguments."""
        return ActionCall(self.template, self.args)


@dataclass(frozen=True, slots=True, eq=False)
class HTable:
    """The cost of every literal from one state: 0 where it holds, `inf` where it cannot be reached."""

    task: Task
    facts: Facts
    _costs: list[float]
    _excluded: frozenset[int]
    _best: dict[int, int] = field(default_factory=dict, repr=False)

    def __getitem__(self, literal: Condition) -> float:
        if literal.negated:
            return self._negative(~literal)
        if literal in self.facts:
            return 0
        i = self.task.number.get(literal)
        return inf if i is None else self._costs[2 * i]

    def _negative(self, fact: Condition) -> float:
        if fact not in self.facts:
            return 0
        i = self.task.number.get(fact)
        if i is None:
            return inf
        if i in self.task.negative:
            return self._costs[2 * i + 1]
        ops = self.task.ops
        return min(
            (
                1 + sum(self._costs[p] for p in ops[a].pre)
                for a in self.task.deleters.get(i, ())
                if a not in self._excluded
            ),
            default=inf,
        )

    def achievers(self, literal: Condition) -> list[Ranked]:
        """What can bring a literal about, best first. Only what can be reached and is not excluded."""
        i = self.task.number.get(literal.fact)
        if i is None:
            return []
        ops, costs, p = self.task.ops, self._costs, 2 * i + literal.negated
        adders = self.task.deleters if literal.negated else self.task.adders
        found = []
        for a in adders.get(i, ()):
            op = ops[a]
            cost = sum([costs[q] for q in op.pre])
            if cost != inf and p not in op.pre and a not in self._excluded:
                found.append(Ranked(cost, len(op.deletes), op.rank, op.template, op.args, a))
        found.sort()
        return found

    def relaxed_plan(self, literal: Condition) -> frozenset[int]:
        """The actions, by number, that bring a literal about with all deletes ignored: of each literal the achiever of
        the cheapest preconditions, the first of several."""
        i = self.task.number.get(literal.fact)
        found: set[int] = set()
        open_ = [] if i is None else [2 * i + literal.negated]
        while open_:
            p = open_.pop()
            if p not in self._best:
                self._best[p] = self._best_achiever(p)
            best = self._best[p]
            if best >= 0 and best not in found:
                found.add(best)
                open_ += self.task.ops[best].pre
        return frozenset(found)

    def _best_achiever(self, p: int) -> int:
        """-1 where the literal holds or cannot be reached."""
        ops, costs = self.task.ops, self._costs
        adders = (self.task.deleters if p & 1 else self.task.adders).get(p >> 1, ())
        cost, best = min(
            ((sum([costs[q] for q in ops[a].pre]), a) for a in adders if a not in self._excluded), default=(inf, -1)
        )
        return best if cost != inf and self[self._literal(p)] else -1

    def _literal(self, p: int) -> Condition:
        fact = self.task.facts[p >> 1]
        return ~fact if p & 1 else fact

    def action(self, ranked: Ranked) -> GroundAction:
        """The ground action of an achiever."""
        return self.task.ground(ranked.op)

    def total(self, literals: Iterable[Condition]) -> float:
        """The sum over several literals: h_add of a goal or of a precondition."""
        return sum((self[c] for c in literals), start=0.0)


def h_add(
    domain: Domain, facts: Facts, *, excluded: frozenset[ActionCall] = frozenset(), task: Task | None = None
) -> HTable:
    """The additive heuristic of every literal from a state, without the `excluded` actions; over a part of the
    domain's actions where their `task` is given."""
    task = task or task_of(domain, facts)
    banned = task.excluded_ops(excluded) if excluded else frozenset()
    return HTable(task, facts, relaxed_costs(task, initial_literals(task, facts), banned), banned)


def initial_literals(task: Task, facts: Facts, negative: frozenset[int] | None = None) -> list[int]:
    """The literal numbers that hold in a state; negated ones for the facts in `negative`."""
    numbers = task.fact_numbers(facts)
    held = set(numbers)
    wanted = task.negative if negative is None else negative
    return [2 * f for f in numbers] + [2 * f + 1 for f in sorted(wanted) if f not in held]


def relaxed_costs(
    task: Task,
    state: list[int],
    banned: frozenset[int],
    effects: Sequence[tuple[int, ...]] | None = None,
) -> list[float]:
    """h_add by literal number, in order of cost (Dijkstra over whole numbers: a list of lists is the queue)."""
    cost: list[float] = [inf] * (2 * len(task.facts))
    for p in state:
        cost[p] = 0
    queue: list[list[int]] = [state, []]
    waiting = list(task.pre_counts)
    so_far = [1] * len(waiting)
    needed_by = task.needed_by
    effects = task.effects if effects is None else effects
    for a in banned:
        waiting[a] = -1
    for q in sorted({q for a in task.always if a not in banned for q in effects[a] if cost[q] > 1}):
        cost[q] = 1
        queue[1].append(q)
    for d, bucket in enumerate(queue):
        for p in bucket:
            if cost[p] != d:
                continue
            for a in needed_by[p]:
                waiting[a] -= 1
                so_far[a] += d
                if waiting[a]:
                    continue
                c = so_far[a]
                for q in effects[a]:
                    if c < cost[q]:
                        cost[q] = c
                        while len(queue) <= c:
                            queue.append([])
                        queue[c].append(q)
    return cost
