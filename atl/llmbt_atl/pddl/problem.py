"""A PDDL problem over an imported library: the things, the state and the goals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

from llmbt_atl.library import Library
from llmbt_atl.pddl.formula import Things, alternatives
from llmbt_atl.pddl.names import EQUAL, mangled
from llmbt_atl.pddl.reader import Group, Item, Source, Word, read, title_of
from llmbt_atl.pddl.vocabulary import OBJECT, thing, typed
from llmbt_atl.state import Domain
from llmbt_atl.template import ConditionType
from llmbt_ir.condition import Condition, Facts, Goals
from llmbt_ir.diagnostics import LlmbtError, nearest

__all__ = ["PddlProblem", "import_problem"]

_REFUSED = ("and", "or", "not", "imply", "forall", "exists", "when", "at", "preference", "<", ">", "<=", ">=")


@dataclass(frozen=True, slots=True)
class PddlProblem:
    """A problem: its name, the domain over its objects, the first state, and the goals.

    One of the goals' alternatives is to hold: `()` is one that always does, and without any the goal never does.
    """

    name: str
    domain: Domain
    facts: Facts
    goals: Goals


def import_problem(text: str, library: Library, source: str = "problem.pddl") -> PddlProblem:
    """A PDDL problem over the library of its domain. State variables that its first state breaks are left out.

    Errors: E090 not PDDL, E092 a construct that is not supported, E093 an unknown name, E094 a name declared twice,
    E095 wrong arguments.
    """
    where, group = read(text, source, "problem")
    return _Problem(where, group, library).problem()


class _Problem:
    def __init__(self, source: Source, group: Group, library: Library) -> None:
        self.source, self.group, self.library = source, group, library
        named = {(c.words.split() or [c.name])[0].lower(): c for c in library.conditions.values()}
        self.conditions = {name: c for name, c in named.items() if name != EQUAL}
        self.types = {t.lower(): t for t in library.types}
        self.things = {c.lower(): (c, t) for c, t in library.constants.items()}

    def problem(self) -> PddlProblem:
        sections = {}
        for item in self.group.items[2:]:
            if not isinstance(item, Group) or not item.head.startswith(":"):
                raise self.source.fault("E090", "expected a section, as (:init ...)", item)
            if item.head not in (":domain", ":requirements", ":objects", ":init", ":goal", ":metric"):
                raise self.source.fault("E092", f"`{item.head}` is not supported", item)
            if item.head in sections:
                raise self.source.fault("E094", f"`{item.head}` is there twice", item, "join the two")
            sections[item.head] = item
        for needed in (":init", ":goal"):
            if needed not in sections:
                raise self.source.fault("E090", f"the problem has no {needed}", self.group)
        if ":objects" in sections:
            for name, types in typed(self.source, sections[":objects"].items[1:]):
                self.declare(name, types)
        facts = frozenset(f for item in sections[":init"].items[1:] for f in self.facts(item))
        facts |= frozenset(self.equalities())
        goals = self.goals(sections[":goal"])
        types_of = dict(self.things.values())
        domain = Domain(_true_in(self.library, types_of, facts), types_of)
        return PddlProblem(title_of(self.group), domain.for_state(facts), facts, goals)

    def declare(self, name: Word, types: tuple[Word, ...]) -> None:
        if len(types) > 1:
            raise self.source.fault("E092", "an object of several types is not supported", name)
        own = self.type_of(types[0]) if types else OBJECT
        if name.key in self.things and self.things[name.key][1] != own:
            raise self.source.fault("E094", f"object `{name.text}` is declared twice", name)
        self.things.setdefault(name.key, (thing(self.source, name), own))

    def type_of(self, word: Word) -> str:
        own = self.types.get(mangled(word.text, ()).lower())
        if own is None:
            raise self.unknown("type", word, list(self.types.values()))
        return own

    def unknown(self, what: str, word: Word, known: list[str]) -> LlmbtError:
        close = nearest(word.text, known)
        return self.source.fault(
            "E093", f"unknown {what} `{word.text}`", word, f"did you mean {', '.join(close)}?" if close else ""
        )

    def facts(self, item: Item) -> Iterator[Condition]:
        if isinstance(item, Group) and item.head == "=":
            return  # a fluent's first value: costs are read over
        if isinstance(item, Group) and item.head == "not":
            if len(item.items) != 2:
                raise self.source.fault("E090", "`not` takes one fact", item)
            self.atom(item.items[1])  # what does not hold is not said, but it is looked at
            return
        yield self.atom(item)

    def equalities(self) -> Iterator[Condition]:
        """The facts of the conditions that stand for equalities."""
        for c in self.library.conditions.values():
            words = c.words.split()
            if words[:1] != [EQUAL]:
                continue
            if len(c.params) == 1:
                yield Condition(c.name, (words[-1],))
            else:
                yield from (Condition(c.name, (name, name)) for name, _ in self.things.values())

    def goals(self, section: Group) -> Goals:
        """The goal's alternatives; contradictory ones are left out where there are others."""
        if len(section.items) != 2:
            raise self.source.fault("E090", "a :goal is one condition", section, "join several by (and ...)")
        found = alternatives(self.source, section.items[1], self.literal, self.ranges)
        sound = tuple(a for a in found if not any(~c in a for c in a))
        return sound or found[:1]

    def ranges(self, variables: Group) -> Iterator[Things]:
        """The ways to bind a quantifier's variables to things of their types."""
        listed = list(typed(self.source, variables.items))
        pools = []
        for word, types in listed:
            if not word.text.startswith("?"):
                raise self.source.fault("E090", f"a variable begins with `?`: `?{word.text}`", word)
            wanted = [self.type_of(t) for t in types] or [OBJECT]
            pools.append([n for n, own in self.things.values() if any(self.library.is_a(own, t) for t in wanted)])
        for chosen in product(*pools):
            yield {word.key: name for (word, _), name in zip(listed, chosen, strict=True)}

    def literal(self, group: Group, negated: bool, things: Things) -> Condition | bool:
        """A fact that is to hold or not; an equality of things is decided here."""
        if group.head != EQUAL:
            found = self.atom(group, things)
            return ~found if negated else found
        if len(group.items) != 3:
            raise self.source.fault("E095", "`=` takes 2 arguments", group)
        first, second = (self.thing(a, things)[0] for a in group.items[1:])
        return (first == second) != negated

    def atom(self, item: Item, things: Things | None = None) -> Condition:
        """A fact over things."""
        if not isinstance(item, Group) or not item.items or not isinstance(item.items[0], Word):
            raise self.source.fault("E090", "expected a fact, as (on a b)", item)
        word = item.items[0]
        declared = self.conditions.get(word.key)
        if declared is None:
            if word.key in _REFUSED:
                raise self.source.fault("E092", f"`{word.text}` is not supported here", item)
            raise self.unknown("predicate", word, list(self.conditions))
        args = item.items[1:]
        if len(args) != len(declared.params):
            raise self.source.fault(
                "E095", f"`{word.text}` takes {len(declared.params)} arguments and not {len(args)}", item
            )
        return Condition(declared.name, tuple(self.argument(declared, i, a, things or {}) for i, a in enumerate(args)))

    def argument(self, declared: ConditionType, i: int, item: Item, things: Things) -> str:
        name, type_ = self.thing(item, things)
        wanted = declared.params[i].type
        if not self.library.is_a(type_, wanted):
            raise self.source.fault("E095", f"`{name}` is a {type_} and not a {wanted}", item)
        return name

    def thing(self, item: Item, things: Things) -> tuple[str, str]:
        """The object or constant that a word names, or that a quantifier's variable stands for, with its type."""
        if not isinstance(item, Word):
            raise self.source.fault("E090", "expected an object", item)
        key = things.get(item.key, item.text).lower()
        if key not in self.things:
            raise self.unknown("object", item, [n for n, _ in self.things.values()])
        return self.things[key]


def _true_in(library: Library, types: dict[str, str], facts: Facts) -> Library:
    """The library without the state variables of which two values hold."""
    if not library.variables:
        return library
    domain = Domain(library, types)
    count = Counter((v.name, key) for f in facts for v, key in domain.variables_of(f))
    broken = {name for (name, _), n in count.items() if n > 1}
    if not broken:
        return library
    return replace(library, variables=tuple(v for v in library.variables if v.name not in broken))
