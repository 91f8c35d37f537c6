"""Random STRIPS over propositions: with and without dead ends, with negation, and with threats that moves make real."""

from __future__ import annotations

import numpy as np

from llmbt_atl.library import Library
from llmbt_atl.state import Domain
from llmbt_atl.template import Pattern, Template, Variable
from llmbt_ir.condition import Condition, Facts
from llmbt_runtime.episodes.model import Draft, flag, legal
from llmbt_runtime.symbolic import Event

__all__ = ["random_strips", "threats"]


def _p(name: str, negated: bool = False) -> Pattern:
    return Pattern(name, (), negated)


def _library(
    name: str, flags: list[str], templates: list[Template], variables: tuple[tuple[str, ...], ...] = ()
) -> Library:
    return Library(
        name,
        {},
        {f: flag(f) for f in flags},
        tuple(Variable(f"v{i}", (), tuple(_p(v) for v in values)) for i, values in enumerate(variables)),
        {t.name: t for t in templates},
    )


def random_strips(rng: np.random.Generator, *, negation: bool = False, costly: bool = False) -> Draft:
    """Some seven propositions, a few of them values of one state variable, and a dozen actions. `costly`: more is
    deleted and less can be brought back, so that dead ends are common."""
    flags = [f"p{i}" for i in range(int(rng.integers(6, 9)))]
    group = tuple(flags[: int(rng.integers(2, 4))]) if rng.random() < 0.5 else ()
    templates = []
    once = len(flags) if costly else 2 * len(flags)
    for n in range(once):
        gain = flags[n % len(flags)]
        others = [f for f in flags if f != gain]
        order = [others[i] for i in rng.permutation(len(others))]
        k = int(rng.integers(1, 3))
        pre, rest = order[:k], order[k:]
        if len([f for f in pre if f in group]) > 1:
            pre = [f for f in pre if f not in group] + [f for f in pre if f in group][:1]
        signs = [negation and bool(rng.random() < 0.4) for _ in pre]
        literals = tuple(_p(f, s) for f, s in zip(pre, signs, strict=True))
        cut = int(rng.integers(0, len(literals) + 1))
        gone = [f for f in pre + rest if rng.random() < (0.3 if costly else 0.15)]
        add = [gain] + ([rest[0]] if rest and rng.random() < 0.15 and not {rest[0], gain} & set(group) else [])
        templates.append(
            Template(
                f"a{n}",
                (),
                literals[:cut],
                literals[cut:],
                tuple(_p(f) for f in add),
                tuple(_p(f) for f in gone if f not in add),
            )
        )
    lib = _library("random", flags, templates, (group,) if group else ())
    held = [f for f in flags if rng.random() < 0.4]
    facts = _one_each(frozenset(Condition(f) for f in held), group)
    domain = Domain(lib, {}).for_state(facts)
    goals = _goals(rng, flags, group, negation)
    return Draft(domain, facts, (goals,), _moves(rng, domain, flags, group))


def _one_each(facts: Facts, group: tuple[str, ...]) -> Facts:
    """Of the values of a variable the first that is there."""
    values = sorted(f for f in facts if f.name in group)
    return facts - frozenset(values[1:])


def _goals(rng: np.random.Generator, flags: list[str], group: tuple[str, ...], negation: bool) -> tuple[Condition, ...]:
    chosen: list[Condition] = []
    for i in rng.permutation(len(flags)):
        literal = Condition(flags[i], (), negation and bool(rng.random() < 0.4))
        taken = any(c.name in group and not c.negated for c in chosen)
        if not (literal.name in group and not literal.negated and taken):
            chosen.append(literal)
        if len(chosen) == 3:
            break
    return tuple(chosen)


def _moves(rng: np.random.Generator, domain: Domain, flags: list[str], group: tuple[str, ...]) -> tuple[Event, ...]:
    """What may happen: somebody does one of the actions, or a proposition changes by itself."""
    moves = [
        Event(0, a.deletes, a.adds, a.pre, str(a)) for a in domain.actions if not {c.name for c in a.adds} & set(group)
    ]
    for f in flags:
        fact = Condition(f)
        moves.append(Event(0, frozenset({fact}), frozenset(), (fact,), f"end {f}"))
        rivals = frozenset(Condition(g) for g in group if f in group and g != f)
        moves.append(Event(0, rivals, frozenset({fact}), (~fact,), f"begin {f}"))
    return tuple(moves[i] for i in rng.permutation(len(moves)))


def threats(rng: np.random.Generator) -> Draft:
    """Goals that are made with tools, one tool at a time; making one may undo others, so that a move which keeps one
    goal safe exposes another. Some goals can also be made in a dearer way that undoes nothing."""
    n = int(rng.integers(3, 5))
    goals = [f"g{i}" for i in range(n)]
    tools = [f"tool{i}" for i in range(n)]
    bare, spare = "bare", [f"s{i}" for i in range(n)]
    templates = []
    for i in range(n):
        undone = [g for j, g in enumerate(goals) if j != i and rng.random() < 0.4]
        templates.append(Template(f"take{i}", (), (_p(bare),), (), (_p(tools[i]),)))
        templates.append(Template(f"drop{i}", (), (), (_p(tools[i]),), (_p(bare),)))
        needs = (_p(tools[i]),) + ((_p(goals[int(rng.integers(n))], True),) if rng.random() < 0.2 else ())
        needs = tuple(p for p in needs if p.name != goals[i])
        templates.append(Template(f"make{i}", (), (), needs, (_p(goals[i]),), tuple(_p(g) for g in undone)))
        if rng.random() < 0.7:
            other = goals[int(rng.integers(n))]
            start = (_p(bare),) + ((_p(other),) if other != goals[i] and rng.random() < 0.5 else ())
            templates.append(Template(f"fetch{i}", (), start, (), (_p(spare[i]),)))
            templates.append(Template(f"craft{i}", (), (_p(spare[i]),), (_p(bare),), (_p(goals[i]),), (_p(spare[i]),)))
    flags = [*goals, *tools, bare, *spare]
    lib = _library("threats", flags, templates, ((bare, *tools),))
    facts = frozenset([Condition(bare)] + [Condition(g) for g in goals if rng.random() < 0.3])
    domain = Domain(lib, {}).for_state(facts)
    wanted = [goals[i] for i in rng.permutation(n)]
    moves = [legal(domain, f"undo {g}", (Condition(g),), {Condition(g)}, set()) for g in goals]
    moves += [legal(domain, f"knock {t} off", (Condition(t),), {Condition(t)}, {Condition(bare)}) for t in tools]
    moves += [legal(domain, f"use up {s}", (Condition(s),), {Condition(s)}, set()) for s in spare]
    chosen = tuple(moves[i] for i in rng.permutation(len(moves)))
    return Draft(domain, facts, (tuple(Condition(g) for g in wanted),), chosen)
