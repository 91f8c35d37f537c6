"""A PDDL action as templates: one for each way in which its precondition can hold and its parameters can be typed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import product

from llmbt_atl.pddl.formula import Things, alternatives
from llmbt_atl.pddl.names import EQUAL, mangled, words_of
from llmbt_atl.pddl.reader import Group, Item, Word
from llmbt_atl.pddl.vocabulary import Vocabulary, typed
from llmbt_atl.template import Param, Pattern, Template
from llmbt_ir.diagnostics import LlmbtError

__all__ = ["templates_of"]

_REFUSED = {
    "forall": "a quantifier",
    "exists": "a quantifier",
    "when": "a conditional effect",
    **dict.fromkeys((">", "<", ">=", "<=", "assign", "scale-up", "scale-down", "increase", "decrease"), "a fluent"),
    **dict.fromkeys(("at start", "at end", "over all", "at", "over"), "time"),
}


@dataclass(frozen=True, slots=True)
class _Literal:
    """A condition over the keys of parameters and constants; without a name, two parameters that must differ."""

    condition: str
    args: tuple[str, ...]
    negated: bool
    line: int = field(default=0, compare=False)


def templates_of(vocabulary: Vocabulary, group: Group) -> Iterator[Template]:
    """The templates of an `(:action ...)`. E090, E092-E095."""
    return _Action(vocabulary, group).templates()


class _Action:
    def __init__(self, vocabulary: Vocabulary, group: Group) -> None:
        self.vocabulary, self.source, self.group = vocabulary, vocabulary.source, group
        name = group.items[1] if len(group.items) > 1 else None
        if not isinstance(name, Word):
            raise self.source.fault("E090", "an :action needs a name", group)
        vocabulary.once(vocabulary.actions, name, "action")
        vocabulary.actions[name.key] = []
        self.name = name
        self.parts = self._parts(group)
        listed = self.parts.get(":parameters")
        params = list(typed(self.source, listed.items)) if isinstance(listed, Group) else []
        self.own: dict[str, str] = {}
        for word, _ in params:
            if not word.text.startswith("?"):
                raise self.source.fault("E090", f"a parameter begins with `?`: `?{word.text}`", word)
            vocabulary.once(self.own, word, "parameter")
            self.own[word.key] = mangled(word.text[1:], self.own.values(), parameter=True)
        self.choices = [vocabulary.types_of(types) for _, types in params]
        self.types = {w.key: vocabulary.common(c) for (w, _), c in zip(params, self.choices, strict=True)}

    def _parts(self, group: Group) -> dict[str, Item]:
        rest = group.items[2:]
        found: dict[str, Item] = {}
        for key, value in zip(rest[::2], rest[1::2], strict=False):
            if not isinstance(key, Word) or key.key not in (":parameters", ":precondition", ":effect"):
                raise self.source.fault(
                    "E092", "not a part of a STRIPS action", key, ":parameters, :precondition, :effect"
                )
            if key.key in found:
                raise self.source.fault("E094", f"`{key.text}` is there twice", key)
            found[key.key] = value
        if len(rest) % 2:
            raise self.source.fault("E090", "this part of the action has no value", rest[-1])
        return found

    def templates(self) -> Iterator[Template]:
        """One for each alternative of the precondition and each choice of types."""
        effects = list(self.effects(self.parts.get(":effect")))
        if not effects:
            raise self.source.fault("E090", f"the action `{self.name.text}` has no effect", self.group)
        wanted = self.parts.get(":precondition")
        ways = ((),) if wanted is None else alternatives(self.source, wanted, self.literal)
        add = self.patterns(e for e in effects if not e.negated)
        delete = self.patterns(replace(e, negated=False) for e in effects if e.negated)
        for k, way in enumerate(ways, 1):
            if any(_contrary(a, b) for a in way for b in way):
                continue
            for types in product(*self.choices):
                typed_as = [self.vocabulary.types[t] for t in types]
                suffix = [t for t, c in zip(typed_as, self.choices, strict=True) if len(c) > 1]
                suffix += [str(k)] if len(ways) > 1 else []
                name = mangled("__".join((self.name.text, *suffix)), self.vocabulary.taken())
                self.vocabulary.actions[self.name.key].append(name)
                yield Template(
                    name,
                    tuple(Param(n, t) for n, t in zip(self.own.values(), typed_as, strict=True)),
                    self.patterns(c for c in way if c.condition),
                    (),
                    add,
                    tuple(d for d in delete if d not in add),
                    tuple((self.own[c.args[0]], self.own[c.args[1]]) for c in way if not c.condition),
                    (),
                    words_of(self.name.text, self.own.values()),
                    self.group.line,
                )

    def effects(self, item: Item | None) -> Iterator[_Literal]:
        """The literals of an effect; action costs are read over."""
        if item is None or (isinstance(item, Group) and not item.items):
            return
        if not isinstance(item, Group):
            raise self.source.fault("E090", "expected an effect in parentheses", item)
        if item.head == "and":
            for part in item.items[1:]:
                yield from self.effects(part)
        elif item.head == "increase":
            return
        elif item.head == "not":
            inner = item.items[1] if len(item.items) == 2 else None
            if not isinstance(inner, Group):
                raise self.source.fault("E090", "`not` takes one condition", item)
            yield self.atom(inner, True)
        else:
            yield self.atom(item, False)

    def literal(self, group: Group, negated: bool, _: Things) -> _Literal | bool:
        """An atom of the precondition; an equality of constants is decided here."""
        if group.head != EQUAL:
            return self.atom(group, negated)
        pair = [a for a in group.items[1:] if isinstance(a, Word)]
        if len(pair) != 2 or len(group.items) != 3:
            raise self.source.fault("E095", "`=` takes 2 arguments", group)
        for a in pair:
            if a.key not in self.own and a.key not in self.vocabulary.constants:
                raise self.unknown(a)
        first, second = sorted(pair, key=lambda a: a.key not in self.own)
        if first.key not in self.own:
            return (first.key == second.key) != negated
        if first.key == second.key:
            return not negated
        if second.key not in self.own:
            return _Literal(self.vocabulary.is_constant(second.key).name, (first.key,), negated, group.line)
        name = "" if negated else self.vocabulary.same().name
        return _Literal(name, (first.key, second.key), False, group.line)

    def atom(self, group: Group, negated: bool) -> _Literal:
        """A predicate over parameters and constants."""
        if not group.items or not isinstance(group.items[0], Word):
            raise self.source.fault("E090", "expected a condition, as (on ?x ?y)", group)
        word, args = group.items[0], group.items[1:]
        declared = self.vocabulary.conditions.get(word.key)
        if declared is None:
            raise self.refused(word, group)
        words = tuple(a for a in args if isinstance(a, Word))
        if len(args) != len(declared.params) or len(words) != len(args):
            raise self.source.fault(
                "E095", f"`{word.text}` takes {len(declared.params)} arguments and not {len(args)}", group
            )
        self.vocabulary.widen(declared, word, words, self.types)
        return _Literal(declared.name, tuple(w.key for w in words), negated, word.line)

    def unknown(self, word: Word) -> LlmbtError:
        if word.key.startswith("?"):
            return self.vocabulary.unknown("parameter", word, self.own)
        return self.vocabulary.unknown("constant", word, (n for n, _ in self.vocabulary.constants.values()))

    def refused(self, word: Word, group: Group) -> LlmbtError:
        known = self.vocabulary.conditions.values()
        if word.key in ("and", "or", "not", "imply", EQUAL):
            return self.source.fault("E092", f"`{word.text}` cannot be an effect", group)
        if word.key in _REFUSED:
            title = f"`{word.text}` ({_REFUSED[word.key]}) is not supported"
            return self.source.fault("E092", title, group, "split the action, or compile the construct away")
        return self.vocabulary.unknown("predicate", word, (c.words.split()[0] for c in known))

    def patterns(self, literals: Iterable[_Literal]) -> tuple[Pattern, ...]:
        constants = self.vocabulary.constants
        return tuple(
            dict.fromkeys(
                Pattern(
                    c.condition,
                    tuple(f"{{{self.own[a]}}}" if a in self.own else constants[a][0] for a in c.args),
                    c.negated,
                    c.line,
                )
                for c in literals
            )
        )


def _contrary(a: _Literal, b: _Literal) -> bool:
    return a.condition == b.condition != "" and a.args == b.args and a.negated != b.negated
