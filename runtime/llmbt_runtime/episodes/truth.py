"""What is true of a small problem, by looking at every state: the naive model that search and loop are held against.

States are whole numbers. Of `llmbt_atl` it uses the ground actions and their effects; of the search nothing.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Facts, Goals
from llmbt_runtime.symbolic import Event

__all__ = ["CAP", "label", "path", "reachable", "shortest"]

CAP = 6_000
"""States that are looked at; beyond it nothing is said."""


@dataclass(frozen=True, slots=True)
class _Op:
    need: int
    forbid: int
    hold: int
    hold_not: int
    lose: int
    gain: int
    suspend: int


class _Space:
    """Facts as bits, actions and events as masks."""

    def __init__(self, domain: Domain, facts: Facts, goals: Goals, events: Iterable[Event]) -> None:
        events = tuple(events)
        domain = domain.for_state(facts | frozenset(f for e in events for f in e.adds))
        self.number: dict[Condition, int] = {}
        self.ops = [
            _Op(
                self.mask(c for c in a.pre if not c.negated),
                self.mask(c.fact for c in a.pre if c.negated),
                self.mask(c for c in a.hold if not c.negated),
                self.mask(c.fact for c in a.hold if c.negated),
                self.mask(a.deletes),
                self.mask(a.adds),
                self.mask(c for c in a.start if not c.negated and c in a.deletes | a.adds),
            )
            for a in domain.actions
        ]
        self.events = [
            (
                self.mask(c for c in e.when if not c.negated),
                self.mask(c.fact for c in e.when if c.negated),
                self.mask(e.removes),
                self.mask(e.adds),
            )
            for e in events
        ]
        self.goals = [
            (self.mask(c for c in alt if not c.negated), self.mask(c.fact for c in alt if c.negated)) for alt in goals
        ]
        self.start = self.mask(facts)

    def mask(self, facts: Iterable[Condition]) -> int:
        found = 0
        for fact in facts:
            found |= 1 << self.number.setdefault(fact, len(self.number))
        return found

    def goal(self, state: int) -> bool:
        return any(state & yes == yes and not state & no for yes, no in self.goals)

    def steps(self, state: int) -> list[tuple[_Op, int]]:
        """Each action that can be done, with the state after it."""
        return [
            (op, state & ~op.lose | op.gain) for op in self.ops if state & op.need == op.need and not state & op.forbid
        ]

    def fired(self, state: int) -> list[tuple[int, int]]:
        """Each event that can happen, with what it removes."""
        return [
            (state & ~lose | gain, lose) for yes, no, lose, gain in self.events if state & yes == yes and not state & no
        ]

    def way(self, before: dict[int, int], end: int) -> tuple[Facts, ...]:
        """The states from the start to one, as facts."""
        masks = [end]
        while masks[-1] != self.start:
            masks.append(before[masks[-1]])
        names = list(self.number)
        return tuple(frozenset(f for i, f in enumerate(names) if m >> i & 1) for m in reversed(masks))

    def meanwhile(self, state: int, op: _Op) -> set[int]:
        """The states in which an action can end or be halted when events happen while it runs."""
        ends: set[int] = set()
        first = (state & ~op.suspend, state & op.suspend)
        seen, queue = {first}, deque([first])
        while queue:
            here, held = queue.popleft()
            ends.add(here | held)
            if here & op.hold == op.hold and not here & op.hold_not:
                ends.add(here & ~op.lose | op.gain)
            for then, lose in self.fired(here):
                entry = (then, held & ~lose)
                if entry not in seen:
                    seen.add(entry)
                    queue.append(entry)
        return ends


def reachable(domain: Domain, facts: Facts, goals: Goals, cap: int = CAP) -> bool | None:
    """Whether actions alone lead from a state to the goals; None where there are more than `cap` states."""
    far = shortest(domain, facts, goals, cap)
    return None if far is None else far >= 0


def shortest(domain: Domain, facts: Facts, goals: Goals, cap: int = CAP) -> int | None:
    """The fewest actions to the goals, -1 where none lead there; None where there are more than `cap` states."""
    states = path(domain, facts, goals, cap)
    return None if states is None else len(states) - 1


def path(domain: Domain, facts: Facts, goals: Goals, cap: int = CAP) -> tuple[Facts, ...] | None:
    """The states on a shortest way to the goals, none where none leads there; None with more than `cap` states."""
    space = _Space(domain, facts, goals, ())
    before: dict[int, int] = {space.start: space.start}
    layer = [space.start]
    while layer:
        end = next((s for s in layer if space.goal(s)), None)
        if end is not None:
            return space.way(before, end)
        following = []
        for state in layer:
            for _, then in space.steps(state):
                if then not in before:
                    before[then] = state
                    following.append(then)
        if len(before) > cap:
            return None
        layer = following
    return ()


@dataclass(frozen=True, slots=True)
class Label:
    """`solvable` as an episode has it; `dead_ends`: from some state that can come about the goals cannot be reached."""

    solvable: bool | None
    dead_ends: bool


def label(domain: Domain, facts: Facts, goals: Goals, events: Iterable[Event], cap: int = CAP) -> Label | None:
    """What holds of an episode whatever is done, and whenever and however often its events fire; None where there are
    too many states."""
    space = _Space(domain, facts, goals, events)
    before: dict[int, list[int]] = {space.start: []}
    after: dict[int, list[tuple[_Op, int, set[int]]]] = {}
    queue = deque([space.start])
    while queue:
        state = queue.popleft()
        steps = [(op, then, space.meanwhile(state, op) if space.events else {then}) for op, then in space.steps(state)]
        after[state] = steps
        found = {end for _, then, ends in steps for end in (then, *ends)} | {then for then, _ in space.fired(state)}
        for then in sorted(found):
            if then not in before:
                before[then] = []
                queue.append(then)
        for _, then, _ in steps:
            before[then].append(state)
        if len(before) > cap:
            return None
    winning = {s for s in before if space.goal(s)}
    if not winning:
        return Label(False, True)
    queue = deque(winning)
    while queue:
        for earlier in before[queue.popleft()]:
            if earlier not in winning:
                winning.add(earlier)
                queue.append(earlier)
    if len(winning) == len(before):
        return Label(True, False)
    if space.start not in winning:
        return Label(None if space.events else False, True)
    # whoever takes only actions that keep the goals in reach: can an event put them out of reach?
    seen, queue = {space.start}, deque([space.start])
    while queue:
        state = queue.popleft()
        found = {then for then, _ in space.fired(state)}
        for _, then, ends in after[state]:
            if then in winning:
                found |= ends
        if not found <= winning:
            return Label(None, True)
        for then in found - seen:
            seen.add(then)
            queue.append(then)
    return Label(True, True)
