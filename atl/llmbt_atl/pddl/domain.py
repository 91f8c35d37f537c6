"""A PDDL domain as a library: STRIPS with typing, negative preconditions and equality.

McDermott et al., "PDDL - the planning domain definition language", 1998; Fox and Long, JAIR 20 (2003), for the syntax.
A parameter of type `(either a b)` makes one template for each; action costs are read over. Preconditions become
start-conditions: PDDL's actions have no duration.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product

from llmbt_atl.library import Library
from llmbt_atl.pddl.invariants import with_invariants
from llmbt_atl.pddl.names import mangled, words_of
from llmbt_atl.pddl.reader import Group, Item, Source, Word, read, title_of
from llmbt_atl.template import ConditionType, Param, Pattern, Template
from llmbt_ir.diagnostics import LlmbtError, nearest

__all__ = ["OBJECT", "import_domain", "typed"]

OBJECT = "object"
_SUPPORTED = frozenset({":strips", ":typing", ":negative-preconditions", ":equality", ":action-costs"})
_SECTIONS = frozenset({":requirements", ":types", ":constants", ":predicates", ":functions", ":action"})
_CONNECTIVES = {
    "or": "a disjunction",
    "imply": "an implication",
    "forall": "a quantifier",
    "exists": "a quantifier",
    "when": "a conditional effect",
    **dict.fromkeys((">", "<", ">=", "<=", "assign", "scale-up", "scale-down", "increase", "decrease"), "a fluent"),
    **dict.fromkeys(("at start", "at end", "over all", "at", "over"), ""),
}


def import_domain(text: str, source: str) -> Library:
    """The library of a PDDL domain, with the state variables that can be shown to be invariants.

    Errors: E090 not PDDL, E091 a requirement and E092 a construct that is not supported, E093 an unknown name,
    E094 a name declared twice, E095 wrong arguments.
    """
    where, group = read(text, source, "domain")
    return with_invariants(_Domain(where, group).library())


def typed(source: Source, items: Iterable[Item]) -> Iterator[tuple[Word, tuple[Word, ...]]]:
    """The names of a typed list, each with its type, or with several for `either`; none where it has no type."""
    pending: list[Word] = []
    stream = iter(items)
    for item in stream:
        if isinstance(item, Group):
            raise source.fault("E090", "expected a name and not a list", item)
        if item.text != "-":
            pending.append(item)
            continue
        type_ = next(stream, None)
        if type_ is None or not pending:
            raise source.fault("E090", "`-` stands between names and their type", item)
        if isinstance(type_, Word):
            types: tuple[Word, ...] = (type_,)
        elif type_.head == "either":
            types = tuple(t for t in type_.items[1:] if isinstance(t, Word))
        else:
            raise source.fault("E090", "expected a type", type_, "write (either a b) for a choice")
        for name in pending:
            yield name, types
        pending = []
    for name in pending:
        yield name, ()


@dataclass(frozen=True, slots=True)
class _Literal:
    word: Word
    args: tuple[Word, ...]
    negated: bool


class _Domain:
    """Reads one domain; the tables are keyed by what names are compared by."""

    def __init__(self, source: Source, group: Group) -> None:
        self.source = source
        self.group = group
        self.types: dict[str, str] = {OBJECT: OBJECT}
        self.parents: dict[str, str | None] = {OBJECT: None}
        self.constants: dict[str, tuple[str, str]] = {}
        self.conditions: dict[str, ConditionType] = {}
        self.templates: dict[str, Template] = {}

    # -- declarations ------------------------------------------------------------------------------

    def library(self) -> Library:
        sections = list(self.sections())
        for word in self.all_of(sections, ":requirements"):
            if not isinstance(word, Word) or word.key not in _SUPPORTED:
                shown = word.text if isinstance(word, Word) else "(...)"
                raise self.source.fault(
                    "E091",
                    f"the requirement `{shown}` is not supported",
                    word,
                    f"supported: {', '.join(sorted(_SUPPORTED))}; remove it where the domain does not use it",
                )
        self.read_types(list(self.all_of(sections, ":types")))
        for name, types in typed(self.source, self.all_of(sections, ":constants")):
            self.once(self.constants, name, "constant")
            self.constants[name.key] = (name.text, self.common(self.types_of(types)))
        for item in self.all_of(sections, ":predicates"):
            self.predicate(item)
        actions = [s for s in sections if s.head == ":action"]
        if not self.conditions or not actions:
            raise self.source.fault("E090", "a domain needs :predicates and at least one :action", self.group)
        for section in actions:
            self.action(section)
        return Library(
            mangled(title_of(self.group), ()),
            {self.types[k]: None if p is None else self.types[p] for k, p in self.parents.items()},
            {c.name: c for c in self.conditions.values()},
            (),
            self.templates,
            dict(self.constants.values()),
            self.source.name,
        )

    def sections(self) -> Iterator[Group]:
        for item in self.group.items[2:]:
            if not isinstance(item, Group) or not item.head.startswith(":"):
                raise self.source.fault("E090", "expected a section, as (:action ...)", item)
            if item.head not in _SECTIONS:
                close = nearest(item.head, _SECTIONS)
                raise self.source.fault(
                    "E092",
                    f"`{item.head}` is not supported",
                    item,
                    f"did you mean {close[0]}?" if close else "only STRIPS domains can be imported",
                )
            yield item

    @staticmethod
    def all_of(sections: list[Group], head: str) -> Iterator[Item]:
        for section in sections:
            if section.head == head:
                yield from section.items[1:]

    def once(self, table: Mapping[str, object], name: Word, what: str) -> None:
        if name.key in table:
            raise self.source.fault("E094", f"{what} `{name.text}` is declared twice", name)

    def read_types(self, items: list[Item]) -> None:
        pairs = list(typed(self.source, items))
        for name, _ in pairs:
            if name.key != OBJECT:
                self.once(self.types, name, "type")
                self.types[name.key] = mangled(name.text, ())
                self.parents[name.key] = OBJECT
        for name, types in pairs:
            for type_ in types:  # published domains do not always declare the uppermost ones
                if type_.key not in self.types:
                    self.types[type_.key] = mangled(type_.text, ())
                    self.parents[type_.key] = OBJECT
            if name.key == OBJECT:
                continue
            if len(types) > 1:
                raise self.source.fault("E092", "a type with several supertypes is not supported", name)
            if types:
                self.parents[name.key] = types[0].key
        for name, _ in pairs:
            seen: set[str] = set()
            here: str | None = name.key
            while here is not None:
                if here in seen:
                    raise self.source.fault("E094", f"type `{name.text}` is its own supertype", name)
                seen.add(here)
                here = self.parents[here]

    def types_of(self, words: tuple[Word, ...]) -> tuple[str, ...]:
        for word in words:
            if word.key not in self.types:
                raise self.unknown("type", word, (self.types[k] for k in self.types))
        return tuple(w.key for w in words) or (OBJECT,)

    def unknown(self, what: str, word: Word, known: Iterable[str]) -> LlmbtError:
        close = nearest(word.text, known)
        return self.source.fault(
            "E093", f"unknown {what} `{word.text}`", word, f"did you mean {', '.join(close)}?" if close else ""
        )

    def above(self, type_: str) -> list[str]:
        found = [type_]
        while (parent := self.parents[found[-1]]) is not None:
            found.append(parent)
        return found

    def common(self, types: Iterable[str]) -> str:
        """The nearest type above all."""
        first, *others = types
        return next(t for t in self.above(first) if all(t in self.above(o) for o in others))

    def predicate(self, item: Item) -> None:
        if not isinstance(item, Group) or not item.items or not isinstance(item.items[0], Word):
            raise self.source.fault("E090", "expected a predicate, as (on ?x ?y)", item)
        name = item.items[0]
        self.once(self.conditions, name, "predicate")
        params: dict[str, Param] = {}
        for word, types in typed(self.source, item.items[1:]):
            own = mangled(word.text.lstrip("?"), params, parameter=True)
            params[own] = Param(own, self.types[self.common(self.types_of(types))])
        taken = [c.name for c in self.conditions.values()]
        self.conditions[name.key] = ConditionType(
            mangled(name.text, taken), tuple(params.values()), True, words_of(name.text, params), item.line
        )

    # -- actions -----------------------------------------------------------------------------------

    def action(self, group: Group) -> None:
        name = group.items[1] if len(group.items) > 1 else None
        if not isinstance(name, Word):
            raise self.source.fault("E090", "an :action needs a name", group)
        fields: dict[str, Item] = {}
        rest = group.items[2:]
        for key, value in zip(rest[::2], rest[1::2], strict=False):
            if not isinstance(key, Word) or key.key not in (":parameters", ":precondition", ":effect"):
                raise self.source.fault(
                    "E092", "not a part of a STRIPS action", key, ":parameters, :precondition, :effect"
                )
            fields[key.key] = value
        if len(rest) % 2:
            raise self.source.fault("E090", "this part of the action has no value", rest[-1])
        listed = fields.get(":parameters")
        params = list(typed(self.source, listed.items)) if isinstance(listed, Group) else []
        own: dict[str, str] = {}
        for word, _ in params:
            if not word.text.startswith("?"):
                raise self.source.fault("E090", f"a parameter begins with `?`: `?{word.text}`", word)
            self.once(own, word, "parameter")
            own[word.key] = mangled(word.text[1:], own.values(), parameter=True)
        choices = [self.types_of(types) for _, types in params]
        used: dict[str, str] = {w.key: self.common(c) for (w, _), c in zip(params, choices, strict=True)}
        unequal: list[tuple[str, str]] = []
        pre = list(self.literals(fields.get(":precondition"), used, unequal))
        effect = list(self.literals(fields.get(":effect"), used, None))
        if ":effect" not in fields or not effect:
            raise self.source.fault("E090", f"the action `{name.text}` has no effect", group)
        start = self.patterns(pre, own)
        add = self.patterns((e for e in effect if not e.negated), own)
        delete = self.patterns((_Literal(e.word, e.args, False) for e in effect if e.negated), own)
        for types in product(*choices):
            taken = [*self.templates, *(c.name for c in self.conditions.values())]
            suffix = "".join(f"__{self.types[t]}" for t, c in zip(types, choices, strict=True) if len(c) > 1)
            template = Template(
                mangled(name.text + suffix, taken),
                tuple(Param(n, self.types[t]) for n, t in zip(own.values(), types, strict=True)),
                start,
                (),
                add,
                tuple(d for d in delete if d not in add),
                tuple((own[a], own[b]) for a, b in unequal),
                (),
                words_of(name.text, own.values()),
                group.line,
            )
            self.templates[template.name] = template

    def literals(
        self, item: Item | None, used: dict[str, str], unequal: list[tuple[str, str]] | None
    ) -> Iterator[_Literal]:
        """The literals of a conjunction; inequalities of parameters are put on `unequal` (None: not allowed)."""
        if item is None or (isinstance(item, Group) and not item.items):
            return
        if not isinstance(item, Group):
            raise self.source.fault("E090", "expected a condition in parentheses", item)
        if item.head == "and":
            for part in item.items[1:]:
                yield from self.literals(part, used, unequal)
            return
        if item.head == "increase" and unequal is None:
            return  # action costs
        negated = item.head == "not"
        inner: Item = item
        if negated:
            if len(item.items) != 2:
                raise self.source.fault("E090", "`not` takes one condition", item)
            inner = item.items[1]
        if not isinstance(inner, Group) or not inner.items or not isinstance(inner.items[0], Word):
            raise self.source.fault("E090", "expected a condition, as (on ?x ?y)", inner)
        word = inner.items[0]
        args = inner.items[1:]
        if word.key == "=":
            self.equality(inner, args, negated, used, unequal)
            return
        if word.key not in self.conditions:
            self.refuse(word, inner)
        declared = self.conditions[word.key]
        if len(args) != len(declared.params) or not all(isinstance(a, Word) for a in args):
            raise self.source.fault(
                "E095", f"`{word.text}` takes {len(declared.params)} arguments and not {len(args)}", inner
            )
        words = tuple(a for a in args if isinstance(a, Word))
        self.widen(declared, word, words, used)
        yield _Literal(word, words, negated)

    def refuse(self, word: Word, group: Group) -> None:
        if word.key in ("and", "not"):
            raise self.source.fault(
                "E092", f"`not` of `{word.text}` is not supported", group, "negate single predicates"
            )
        if word.key in _CONNECTIVES:
            what = _CONNECTIVES[word.key] or "time"
            raise self.source.fault(
                "E092",
                f"`{word.text}` ({what}) is not supported",
                group,
                "only conjunctions of (negated) predicates can be imported: split the action, or compile the "
                "construct away",
            )
        raise self.unknown("predicate", word, (c.words.split()[0] for c in self.conditions.values()))

    def equality(
        self,
        at: Group,
        args: tuple[Item, ...],
        negated: bool,
        used: dict[str, str],
        unequal: list[tuple[str, str]] | None,
    ) -> None:
        pair = [a.key for a in args if isinstance(a, Word)]
        for a in args:
            if isinstance(a, Word) and a.key.startswith("?") and a.key not in used:
                raise self.unknown("parameter", a, used)
        if unequal is None or not negated or len(pair) != 2 or not all(p in used for p in pair):
            raise self.source.fault(
                "E092",
                "only (not (= ?x ?y)) of two parameters in a precondition is supported",
                at,
                "for (= ?x ?y) use one parameter; for a constant declare a predicate that names it",
            )
        unequal.append((pair[0], pair[1]))

    def widen(self, declared: ConditionType, word: Word, args: tuple[Word, ...], used: dict[str, str]) -> None:
        """Check the arguments; where an argument's type is not below the declared one, declare the one above both:
        planners do not look at the types of predicates."""
        params = list(declared.params)
        keys = {name: key for key, name in self.types.items()}
        for i, a in enumerate(args):
            if a.key.startswith("?"):
                if a.key not in used:
                    raise self.unknown("parameter", a, used)
                type_ = used[a.key]
            elif a.key in self.constants:
                type_ = self.constants[a.key][1]
            else:
                raise self.unknown("constant", a, (n for n, _ in self.constants.values()))
            wanted = keys[params[i].type]
            if wanted not in self.above(type_):
                params[i] = Param(params[i].name, self.types[self.common((wanted, type_))])
        if tuple(params) != declared.params:
            self.conditions[word.key] = ConditionType(declared.name, tuple(params), True, declared.words, declared.line)

    def patterns(self, literals: Iterable[_Literal], own: dict[str, str]) -> tuple[Pattern, ...]:
        return tuple(
            dict.fromkeys(
                Pattern(
                    self.conditions[e.word.key].name,
                    tuple(f"{{{own[a.key]}}}" if a.key in own else self.constants[a.key][0] for a in e.args),
                    e.negated,
                    e.word.line,
                )
                for e in literals
            )
        )
