"""A PDDL domain as a library: STRIPS with typing, negative and disjunctive preconditions, and equality.

McDermott et al., "PDDL - the planning domain definition language", 1998; Fox and Long, JAIR 20 (2003), for the syntax.
A disjunction makes one template for each alternative, a parameter of type `(either a b)` one for each type; action
costs are read over. Preconditions become start-conditions: PDDL's actions have no duration.
"""

from __future__ import annotations

from collections.abc import Iterator

from llmbt_atl.library import Library
from llmbt_atl.pddl.action import templates_of
from llmbt_atl.pddl.invariants import with_invariants
from llmbt_atl.pddl.names import mangled
from llmbt_atl.pddl.reader import Group, Item, Source, Word, read, title_of
from llmbt_atl.pddl.vocabulary import Vocabulary, typed
from llmbt_ir.diagnostics import nearest

__all__ = ["import_domain"]

_SUPPORTED = frozenset(
    {
        ":strips",
        ":typing",
        ":negative-preconditions",
        ":disjunctive-preconditions",
        ":equality",
        ":action-costs",
    }
)
_REFUSED_WHERE_USED = frozenset(
    {":adl", ":quantified-preconditions", ":existential-preconditions", ":universal-preconditions"}
    | {":conditional-effects"}
)
"""Many domains ask for these and use only what is supported."""
_SECTIONS = frozenset({":requirements", ":types", ":constants", ":predicates", ":functions", ":action"})


def import_domain(text: str, source: str) -> Library:
    """The library of a PDDL domain, with the state variables that can be shown to be invariants.

    Errors: E090 not PDDL, E091 a requirement and E092 a construct that is not supported, E093 an unknown name,
    E094 a name declared twice, E095 wrong arguments.
    """
    where, group = read(text, source, "domain")
    return with_invariants(_library(where, group))


def _library(source: Source, group: Group) -> Library:
    sections = list(_sections(source, group))
    _check_requirements(source, _all_of(sections, ":requirements"))
    vocabulary = Vocabulary(source)
    vocabulary.read_types(list(_all_of(sections, ":types")))
    for name, types in typed(source, _all_of(sections, ":constants")):
        vocabulary.constant(name, types)
    for item in _all_of(sections, ":predicates"):
        vocabulary.predicate(item)
    actions = [s for s in sections if s.head == ":action"]
    if not vocabulary.conditions or not actions:
        raise source.fault("E090", "a domain needs :predicates and at least one :action", group)
    templates = {t.name: t for action in actions for t in templates_of(vocabulary, action)}
    keys = vocabulary.types
    return Library(
        mangled(title_of(group), ()),
        {keys[k]: None if p is None else keys[p] for k, p in vocabulary.parents.items()},
        {c.name: c for c in vocabulary.conditions.values()},
        (),
        templates,
        {name: keys[type_] for name, type_ in vocabulary.constants.values()},
        source.name,
    )


def _check_requirements(source: Source, words: Iterator[Item]) -> None:
    for word in words:
        if not isinstance(word, Word) or word.key not in _SUPPORTED | _REFUSED_WHERE_USED:
            shown = word.text if isinstance(word, Word) else "(...)"
            hint = f"supported: {', '.join(sorted(_SUPPORTED))}; remove it where the domain does not use it"
            raise source.fault("E091", f"the requirement `{shown}` is not supported", word, hint)


def _sections(source: Source, group: Group) -> Iterator[Group]:
    for item in group.items[2:]:
        if not isinstance(item, Group) or not item.head.startswith(":"):
            raise source.fault("E090", "expected a section, as (:action ...)", item)
        if item.head not in _SECTIONS:
            close = nearest(item.head, _SECTIONS)
            hint = f"did you mean {close[0]}?" if close else "only STRIPS domains can be imported"
            raise source.fault("E092", f"`{item.head}` is not supported", item, hint)
        yield item


def _all_of(sections: list[Group], head: str) -> Iterator[Item]:
    for section in sections:
        if section.head == head:
            yield from section.items[1:]
