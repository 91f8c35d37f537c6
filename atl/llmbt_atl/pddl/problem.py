"""A PDDL problem over an imported library: the things, the state and the goals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

from llmbt_atl.library import Library
from llmbt_atl.pddl.domain import OBJECT, typed
from llmbt_atl.pddl.reader import Group, Item, Source, Word, read, title_of
from llmbt_atl.state import Domain
from llmbt_atl.template import ConditionType
from llmbt_ir.condition import Condition, Facts
from llmbt_ir.diagnostics import LlmbtError, nearest

__all__ = ["PddlProblem", "import_problem"]


@dataclass(frozen=True, slots=True)
class PddlProblem:
    """A problem: its name, the domain over its objects, the first state, and the goals, all of which are to hold."""

    name: str
    domain: Domain
    facts: Facts
    goals: tuple[Condition, ...]


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
        self.conditions = {(c.words.split() or [c.name])[0].lower(): c for c in library.conditions.values()}
        self.types = {t.lower(): t for t in library.types}
        self.things = {c.lower(): (c, t) for c, t in library.constants.items()}

    def problem(self) -> PddlProblem:
        sections = {}
        for item in self.group.items[2:]:
            if not isinstance(item, Group) or not item.head.startswith(":"):
                raise self.source.fault("E090", "expected a section, as (:init ...)", item)
            if item.head not in (":domain", ":requirements", ":objects", ":init", ":goal", ":metric"):
                raise self.source.fault("E092", f"`{item.head}` is not supported", item)
            sections[item.head] = item
        for needed in (":init", ":goal"):
            if needed not in sections:
                raise self.source.fault("E090", f"the problem has no {needed}", self.group)
        if ":objects" in sections:
            for name, types in typed(self.source, sections[":objects"].items[1:]):
                self.declare(name, types)
        facts = frozenset(f for item in sections[":init"].items[1:] for f in self.facts(item))
        goals = tuple(dict.fromkeys(self.goals(sections[":goal"].items[1:])))
        types_of = dict(self.things.values())
        domain = Domain(_true_in(self.library, types_of, facts), types_of)
        return PddlProblem(title_of(self.group), domain.for_state(facts), facts, goals)

    def declare(self, name: Word, types: tuple[Word, ...]) -> None:
        if len(types) > 1:
            raise self.source.fault("E092", "an object of several types is not supported", name)
        for type_ in types:
            if type_.key not in self.types:
                raise self.unknown("type", type_, list(self.types.values()))
        own = self.types[types[0].key] if types else self.types[OBJECT]
        if name.key in self.things and self.things[name.key][1] != own:
            raise self.source.fault("E094", f"object `{name.text}` is declared twice", name)
        self.things.setdefault(name.key, (name.text, own))

    def unknown(self, what: str, word: Word, known: list[str]) -> LlmbtError:
        close = nearest(word.text, known)
        return self.source.fault(
            "E093", f"unknown {what} `{word.text}`", word, f"did you mean {', '.join(close)}?" if close else ""
        )

    def facts(self, item: Item) -> Iterator[Condition]:
        if isinstance(item, Group) and item.head == "=":
            return  # a fluent's first value: costs are read over
        if isinstance(item, Group) and item.head == "not":
            return  # what does not hold is not said
        yield self.atom(item)

    def goals(self, items: tuple[Item, ...]) -> Iterator[Condition]:
        for item in items:
            if isinstance(item, Group) and (item.head == "and" or not item.items):
                yield from self.goals(item.items[1:])
            elif isinstance(item, Group) and item.head == "not" and len(item.items) == 2:
                yield ~self.atom(item.items[1])
            else:
                yield self.atom(item)

    def atom(self, item: Item) -> Condition:
        if not isinstance(item, Group) or not item.items or not isinstance(item.items[0], Word):
            raise self.source.fault("E090", "expected a fact, as (on a b)", item)
        word = item.items[0]
        declared = self.conditions.get(word.key)
        if declared is None:
            if word.key in ("or", "imply", "forall", "exists", "and", "not", "at"):
                raise self.source.fault("E092", f"`{word.text}` is not supported here", item, "state a conjunction")
            raise self.unknown("predicate", word, list(self.conditions))
        args = item.items[1:]
        if len(args) != len(declared.params):
            raise self.source.fault(
                "E095", f"`{word.text}` takes {len(declared.params)} arguments and not {len(args)}", item
            )
        return Condition(declared.name, tuple(self.argument(declared, i, a) for i, a in enumerate(args)))

    def argument(self, declared: ConditionType, i: int, item: Item) -> str:
        if not isinstance(item, Word):
            raise self.source.fault("E090", "expected an object", item)
        if item.key not in self.things:
            raise self.unknown("object", item, [n for n, _ in self.things.values()])
        name, type_ = self.things[item.key]
        wanted = declared.params[i].type
        if not self.library.is_a(type_, wanted):
            raise self.source.fault("E095", f"`{name}` is a {type_} and not a {wanted}", item)
        return name


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
