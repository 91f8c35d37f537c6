"""Action templates with typed parameters, and the state variables from which deletes and mutexes follow.

A template is the paper's `a = {Pre(a), Post(a)}` (formula 1) with Pre divided in two: start-conditions, looked at
when the action starts, and hold-conditions, which have to hold all the while it runs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from llmbt_ir.condition import Condition

__all__ = ["ANY", "ConditionType", "Param", "Pattern", "Role", "Template", "Variable"]

ANY = "*"
"""In a state variable: any thing of the parameter's type."""


class Role(StrEnum):
    """The part a parameter plays in a step (paper, section IV.C)."""

    TARGET = "T"
    DESTINATION = "D"
    LOCATION = "L"
    NONE = ""


@dataclass(frozen=True, slots=True)
class Param:
    """A typed parameter. Of a condition, `upward`: what holds for a place holds for the places that contain it. Of a
    template, `innermost`: it stands for the most specific place, so that nothing that is said of it in Pre may hold for
    a place within it."""

    name: str
    type: str
    role: Role = Role.NONE
    upward: bool = False
    innermost: bool = False


@dataclass(frozen=True, slots=True)
class Pattern:
    """A condition over parameters: an argument is `{param}`, `*` or a constant."""

    name: str
    args: tuple[str, ...]
    negated: bool = False
    line: int = 0

    def __str__(self) -> str:
        args = ", ".join(a[1:-1] if a.startswith("{") else a for a in self.args)
        return ("not " if self.negated else "") + self.name + (f"({args})" if args else "")

    def params(self) -> tuple[str, ...]:
        """The parameters it mentions."""
        return tuple(a[1:-1] for a in self.args if a.startswith("{"))

    def bind(self, binding: Mapping[str, str]) -> Condition:
        """The ground condition; every `{param}` is bound."""
        return Condition(
            self.name,
            tuple(binding[a[1:-1]] if a.startswith("{") else a for a in self.args),
            self.negated,
        )


@dataclass(frozen=True, slots=True)
class ConditionType:
    """A condition's name and parameters. `goal`: a request may name it; `words`: how a person says it."""

    name: str
    params: tuple[Param, ...]
    goal: bool = False
    words: str = ""
    line: int = 0


@dataclass(frozen=True, slots=True)
class Variable:
    """A state variable: of its `values`, for each binding of `params`, at most one holds.

    Values that differ only in an `upward` place where one contains the other go together.
    """

    name: str
    params: tuple[Param, ...]
    values: tuple[Pattern, ...]
    line: int = 0


@dataclass(frozen=True, slots=True)
class Template:
    """An action template. `unequal` are pairs of parameters that must differ; `deletes` only the explicit ones.

    One that `senses` looks for something: its Post is what a plan may hope for, and whatever is found instead is no
    failure.
    """

    name: str
    params: tuple[Param, ...]
    start: tuple[Pattern, ...]
    hold: tuple[Pattern, ...]
    post: tuple[Pattern, ...]
    deletes: tuple[Pattern, ...] = ()
    unequal: tuple[tuple[str, str], ...] = ()
    verbs: tuple[str, ...] = ()
    words: str = ""
    line: int = 0
    senses: bool = False

    @property
    def pre(self) -> tuple[Pattern, ...]:
        """Start- and hold-conditions, in the order in which a tree checks them."""
        return self.start + self.hold

    def param(self, role: Role) -> Param | None:
        """The first parameter with a role."""
        return next((p for p in self.params if p.role is role), None)
