"""What changed: facts as worlds hand them over, and as engines are told of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from llmbt_ir.condition import Condition, Facts

__all__ = ["NO_CHANGE", "Change", "FactBase", "change_between"]


@dataclass(frozen=True, slots=True)
class Change:
    """Facts that began and facts that ended since the last time. Telling what is known already does no harm."""

    added: Facts = frozenset()
    removed: Facts = frozenset()

    def __bool__(self) -> bool:
        return bool(self.added or self.removed)


NO_CHANGE = Change()


def change_between(before: Facts, after: Facts) -> Change:
    """What leads from one state to another. The same object costs nothing; otherwise the cost is that of the states."""
    return NO_CHANGE if before is after or before == after else Change(after - before, before - after)


class FactBase:
    """Facts that are written to, with a note of what changed since it was last asked for: `take` costs what changed."""

    def __init__(self, facts: Iterable[Condition] = ()) -> None:
        self._facts: set[Condition] = set(facts)
        self._added: set[Condition] = set(self._facts)
        self._removed: set[Condition] = set()
        self._whole: Facts | None = None

    def __contains__(self, fact: object) -> bool:
        return fact in self._facts

    def add(self, fact: Condition) -> None:
        """A fact holds from now on."""
        if fact not in self._facts:
            self._facts.add(fact)
            self._noted(fact, self._removed, self._added)

    def remove(self, fact: Condition) -> None:
        """A fact holds no longer."""
        if fact in self._facts:
            self._facts.remove(fact)
            self._noted(fact, self._added, self._removed)

    def _noted(self, fact: Condition, undone: set[Condition], done: set[Condition]) -> None:
        self._whole = None
        if fact in undone:
            undone.remove(fact)
        else:
            done.add(fact)

    def write(self, removed: Iterable[Condition], added: Iterable[Condition]) -> None:
        """Facts end, and then facts begin: what is in both holds."""
        for fact in removed:
            self.remove(fact)
        for fact in added:
            self.add(fact)

    def become(self, facts: Facts) -> None:
        """From now on these hold and no others, at the cost of the states."""
        change = change_between(self.facts, facts)
        self.write(change.removed, change.added)

    def take(self) -> Change:
        """The difference between what holds and what held at the last call; at first all that holds."""
        if not self._added and not self._removed:
            return NO_CHANGE
        change = Change(frozenset(self._added), frozenset(self._removed))
        self._added.clear()
        self._removed.clear()
        return change

    @property
    def facts(self) -> Facts:
        """All that holds now: the same object until something changes, then a copy."""
        if self._whole is None:
            self._whole = frozenset(self._facts)
        return self._whole
