"""Landmarks: literals that hold at some time in every plan, and in which order to bring them about.

All landmarks of the relaxation that ignores deletes, by propagating labels: Zhu and Givan, "Landmark extraction via
planning graph propagation", ICAPS 2003 doctoral consortium; Keyder, Richter and Helmert, ECAI 2010. Reasonable orders
and counting: Hoffmann, Porteous and Sebastia, "Ordered landmarks in planning", JAIR 22 (2004); Richter and Westphal,
"The LAMA planner", JAIR 39 (2010).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

from llmbt_runtime.search.mutex import Mutexes
from llmbt_runtime.search.problem import Problem, bits

__all__ = ["Landmarks", "Record", "landmarks_of"]

Record = tuple[int, int]
"""The landmarks accepted so far, and those that held at some time."""


@dataclass(frozen=True, eq=False)
class Landmarks:
    """`mask`: the landmarks. `before[l]`: what is to be accepted before l; `enable[l]`: what must hold just before l
    becomes true for the first time; `again[l]`: what must hold just before it becomes true at any time.

    A record of progress is a pair: the landmarks accepted, and those that held at some time.
    """

    problem: Problem
    mask: int
    before: dict[int, int] = field(repr=False)
    enable: dict[int, int] = field(repr=False)
    again: dict[int, int] = field(repr=False)

    @cached_property
    def first(self) -> Record:
        """What is accepted in the first state."""
        return self.accept((0, 0), self.problem.init)

    @cached_property
    def _stages(self) -> dict[Record, tuple[int, int]]:
        return {}

    def accept(self, record: Record, state: int) -> Record:
        """The record once a state is reached: what holds is accepted if its predecessors are."""
        accepted, held = record
        now = state & self.mask
        new = now & ~accepted
        before = self.before
        changed = True
        while new and changed:
            changed = False
            rest = new
            while rest:
                low = rest & -rest
                rest ^= low
                if not before[low.bit_length() - 1] & ~accepted:
                    accepted |= low
                    new ^= low
                    changed = True
        return accepted, held | now

    def _stage(self, record: Record) -> tuple[int, int]:
        """What is needed now, and how many landmarks are still to come, those accepted too early included.

        Too early is what so far enables only landmarks whose turn has not come: it has to be brought about again.
        """
        known = self._stages.get(record)
        if known is None:
            accepted, held = record
            wanted = self.problem.goal
            serves = waits = 0
            for u in bits(self.mask):
                need = (self.again if held >> u & 1 else self.enable)[u]
                if accepted >> u & 1:
                    serves |= need | self.enable[u]
                elif self.before[u] & ~need & ~accepted:
                    waits |= need
                else:
                    wanted |= need
            early = waits & ~serves & ~wanted & accepted & ~self.first[0]
            known = self._stages[record] = wanted, (self.mask & ~accepted | early).bit_count()
        return known

    def lost(self, record: Record, state: int) -> int:
        """Accepted landmarks that do not hold and are needed now: goals, and what enables the next ones."""
        gone = record[0] & ~state
        return gone and gone & self._stage(record)[0]

    def remaining(self, record: Record) -> int:
        """How many landmarks are still to come, whatever holds now."""
        return self._stage(record)[1]

    def count(self, record: Record, state: int) -> int:
        """How many landmarks have still to be brought about."""
        return self._stage(record)[1] + self.lost(record, state).bit_count()

    def next(self, record: Record, state: int) -> list[int]:
        """The landmarks that can be brought about now: all their predecessors are accepted."""
        accepted = record[0]
        before = self.before
        ready = [u for u in bits(self.mask & ~accepted) if not before[u] & ~accepted]
        return sorted([*ready, *bits(self.lost(record, state))])


def landmarks_of(problem: Problem, mutexes: Mutexes) -> Landmarks:
    """All landmarks of the delete relaxation, and the orders among them."""
    label = _labels(problem)
    mask = problem.goal
    for g in problem.goal_ids:
        mask |= label[g]
    members = list(bits(mask))
    exclusive = _Exclusive(problem, mutexes)
    again = {b: _common(problem, problem.added_by[b]) for b in members}
    enable = dict.fromkeys(members, (0, 0, 0))
    spoils = dict.fromkeys(members, 0)
    done = 0
    new = mask & ~problem.init
    while new:
        done |= new
        for b in bits(new):
            if problem.init >> b & 1:
                enable[b] = again[b]
            else:
                first = [a for a in problem.added_by[b] if not any(label[p] >> b & 1 for p in problem.pre_ids[a])]
                enable[b] = _common(problem, first)
            need, gain, against = enable[b]
            for c in bits(need | gain):
                against |= exclusive.mask(c)
            spoils[b] = against & mask & ~(label[b] & ~problem.init) & ~(1 << b)
        # goals that hold already, but not all the while: they have to be brought about again
        new = 0
        for b in members:
            new |= spoils[b]
        new &= problem.goal & problem.init & ~done
    before = {b: label[b] & mask & ~problem.init & ~(1 << b) for b in members}
    needs = {b: enable[b][0] & mask for b in members}
    return Landmarks(
        problem,
        mask,
        _ordered(problem, members, before, needs, spoils),
        needs,
        {b: again[b][0] & mask for b in members},
    )


def _common(problem: Problem, ops: Iterable[int]) -> tuple[int, int, int]:
    """What all actions of a choice need, add and delete."""
    need = gain = loss = -1
    for a in ops:
        need &= problem.pre[a]
        gain &= problem.add[a]
        loss &= ~problem.keep[a]
    ones = (1 << problem.n) - 1
    return (need & ones, gain & ones, loss & ones) if need != -1 else (0, 0, 0)


def _labels(problem: Problem) -> list[int]:
    """For each literal the mask of all literals that hold at some time before, or when, it first does."""
    label = [-1] * problem.n
    changed = list(bits(problem.init))
    for p in changed:
        label[p] = 1 << p
    waiting = list(problem.pre_counts)
    new = [True] * problem.n
    pre_ids, add_ids, needed_by = problem.pre_ids, problem.add_ids, problem.needed_by
    ready: dict[int, None] = dict.fromkeys(problem.always)
    while changed or ready:
        for p in changed:
            if new[p]:
                new[p] = False
                for a in needed_by[p]:
                    waiting[a] -= 1
                    if not waiting[a]:
                        ready[a] = None
            else:
                for a in needed_by[p]:
                    if not waiting[a]:
                        ready[a] = None
        touched: dict[int, None] = {}
        for a in ready:
            union = 0
            for p in pre_ids[a]:
                union |= label[p]
            for q in add_ids[a]:
                old = label[q]
                narrowed = old & (union | 1 << q)
                if narrowed != old:
                    label[q] = narrowed
                    touched[q] = None
        ready = {}
        changed = list(touched)
    return label


class _Exclusive:
    """Which literals exclude a literal, as masks."""

    def __init__(self, problem: Problem, mutexes: Mutexes) -> None:
        self.problem, self.mutexes = problem, mutexes
        self.bit = {p: i for i, p in enumerate(problem.literals)}
        self.known: dict[int, int] = {}

    def mask(self, i: int) -> int:
        """The literals that can never hold together with a literal."""
        found = self.known.get(i)
        if found is None:
            p = self.problem.literals[i]
            found = 0
            others = [p ^ 1]
            if not p & 1:
                others += [2 * o for o in self.mutexes.others(p >> 1)]
            for o in others:
                bit = self.bit.get(o)
                if bit is not None:
                    found |= 1 << bit
            self.known[i] = found
        return found


def _ordered(
    problem: Problem,
    members: list[int],
    before: dict[int, int],
    enable: dict[int, int],
    spoils: dict[int, int],
) -> dict[int, int]:
    """The necessary orders, and reasonable ones: what spoils a goal, or spoils what a later landmark is enabled by,
    comes first. Reasonable orders that would make a circle are left out."""
    reasonable: dict[int, int] = dict.fromkeys(members, 0)
    for a in members:
        for b in bits(spoils[a] & problem.goal):
            reasonable[b] |= 1 << a
    for c in members:
        for b in bits(enable[c]):
            if b not in reasonable or problem.init >> b & 1 or problem.goal >> b & 1:
                continue
            for a in bits(before[c] & ~before[b] & ~(1 << b)):
                if spoils[a] >> b & 1:
                    reasonable[b] |= 1 << a
    done = 0
    left = list(members)
    result: dict[int, int] = {}
    while left:
        free = [b for b in left if not (before[b] | reasonable[b]) & ~done]
        if not free:
            possible = [b for b in left if not before[b] & ~done] or left
            free = [min(possible, key=lambda b: ((reasonable[b] & ~done).bit_count(), b))]
            reasonable[free[0]] &= done
            before[free[0]] &= done
        for b in free:
            result[b] = before[b] | reasonable[b]
            done |= 1 << b
        left = [b for b in left if not done >> b & 1]
    return result
