"""Conditions and ground actions: the vocabulary that trees, templates and worlds share."""

from __future__ import annotations

from collections.abc import Container, Iterable
from dataclasses import dataclass, replace

__all__ = ["ActionCall", "Condition", "Facts", "Goals", "all_hold", "holds", "parse_condition", "satisfied", "show"]


def show(name: str, args: tuple[str, ...]) -> str:
    """``name(a, b)``, or the bare name where there are no arguments."""
    return f"{name}({', '.join(args)})" if args else name


@dataclass(frozen=True, order=True, slots=True)
class Condition:
    """A ground literal, as `On(object_1, position_12)`; `negated` stands for its complement.

    Argument order is that of the condition's declaration in the action template library.
    """

    name: str
    args: tuple[str, ...] = ()
    negated: bool = False

    def __str__(self) -> str:
        return ("not " if self.negated else "") + show(self.name, self.args)

    def __invert__(self) -> Condition:
        return replace(self, negated=not self.negated)

    @property
    def fact(self) -> Condition:
        """The positive literal."""
        return self if not self.negated else replace(self, negated=False)


def parse_condition(text: str) -> Condition | None:
    """The condition that `str` wrote; None where the text is not one."""
    negated = text.startswith("not ")
    name, _, rest = text.removeprefix("not ").partition("(")
    if not name or name != name.strip() or (rest and not rest.endswith(")")):
        return None
    return Condition(name, tuple(a.strip() for a in rest[:-1].split(",")) if rest else (), negated)


Facts = frozenset[Condition]
"""A state: the positive literals that hold. What is not in it does not hold (closed world)."""


def holds(condition: Condition, facts: Container[Condition]) -> bool:
    """Whether a literal holds in a state."""
    return (condition.fact in facts) != condition.negated


@dataclass(frozen=True, order=True, slots=True)
class ActionCall:
    """A ground action: a template's name and its arguments in the order of its parameters."""

    name: str
    args: tuple[str, ...] = ()

    def __str__(self) -> str:
        return show(self.name, self.args)


def all_hold(conditions: Iterable[Condition], facts: Container[Condition]) -> bool:
    """Whether every literal holds in a state."""
    return all(holds(c, facts) for c in conditions)


Goals = tuple[tuple[Condition, ...], ...]
"""What is to be reached, in disjunctive normal form: alternatives, each a conjunction of literals."""


def satisfied(goals: Goals, facts: Container[Condition]) -> bool:
    """Whether one of the alternatives holds."""
    return any(all_hold(alternative, facts) for alternative in goals)
