"""What a PDDL domain declares: types, constants and predicates, and the names that stand for them in a library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from llmbt_atl.pddl.names import EQUAL, mangled, words_of
from llmbt_atl.pddl.reader import Group, Item, Source, Word
from llmbt_atl.template import ConditionType, Param
from llmbt_ir.diagnostics import LlmbtError, nearest

__all__ = ["OBJECT", "Vocabulary", "thing", "typed"]

OBJECT = "object"


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


def thing(source: Source, word: Word) -> str:
    """The name of an object or constant: kept as it is, but for what a library would take for something else. E090."""
    if word.text == "*" or word.text[0] in "?:":
        raise source.fault("E090", f"`{word.text}` is no name of an object", word)
    return word.text


class Vocabulary:
    """What is declared so far. The tables are keyed by what names are compared by."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.types: dict[str, str] = {OBJECT: OBJECT}
        self.parents: dict[str, str | None] = {OBJECT: None}
        self.constants: dict[str, tuple[str, str]] = {}
        self.conditions: dict[str, ConditionType] = {}
        self.actions: dict[str, list[str]] = {}
        """The names of each action's templates."""

    def taken(self) -> list[str]:
        """The names of conditions and templates."""
        return [*(c.name for c in self.conditions.values()), *(t for names in self.actions.values() for t in names)]

    # -- declarations ------------------------------------------------------------------------------

    def once(self, table: Mapping[str, object], name: Word, what: str) -> None:
        """E094 where a name is in a table already."""
        if name.key in table:
            raise self.source.fault("E094", f"{what} `{name.text}` is declared twice", name)

    def read_types(self, items: list[Item]) -> None:
        """Declare types. E092 several supertypes, E094 a circle."""
        pairs = list(typed(self.source, items))
        for name, _ in pairs:
            if name.key != OBJECT:
                self.once(self.types, name, "type")
                self.declare_type(name)
        for name, types in pairs:
            for type_ in types:  # published domains do not always declare the uppermost ones
                if type_.key not in self.types:
                    self.declare_type(type_)
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

    def declare_type(self, name: Word) -> None:
        """Declare a type below that of all objects. A problem finds it by its mangled name alone, so E094 where
        another one has the same."""
        own = mangled(name.text, ())
        for key, taken in self.types.items():
            if taken.lower() == own.lower():
                raise self.source.fault("E094", f"types `{name.text}` and `{key}` would both be named `{own}`", name)
        self.types[name.key] = own
        self.parents[name.key] = OBJECT

    def constant(self, name: Word, types: tuple[Word, ...]) -> None:
        """Declare a constant."""
        self.once(self.constants, name, "constant")
        self.constants[name.key] = (thing(self.source, name), self.common(self.types_of(types)))

    def predicate(self, item: Item) -> None:
        """Declare a predicate."""
        if not isinstance(item, Group) or not item.items or not isinstance(item.items[0], Word):
            raise self.source.fault("E090", "expected a predicate, as (on ?x ?y)", item)
        name = item.items[0]
        self.once(self.conditions, name, "predicate")
        params: dict[str, Param] = {}
        for word, types in typed(self.source, item.items[1:]):
            own = mangled(word.text.lstrip("?"), params, parameter=True)
            params[own] = Param(own, self.types[self.common(self.types_of(types))])
        self.conditions[name.key] = ConditionType(
            mangled(name.text, self.taken()), tuple(params.values()), True, words_of(name.text, params), item.line
        )

    # -- equality ----------------------------------------------------------------------------------

    def same(self) -> ConditionType:
        """The condition for (= ?x ?y): a fact of each thing and itself."""
        return self._helper("same", (Param("x", OBJECT), Param("y", OBJECT)), f"{EQUAL} {{x}} {{y}}")

    def is_constant(self, key: str) -> ConditionType:
        """The condition for (= ?x c): a fact of the constant alone."""
        name, _ = self.constants[key]
        return self._helper(f"is_{name}", (Param("x", OBJECT),), f"{EQUAL} {{x}} {name}")

    def _helper(self, name: str, params: tuple[Param, ...], words: str) -> ConditionType:
        """A condition that no predicate stands for. Its words tell `import_problem` of what it holds."""
        if words not in self.conditions:
            self.conditions[words] = ConditionType(mangled(name, self.taken()), params, False, words)
        return self.conditions[words]

    # -- types -------------------------------------------------------------------------------------

    def types_of(self, words: tuple[Word, ...]) -> tuple[str, ...]:
        """The keys of types; that of all objects where none is given. E093 an unknown one."""
        for word in words:
            if word.key not in self.types:
                raise self.unknown("type", word, (self.types[k] for k in self.types))
        return tuple(w.key for w in words) or (OBJECT,)

    def above(self, type_: str) -> list[str]:
        """A type and its supertypes."""
        found = [type_]
        while (parent := self.parents[found[-1]]) is not None:
            found.append(parent)
        return found

    def common(self, types: Iterable[str]) -> str:
        """The nearest type above all."""
        first, *others = types
        return next(t for t in self.above(first) if all(t in self.above(o) for o in others))

    def unknown(self, what: str, word: Word, known: Iterable[str]) -> LlmbtError:
        """E093."""
        close = nearest(word.text, known)
        return self.source.fault(
            "E093", f"unknown {what} `{word.text}`", word, f"did you mean {', '.join(close)}?" if close else ""
        )

    def widen(self, declared: ConditionType, word: Word, args: tuple[Word, ...], used: Mapping[str, str]) -> None:
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
