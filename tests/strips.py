"""Random domains of propositions: dead ends, negative preconditions, coins that can be spent wrongly, no invariants.

The model here is sets and set operations over the drawn templates; it knows nothing of ground actions.
"""

from __future__ import annotations

import random
from collections import deque
from dataclasses import dataclass
from functools import cached_property

from llmbt_atl.library import parse_library
from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Condition, Facts, Goals, holds


@dataclass(frozen=True)
class Op:
    """A template without parameters: literals it needs (looked at once, or all the while), what begins, what ends."""

    name: str
    start: tuple[Condition, ...]
    hold: tuple[Condition, ...]
    adds: Facts
    deletes: Facts

    def able(self, facts: Facts) -> bool:
        return all(holds(c, facts) for c in self.start + self.hold)

    def after(self, facts: Facts) -> Facts:
        return (facts - self.deletes) | self.adds


@dataclass(frozen=True)
class Strips:
    """A problem: operators, a state, goals."""

    ops: tuple[Op, ...]
    facts: Facts
    goals: Goals

    @cached_property
    def domain(self) -> Domain:
        """The same, as a library over no things."""

        def xml(literals: tuple[Condition, ...] | Facts) -> str:
            return "".join(
                f"<Inverter><{c.name}/></Inverter>" if c.negated else f"<{c.name}/>" for c in sorted(literals)
            )

        names = {c.name for o in self.ops for c in (*o.start, *o.hold, *o.adds, *o.deletes)}
        names |= {c.name for c in self.facts} | {c.name for g in self.goals for c in g}
        conditions = "".join(f'<condition name="{n}" goal="true"/>' for n in sorted(names))
        templates = "".join(
            f'<template name="{o.name}"><start>{xml(o.start)}</start><hold>{xml(o.hold)}</hold>'
            f"<post>{xml(o.adds)}</post><delete>{xml(o.deletes)}</delete></template>"
            for o in self.ops
        )
        text = (
            f'<library name="strips"><types/><conditions>{conditions}</conditions>'
            f"<templates>{templates}</templates></library>"
        )
        return Domain(parse_library(text.encode(), "strips.xml"), {}).for_state(self.facts)

    def op(self, call: ActionCall) -> Op:
        return next(o for o in self.ops if o.name == call.name)

    def shortest(self, facts: Facts | None = None, without: frozenset[str] = frozenset()) -> int | None:
        """Breadth first: the fewest actions to one of the alternatives, None where there is no way."""
        start = self.facts if facts is None else facts
        seen, queue = {start}, deque([(start, 0)])
        while queue:
            here, far = queue.popleft()
            if self.reached(here):
                return far
            for o in self.ops:
                then = o.after(here)
                if o.name not in without and o.able(here) and then not in seen:
                    seen.add(then)
                    queue.append((then, far + 1))
        return None

    def reached(self, facts: Facts) -> bool:
        return any(all(holds(c, facts) for c in g) for g in self.goals)


def random_strips(rng: random.Random, *, negation: bool = True, alternatives: int = 1) -> Strips:
    """A problem over up to nine propositions; about half of them can be solved."""
    flags = [Condition(f"P{i}") for i in range(rng.randint(3, 9))]

    def literals(most: int) -> tuple[Condition, ...]:
        chosen = rng.sample(flags, min(len(flags), rng.randint(0, most)))
        return tuple(~c if negation and rng.random() < 0.25 else c for c in chosen)

    ops = []
    for i in range(rng.randint(2, 10)):
        pre = literals(3)
        cut = rng.randint(0, len(pre))
        adds = frozenset(rng.sample(flags, rng.randint(0, 2)))
        deletes = frozenset(rng.sample(flags, rng.randint(0, 2))) - adds
        if rng.random() < 0.6:
            deletes |= frozenset(c for c in pre[:1] if not c.negated) - adds
        if adds or deletes:
            ops.append(Op(f"do{i}", pre[:cut], pre[cut:], adds, deletes))
    if not ops:
        ops.append(Op("do", (), (), frozenset(flags[:1]), frozenset()))
    goals = []
    for _ in range(alternatives):
        chosen = rng.sample(flags, rng.randint(1, 3))
        goals.append(tuple(~c if negation and rng.random() < 0.25 else c for c in chosen))
    facts = frozenset(f for f in flags if rng.random() < 0.4)
    return Strips(tuple(ops), facts, tuple(dict.fromkeys(goals)))
