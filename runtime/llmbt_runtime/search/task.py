"""A domain by numbers: ground actions as tuples of literal numbers, and the tables that searches ask for."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Condition, Facts

__all__ = ["Key", "Op", "Task"]

Key = tuple[int, ...]
"""A state variable of some things: its number, then theirs."""


class Op(NamedTuple):
    """A ground action: `start` and `hold` are its preconditions as literal numbers, `pre` both, each once; `adds` and
    `deletes` are fact numbers."""

    template: str
    args: tuple[str, ...]
    start: tuple[int, ...]
    hold: tuple[int, ...]
    pre: tuple[int, ...]
    adds: tuple[int, ...]
    deletes: tuple[int, ...]
    rank: int

    @property
    def call(self) -> ActionCall:
        """The action's name and arguments."""
        return ActionCall(self.template, self.args)


@dataclass(frozen=True, eq=False)
class Task:
    """The literals and actions of a domain by number.

    Fact `i` has the literal number `2 * i`; its negation `2 * i + 1`.
    """

    domain: Domain
    facts: tuple[Condition, ...]
    number: Mapping[Condition, int] = field(repr=False)
    ops: tuple[Op, ...] = field(repr=False)
    keys: tuple[tuple[Key, ...], ...] = field(repr=False)
    """For each fact the state variables of which it is a value: the variable's number and its binding."""
    related: Mapping[int, frozenset[int]] = field(repr=False)
    """For a fact about a place that contains or is contained: the facts that may hold together with it."""

    @cached_property
    def op_of(self) -> Mapping[ActionCall, int]:
        """Each call's action number."""
        return {op.call: i for i, op in enumerate(self.ops)}

    @cached_property
    def groups(self) -> dict[Key, list[int]]:
        """The values of each state variable, for each binding."""
        table: dict[Key, list[int]] = {}
        for fact, keys in enumerate(self.keys):
            for key in keys:
                table.setdefault(key, []).append(fact)
        return table

    @cached_property
    def negative(self) -> frozenset[int]:
        """The facts whose negation some action needs."""
        return frozenset(p >> 1 for op in self.ops for p in op.pre if p & 1)

    @cached_property
    def needed_by(self) -> tuple[tuple[int, ...], ...]:
        """For each literal the actions that need it."""
        table: list[list[int]] = [[] for _ in range(2 * len(self.facts))]
        for i, op in enumerate(self.ops):
            for p in op.pre:
                table[p].append(i)
        return tuple(map(tuple, table))

    @cached_property
    def pre_counts(self) -> tuple[int, ...]:
        """For each action the number of its preconditions."""
        return tuple(len(op.pre) for op in self.ops)

    @cached_property
    def always(self) -> tuple[int, ...]:
        """The actions without preconditions."""
        return tuple(i for i, op in enumerate(self.ops) if not op.pre)

    @cached_property
    def effects(self) -> tuple[tuple[int, ...], ...]:
        """For each action the literals that hold after it and that an action may need."""
        return self.effects_for(self.negative)

    def effects_for(self, negative: frozenset[int]) -> tuple[tuple[int, ...], ...]:
        """For each action what it adds, and of what it deletes the negations in `negative`."""
        if not negative:
            return tuple(tuple(2 * f for f in op.adds) for op in self.ops)
        return tuple(
            tuple(2 * f for f in op.adds) + tuple(2 * f + 1 for f in op.deletes if f in negative) for op in self.ops
        )

    @cached_property
    def adders(self) -> Mapping[int, tuple[int, ...]]:
        """For each fact the actions that add it."""
        table: dict[int, list[int]] = {}
        for i, op in enumerate(self.ops):
            for f in op.adds:
                table.setdefault(f, []).append(i)
        return {f: tuple(ops) for f, ops in table.items()}

    @cached_property
    def deleters(self) -> Mapping[int, tuple[int, ...]]:
        """For each fact the actions that delete it."""
        table: dict[int, list[int]] = {}
        for i, op in enumerate(self.ops):
            for f in op.deletes:
                table.setdefault(f, []).append(i)
        return {f: tuple(ops) for f, ops in table.items()}

    def fact_numbers(self, facts: Facts) -> list[int]:
        """The numbers of the facts that any action mentions, in order."""
        number = self.number
        return sorted(number[f] for f in facts if f in number)

    @cached_property
    def _grounded(self) -> dict[int, GroundAction]:
        return {}

    def ground(self, op: int) -> GroundAction:
        """The ground action of an action number."""
        known = self._grounded.get(op)
        if known is None:
            o, facts = self.ops[op], self.facts
            known = self._grounded[op] = GroundAction(
                o.call,
                tuple([~facts[p >> 1] if p & 1 else facts[p >> 1] for p in o.start]),
                tuple([~facts[p >> 1] if p & 1 else facts[p >> 1] for p in o.hold]),
                frozenset([facts[f] for f in o.adds]),
                frozenset([facts[f] for f in o.deletes]),
                o.rank,
            )
        return known

    def among(self, calls: Collection[ActionCall]) -> Task:
        """The task with only those actions."""
        return replace(self, ops=tuple([op for op in self.ops if op.call in calls]))

    def excluded_ops(self, excluded: Iterable[ActionCall]) -> frozenset[int]:
        """The action numbers of calls; calls without an action are passed over."""
        return frozenset(self.op_of[c] for c in excluded if c in self.op_of)
