"""Random small planning problems, with negative preconditions, state variables, containment and dead ends."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from hypothesis import strategies as st

from llmbt_atl.library import Library
from llmbt_atl.state import Domain
from llmbt_atl.template import ANY, ConditionType, Param, Pattern, Template, Variable
from llmbt_ir.condition import Condition, Facts

TYPES = {"thing": None, "part": "thing", "place": None}
THINGS = {"a": "thing", "b": "part", "box": "place", "shelf": "place"}
PARENTS = {"box": "shelf"}


@dataclass(frozen=True)
class Sample:
    """A domain, a state and goals."""

    domain: Domain
    facts: Facts
    goals: tuple[Condition, ...]


@st.composite
def libraries(draw: st.DrawFn) -> Library:
    """A library of at most four conditions and five templates."""
    kinds = (
        (),
        (),
        (Param("x", "thing"),),
        (Param("x", "part"),),
        (Param("x", "thing"), Param("y", "place", upward=True)),
    )
    conditions = {
        f"c{i}": ConditionType(f"c{i}", draw(st.sampled_from(kinds)), True) for i in range(draw(st.integers(2, 4)))
    }
    variables = []
    if draw(st.booleans()):
        values = draw(st.lists(st.sampled_from(sorted(conditions)), min_size=2, max_size=3, unique=True))
        keyed = all(conditions[v].params for v in values) and draw(st.booleans())
        variables.append(
            Variable(
                "v",
                (Param("k", "thing"),) if keyed else (),
                tuple(
                    Pattern(
                        v,
                        tuple("{k}" if keyed and i == 0 else ANY for i in range(len(conditions[v].params))),
                    )
                    for v in values
                ),
            )
        )
    templates = [draw(templates_over(conditions, f"t{i}")) for i in range(draw(st.integers(1, 5)))]
    return Library("random", TYPES, conditions, tuple(variables), {t.name: t for t in templates})


@st.composite
def templates_over(draw: st.DrawFn, conditions: dict[str, ConditionType], name: str) -> Template:
    """A template whose parameters fit what it mentions; effects may be ill-typed, as in the shipped libraries."""
    params = draw(
        st.sampled_from(
            [
                (),
                (Param("p", "thing"),),
                (Param("p", "thing"), Param("q", "thing")),
                (Param("p", "part"), Param("l", "place")),
                (Param("p", "thing"), Param("l", "place")),
                (Param("p", "thing"), Param("l", "place", innermost=True)),
            ]
        )
    )
    things = [p.name for p in params if p.type != "place"]
    places = [p.name for p in params if p.type == "place"]

    def usable(c: ConditionType) -> bool:
        return all((places if p.type == "place" else things) for p in c.params)

    names = sorted(n for n, c in conditions.items() if usable(c))

    def patterns(low: int, high: int, negated: bool) -> tuple[Pattern, ...]:
        found = []
        for n in draw(st.lists(st.sampled_from(names), min_size=low, max_size=high)) if names else ():
            args = tuple(
                "{" + draw(st.sampled_from(places if p.type == "place" else things)) + "}" for p in conditions[n].params
            )
            found.append(Pattern(n, args, negated and draw(st.integers(0, 3)) == 0))
        return tuple(dict.fromkeys(found))

    pair = len(things) == 2 and draw(st.booleans())
    return Template(
        name,
        params,
        patterns(0, 2, True),
        patterns(0, 1, True),
        patterns(0, 2, False),
        patterns(0, 2, False),
        ((things[0], things[1]),) if pair else (),
    )


def ground_facts(domain: Domain) -> list[Condition]:
    """Every fact that could hold."""
    return [
        Condition(c.name, args)
        for c in domain.library.conditions.values()
        for args in product(*(domain.by_type[p.type] for p in c.params))
    ]


@st.composite
def samples(draw: st.DrawFn) -> Sample:
    """A problem of at most a few hundred states."""
    domain = Domain(draw(libraries()), THINGS, PARENTS)
    universe = ground_facts(domain)
    facts = frozenset(draw(st.lists(st.sampled_from(universe), max_size=4)))
    if draw(st.booleans()):
        facts = frozenset(u for f in facts for u in domain.upward(f))
    goals = draw(st.lists(st.sampled_from(universe), min_size=1, max_size=3, unique=True))
    literals = tuple(~g if draw(st.integers(0, 3)) == 0 else g for g in goals)
    return Sample(domain.for_state(facts), facts, literals)
