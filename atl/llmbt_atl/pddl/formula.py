"""A PDDL condition as alternatives, each a conjunction (disjunctive normal form), with a bound on their number."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Generic, TypeVar

from llmbt_atl.pddl.reader import Group, Item, Source

__all__ = ["MAX_ALTERNATIVES", "Things", "alternatives"]

MAX_ALTERNATIVES = 256
"""Of one formula: `n` pairs, (and (or a b) (or c d) ...), have 2**n."""
Leaf = TypeVar("Leaf", bound=Hashable)
Things = Mapping[str, str]
"""What the variables of quantifiers stand for, by their keys."""
Ranges = Callable[[Group], Iterable[Things]]
"""The ways to bind a quantifier's variables."""
_DUAL = {"and": "or", "or": "and", "forall": "exists", "exists": "forall"}


def alternatives(
    source: Source,
    item: Item,
    leaf: Callable[[Group, bool, Things], Leaf | bool],
    ranges: Ranges | None = None,
) -> tuple[tuple[Leaf, ...], ...]:
    """The alternatives of a formula of and, or, not, imply and, where `ranges` binds their variables, forall and
    exists. None contains another: () alone says that it always holds, none that it never does.

    `leaf` reads an atom, negated or not, or says what it always is. E090 where the formula is none; E092 where it has a
    quantifier and no `ranges`, or more than `MAX_ALTERNATIVES`.
    """
    found = _Reader(source, leaf, ranges).read(item, False, {})
    return tuple(one for one in found if not any(set(other) < set(one) for other in found))


class _Reader(Generic[Leaf]):
    def __init__(
        self, source: Source, leaf: Callable[[Group, bool, Things], Leaf | bool], ranges: Ranges | None
    ) -> None:
        self.source, self.leaf, self.ranges = source, leaf, ranges

    def read(self, item: Item, negated: bool, things: Things) -> list[tuple[Leaf, ...]]:
        if not isinstance(item, Group):
            raise self.source.fault("E090", "expected a condition in parentheses", item)
        if not item.items:
            return [] if negated else [()]
        head = item.head
        if head == "not":
            if len(item.items) != 2:
                raise self.source.fault("E090", "`not` takes one condition", item)
            return self.read(item.items[1], not negated, things)
        if head == "imply":
            if len(item.items) != 3:
                raise self.source.fault("E090", "`imply` takes two conditions", item)
            no = self.read(item.items[1], not negated, things)
            yes = self.read(item.items[2], negated, things)
            return self.both(no, yes, item) if negated else self.either(no, yes, item)
        shape = _DUAL.get(head, "") if negated else head
        if head in ("and", "or"):
            parts = (self.read(part, negated, things) for part in item.items[1:])
        elif head in ("forall", "exists") and self.ranges is not None:
            if len(item.items) != 3 or not isinstance(item.items[1], Group):
                raise self.source.fault("E090", f"`{head}` takes variables and a condition", item)
            parts = (self.read(item.items[2], negated, {**things, **more}) for more in self.ranges(item.items[1]))
        else:
            said = self.leaf(item, negated, things)
            return [()] if said is True else [] if said is False else [(said,)]
        found: list[tuple[Leaf, ...]] = [()] if shape in ("and", "forall") else []
        for part in parts:
            found = (self.both if shape in ("and", "forall") else self.either)(found, part, item)
        return found

    def both(self, left: list[tuple[Leaf, ...]], right: list[tuple[Leaf, ...]], at: Group) -> list[tuple[Leaf, ...]]:
        if len(left) * len(right) > MAX_ALTERNATIVES:
            self.too_many(at)
        return list(dict.fromkeys(tuple(dict.fromkeys((*a, *b))) for a in left for b in right))

    def either(self, left: list[tuple[Leaf, ...]], right: list[tuple[Leaf, ...]], at: Group) -> list[tuple[Leaf, ...]]:
        if len(left) + len(right) > MAX_ALTERNATIVES:
            self.too_many(at)
        return list(dict.fromkeys((*left, *right)))

    def too_many(self, at: Group) -> None:
        raise self.source.fault("E092", f"this has more than {MAX_ALTERNATIVES} alternatives", at, "state fewer")
