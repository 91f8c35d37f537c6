"""The goals as they come to be: what a later step does to an earlier one, and what is left at the end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from llmbt_compiler.parsing.model import Extent, Goal, LabelledStep, Note, NoteKind
from llmbt_ir.condition import Condition

__all__ = ["Entry", "Ledger"]


@dataclass(frozen=True, slots=True)
class Entry:
    """A condition that a step brings about. `target` and `place` are what it is about;
    `weak`: only a means.
    """

    condition: Condition
    step: LabelledStep
    extent: Extent
    target: str | None = None
    place: str | None = None
    container: str | None = None
    weak: bool = False
    note: Note | None = None

    def goal(self) -> Goal:
        """As a goal, with its words."""
        words = self.extent.cut(self.step.text)
        return Goal(self.condition, self.step.number, words, self.extent, self.step.in_reply(self.extent))


@dataclass
class Ledger:
    """Standing goals, things in the hand and the last way gone, step by step.

    `where` follows the objects through the steps. A later move of an object replaces its earlier one; `moved` counts
    how often that happened to each, `moves` keeps them all, `vacated` is where `leaver`, the last one that was taken,
    stood.
    """

    where: dict[str, str | None]
    goals: list[Entry] = field(default_factory=list)
    pending: dict[str, Entry] = field(default_factory=dict)
    near: Entry | None = None
    carried: str | None = None
    touched: set[str] = field(default_factory=set)
    acts: int = 0
    moved: Counter[str] = field(default_factory=Counter)
    notes: list[Note] = field(default_factory=list)
    moves: list[Entry] = field(default_factory=list)
    vacated: str | None = None
    leaver: str | None = None

    def fork(self) -> Ledger:
        """A second ledger that goes on from here by itself."""
        return replace(
            self, where=dict(self.where), goals=list(self.goals), pending=dict(self.pending),
            touched=set(self.touched), notes=list(self.notes), moved=Counter(self.moved), moves=list(self.moves),
        )  # fmt: skip

    def standing(self) -> tuple[frozenset[Condition], frozenset[str], Condition | None, str | None]:
        """What the steps so far come to: goals, things in the hand, the last way gone, where that leads."""
        near = self.near.condition if self.near is not None else None
        return frozenset(e.condition for e in self.goals), frozenset(self.pending), near, self.carried

    @property
    def handled(self) -> frozenset[str]:
        """The objects that something has been done with."""
        return frozenset(self.touched)

    def of(self, target: str) -> Entry | None:
        """The standing goal about where an object is."""
        return next((e for e in self.goals if e.target == target), None)

    def taken(self, place: str, target: str) -> bool:
        """Whether another object stands on a place, or is to, after the steps so far."""
        return any(p == place and o != target for o, p in self.where.items()) or any(
            e.place == place and e.target not in (None, target) for e in self.goals
        )

    def _moved_again(self, old: Entry, step: LabelledStep, inner: bool) -> None:
        self.goals.remove(old)
        self.moved[str(old.target)] += not inner
        if not inner:
            text = f"{old.target} is moved again in step {step.number}: {old.condition} is no goal"
            self.notes.append(Note(old.step.number, NoteKind.MOVED_AGAIN, text, old.extent))

    def put(self, entry: Entry, *, inner: bool = False) -> None:
        """An object comes to a place. `inner`: the step only says more exactly where it was to be."""
        assert entry.target is not None
        assert entry.place is not None
        old = self.of(entry.target)
        if inner and old is not None and self.moves and self.moves[-1] is old:
            self.moves.pop()
        self.moves.append(entry)
        self.pending.pop(entry.target, None)
        self.near = self.carried = None
        self.touched.add(entry.target)
        self.acts += 1
        if old is not None:
            if old.condition == entry.condition:
                return
            self._moved_again(old, entry.step, inner)
        for free in [e for e in self.goals if e.target is None and e.place == entry.place]:
            self.goals.remove(free)
            text = f"{free.condition} is no goal: {entry.target} is put there in step {entry.step.number}"
            self.notes.append(Note(free.step.number, NoteKind.MOVED_AGAIN, text, free.extent))
        self._leaves(entry.target)
        self.where[entry.target] = entry.place
        self.goals.append(entry)

    def _leaves(self, target: str) -> None:
        """An object is taken from where it stands: that is the place that became free last."""
        if target not in self.pending and self.where.get(target) is not None:
            self.vacated, self.leaver = self.where[target], target

    def free(self, entry: Entry) -> None:
        """A place is to be free: what was to be put there before is not."""
        for old in [e for e in self.goals if e.target is not None and e.place == entry.place]:
            self.goals.remove(old)
            text = f"{old.condition} is no goal: {entry.place} is cleared in step {entry.step.number}"
            self.notes.append(Note(old.step.number, NoteKind.MOVED_AGAIN, text, old.extent))
        for target, place in self.where.items():
            if place == entry.place:
                self.where[target] = None
        self.near = None
        if all(e.condition != entry.condition for e in self.goals):
            self.goals.append(entry)

    def add(self, entry: Entry) -> None:
        """Something becomes so, and stays so wherever things go."""
        self.acts += 1
        if all(e.condition != entry.condition for e in self.goals):
            self.goals.append(entry)

    def take(self, entry: Entry) -> None:
        """An object is picked up."""
        assert entry.target is not None
        self.near = self.carried = None
        self.touched.add(entry.target)
        self.acts += 1
        self._leaves(entry.target)
        old = self.pending.pop(entry.target, None)
        self.pending[entry.target] = old if old is not None and not old.weak else entry

    def go(self, entry: Entry) -> None:
        """The robot goes somewhere: a goal only if nothing is done there."""
        self.near = entry

    def settle(self) -> Iterator[Entry]:
        """Close the book. What is in the hand at the end stays there, if nothing was done after it was picked
        up.

        Yields the things picked up and forgotten.
        """
        last = max((e.step.number, e.extent.start) for e in self.goals) if self.goals else (0, -1)
        latest = max(((e.step.number, e.extent.start) for e in self.pending.values()), default=(0, -1))
        several = sum(not e.weak for e in self.pending.values()) > 1  # one hand holds one thing
        for entry in self.pending.values():
            key = (entry.step.number, entry.extent.start)
            if entry.weak:
                continue
            if (self.carried is not None and self.near is None) or key < last or key < latest or several:
                yield entry
                continue
            old = self.of(str(entry.target))
            if old is not None:
                self._moved_again(old, entry.step, inner=False)
            self.goals.append(entry)
        if self.near is not None:
            self.goals.append(self.near)
        self.notes.extend(e.note for e in self.goals if e.note is not None)
