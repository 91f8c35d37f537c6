"""A library over the things of one scene: ground actions, their exact effects, and what excludes what."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

from llmbt_atl.library import Library
from llmbt_atl.template import ANY, Pattern, Template, Variable
from llmbt_ir.condition import ActionCall, Condition, Facts, holds
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span, nearest

if TYPE_CHECKING:
    from llmbt_ir.semantic_map import SemanticMap

__all__ = ["Domain", "GroundAction", "applicable", "apply", "domain_of"]


@dataclass(frozen=True, slots=True)
class GroundAction:
    """An action over things: what it needs, and exactly what holds and no longer holds afterwards.

    `deletes` and `adds` are disjoint; what state variables and containment imply is spelt out in them. Of one that
    `senses` they are what may be hoped for.
    """

    call: ActionCall
    start: tuple[Condition, ...] = field(compare=False)
    hold: tuple[Condition, ...] = field(compare=False)
    adds: frozenset[Condition] = field(compare=False)
    deletes: frozenset[Condition] = field(compare=False)
    rank: int = field(compare=False, default=0)
    senses: bool = field(compare=False, default=False)

    @property
    def pre(self) -> tuple[Condition, ...]:
        """Pre(a), in the order in which a tree checks it."""
        return self.start + self.hold

    def achieves(self, condition: Condition) -> bool:
        """Whether a literal holds after the action, by the action."""
        return condition.fact in (self.deletes if condition.negated else self.adds)

    def falsifies(self, condition: Condition) -> bool:
        """Whether a literal ceases to hold by the action."""
        return condition.fact in (self.adds if condition.negated else self.deletes)

    def __str__(self) -> str:
        return str(self.call)


def applicable(action: GroundAction, facts: Container[Condition]) -> bool:
    """Whether Pre(a) holds in a state."""
    return all(holds(c, facts) for c in action.pre)


def apply(action: GroundAction, facts: Facts) -> Facts:
    """The state after an action that ran to its end."""
    return (facts - action.deletes) | action.adds


@dataclass(frozen=True)
class Domain:
    """A library over the things of a scene.

    `types` gives each thing's type and `parents` the place that contains a place. `fixed` are the facts of those
    conditions that no template ever brings about: an action that needs another such fact cannot become possible by
    what the robot does, so it is not among `actions`.
    """

    library: Library
    types: Mapping[str, str]
    parents: Mapping[str, str] = field(default_factory=dict)
    fixed: Facts = frozenset()

    def for_state(self, facts: Facts) -> Domain:
        """The domain for what is observed: things not known before get the type their conditions ask for."""
        fixed = frozenset(f for f in facts if f.name in self._never_added)
        new: dict[str, str] = {}
        for fact in facts:
            declared = self.library.conditions.get(fact.name)
            if declared is None:
                continue
            for arg, param in zip(fact.args, declared.params, strict=True):
                if arg not in self.types and (arg not in new or self.library.is_a(param.type, new[arg])):
                    new[arg] = param.type
        if not new and fixed == self.fixed:
            return self
        return replace(self, types={**self.types, **new} if new else self.types, fixed=fixed)

    @cached_property
    def _never_added(self) -> frozenset[str]:
        added = {p.name for t in self.library.templates.values() for p in t.post}
        return frozenset(set(self.library.conditions) - added)

    @cached_property
    def by_type(self) -> Mapping[str, tuple[str, ...]]:
        """The things of each type, subtypes included, sorted with numbers by value."""
        table: dict[str, list[str]] = {t: [] for t in self.library.types}
        for thing, type_ in sorted(self.types.items(), key=lambda kv: _natural(kv[0])):
            here: str | None = type_
            while here is not None:
                table.setdefault(here, []).append(thing)
                here = self.library.types.get(here)
        return {t: tuple(things) for t, things in table.items()}

    def fits(self, thing: str, type_: str) -> bool:
        """Whether a thing is of a type."""
        own = self.types.get(thing)
        return own is not None and self.library.is_a(own, type_)

    def containers(self, place: str) -> Iterator[str]:
        """The places that contain a place, innermost first."""
        here = self.parents.get(place)
        while here is not None:
            yield here
            here = self.parents.get(here)

    def contains(self, outer: str, inner: str) -> bool:
        """Whether `inner` lies within `outer`, at any depth."""
        return outer in self.containers(inner)

    @cached_property
    def _inside(self) -> Mapping[str, tuple[str, ...]]:
        table: defaultdict[str, list[str]] = defaultdict(list)
        for place in self.parents:
            for outer in self.containers(place):
                table[outer].append(place)
        return {k: tuple(v) for k, v in table.items()}

    def upward(self, fact: Condition) -> Iterator[Condition]:
        """A fact and what it implies by containment. What the library does not know implies nothing."""
        yield fact
        declared = self.library.conditions.get(fact.name)
        for i, param in enumerate(declared.params if declared is not None else ()):
            if param.upward:
                for outer in self.containers(fact.args[i]):
                    yield Condition(fact.name, (*fact.args[:i], outer, *fact.args[i + 1 :]))

    def _downward(self, fact: Condition) -> Iterator[Condition]:
        for i, param in enumerate(self.library.conditions[fact.name].params):
            if param.upward:
                for inner in self._inside.get(fact.args[i], ()):
                    yield Condition(fact.name, (*fact.args[:i], inner, *fact.args[i + 1 :]))

    # -- state variables -------------------------------------------------------------------------

    @cached_property
    def _values(self) -> Mapping[str, tuple[tuple[Variable, Pattern], ...]]:
        table: defaultdict[str, list[tuple[Variable, Pattern]]] = defaultdict(list)
        for variable in self.library.variables:
            for value in variable.values:
                table[value.name].append((variable, value))
        return {k: tuple(v) for k, v in table.items()}

    def variables_of(self, fact: Condition) -> Iterator[tuple[Variable, tuple[str, ...]]]:
        """The state variables of which a fact is a value, each with the binding of its parameters."""
        for variable, value in self._values.get(fact.name, ()):
            binding = {v[1:-1]: a for v, a in zip(value.args, fact.args, strict=True) if v.startswith("{")}
            if all(self.fits(binding[p.name], p.type) for p in variable.params):
                yield variable, tuple(binding[p.name] for p in variable.params)

    def _together(self, a: Condition, b: Condition) -> bool:
        """Two values of one variable that hold together: equal but for places of which one contains the other."""
        if a.name != b.name:
            return False
        params = self.library.conditions[a.name].params
        return all(
            x == y or (p.upward and (self.contains(x, y) or self.contains(y, x)))
            for x, y, p in zip(a.args, b.args, params, strict=True)
        )

    def mutex(self, a: Condition, b: Condition) -> bool:
        """Whether two literals can never hold together, by the invariants of the templates."""
        if a.fact == b.fact:
            return a.negated != b.negated
        if a.negated and b.negated:
            return False
        if a.negated or b.negated:
            positive, negative = (b, a) if a.negated else (a, b)
            return negative.fact in self.upward(positive)
        return not self._keys(a).isdisjoint(self._keys(b)) and not self._together(a, b)

    @cached_property
    def _known_keys(self) -> dict[Condition, frozenset[tuple[str, tuple[str, ...]]]]:
        return {}

    def _keys(self, fact: Condition) -> frozenset[tuple[str, tuple[str, ...]]]:
        """`variables_of`, kept: mutexes are asked for again and again."""
        known = self._known_keys.get(fact)
        if known is None:
            known = self._known_keys[fact] = frozenset((v.name, key) for v, key in self.variables_of(fact))
        return known

    def _others(self, fact: Condition, pre: Iterable[Condition]) -> Iterator[Condition]:
        """The facts that end when `fact` begins: of each of its variables the value in `pre`, or else all others."""
        for variable, key in self.variables_of(fact):
            known = [
                p
                for p in pre
                if not p.negated and p != fact and any(v is variable and k == key for v, k in self.variables_of(p))
            ]
            for p in known:
                yield from self.upward(p)
                yield from self._downward(p)
            if known or fact in pre:
                continue
            binding = dict(zip((p.name for p in variable.params), key, strict=True))
            for value in variable.values:
                params = self.library.conditions[value.name].params
                pools = [
                    self.by_type.get(p.type, ()) if a == ANY else (binding[a[1:-1]],)
                    for a, p in zip(value.args, params, strict=True)
                ]
                for args in product(*pools):
                    other = Condition(value.name, args)
                    if not self._together(fact, other):
                        yield other

    # -- actions ---------------------------------------------------------------------------------

    def _effect(self, pattern: Pattern, binding: Mapping[str, str]) -> Condition | None:
        """The ground effect, or None where an argument is not of the condition's declared type."""
        fact = pattern.bind(binding)
        params = self.library.conditions[pattern.name].params
        return fact if all(self.fits(a, p.type) for a, p in zip(fact.args, params, strict=True)) else None

    def ground(self, template: Template, binding: Mapping[str, str], rank: int = 0) -> GroundAction | None:
        """A template over things, or None where no such action exists: a precondition is ill-typed, or the effects
        add nothing that the preconditions do not already say."""
        start = [self._effect(p, binding) for p in template.start]
        hold = [self._effect(p, binding) for p in template.hold]
        if None in start or None in hold:
            return None
        s, h = tuple(c for c in start if c), tuple(c for c in hold if c)
        s += tuple(self._inner(template, binding))
        post = [f for p in template.post if (f := self._effect(p, binding))]
        adds = frozenset(u for f in post for u in self.upward(f))
        pre = s + h
        positive = {c for c in pre if not c.negated}
        if any(~c in pre for c in pre):
            return None
        deletes = {f for p in template.deletes if (f := self._effect(p, binding))}
        for fact in post:
            deletes.update(self._others(fact, pre))
        call = ActionCall(template.name, tuple(binding[p.name] for p in template.params))
        gone = frozenset(deletes - adds)
        if adds <= positive and not gone:
            return None
        return GroundAction(call, s, h, adds, gone, rank, template.senses)

    def _inner(self, template: Template, binding: Mapping[str, str]) -> Iterator[Condition]:
        """What must not hold so that an `innermost` parameter stands for the most specific place."""
        innermost = {f"{{{p.name}}}" for p in template.params if p.innermost}
        for pattern in template.pre if innermost else ():
            for arg, param in zip(pattern.args, self.library.conditions[pattern.name].params, strict=True):
                if arg in innermost and param.upward and not pattern.negated:
                    yield from (~c for c in self._downward(pattern.bind(binding)))

    def _bindings(self, template: Template, fixed: Mapping[str, str]) -> Iterator[dict[str, str]]:
        """All bindings of a template's parameters that extend `fixed`, in a fixed order."""
        types = {p.name: p.type for p in template.params}
        if not all(self.fits(v, types[k]) for k, v in fixed.items()):
            return
        anchors = [p for p in template.pre if not p.negated and p.name in self._never_added]
        partial: list[dict[str, str]] = [dict(fixed)]
        for anchor in anchors:
            grown: list[dict[str, str]] = []
            for binding in partial:
                matches = (_match(anchor, fact, binding) for fact in self._fixed_by_name.get(anchor.name, ()))
                grown += [m for m in matches if m is not None and all(self.fits(v, types[k]) for k, v in m.items())]
            partial = grown
        for binding in partial:
            free = [p.name for p in template.params if p.name not in binding]
            for values in product(*(self.by_type.get(types[p], ()) for p in free)):
                full = {**binding, **dict(zip(free, values, strict=True))}
                if all(full[a] != full[b] for a, b in template.unequal):
                    yield full

    @cached_property
    def _fixed_by_name(self) -> Mapping[str, tuple[Condition, ...]]:
        table: defaultdict[str, list[Condition]] = defaultdict(list)
        for fact in sorted(self.fixed):
            table[fact.name].append(fact)
        return {k: tuple(v) for k, v in table.items()}

    def _rank(self, template: Template, binding: Mapping[str, str]) -> int:
        """Among equally good actions: templates in the file's order, and the most specific places first."""
        order = list(self.library.templates).index(template.name)
        depth = sum(len(tuple(self.containers(v))) for v in binding.values())
        return order * 100 - depth

    @cached_property
    def actions(self) -> tuple[GroundAction, ...]:
        """Every ground action, in a fixed order, each once."""
        return tuple(
            a
            for t in self.library.templates.values()
            for b in self._bindings(t, {})
            if (a := self.ground(t, b, self._rank(t, b))) is not None
        )

    @cached_property
    def _grounded(self) -> dict[ActionCall, GroundAction | None]:
        """Ground actions by their calls, as far as they have been asked for."""
        return {}

    def action(self, call: ActionCall) -> GroundAction | None:
        """The ground action of a call; None where the library or the scene has no such thing."""
        if call not in self._grounded:
            self._grounded[call] = self._of_call(call)
        return self._grounded[call]

    def _of_call(self, call: ActionCall) -> GroundAction | None:
        template = self.library.templates.get(call.name)
        if template is None or len(template.params) != len(call.args):
            return None
        binding = {p.name: a for p, a in zip(template.params, call.args, strict=True)}
        if not all(self.fits(binding[p.name], p.type) for p in template.params):
            return None
        return self.ground(template, binding, self._rank(template, binding))

    def _adding(self, fact: Condition) -> Iterator[GroundAction]:
        """The actions that add a fact, template by template; only their bindings are grounded."""
        sources = (fact, *self._downward(fact))
        for template in self.library.templates.values():
            calls: dict[ActionCall, None] = {}
            for pattern in template.post:
                matches = (_match(pattern, s, {}) for s in sources if s.name == pattern.name)
                for fixed in (m for m in matches if m is not None):
                    for b in self._bindings(template, fixed):
                        calls[ActionCall(template.name, tuple(b[p.name] for p in template.params))] = None
            found = (self.action(call) for call in calls)
            yield from (a for a in found if a is not None and fact in a.adds)

    @cached_property
    def _achievers(self) -> Mapping[Condition, tuple[GroundAction, ...]]:
        """For negated literals; what adds a fact is found without grounding everything."""
        table: defaultdict[Condition, list[GroundAction]] = defaultdict(list)
        for a in self.actions:
            for f in a.deletes:
                table[~f].append(a)
        return {k: tuple(v) for k, v in table.items()}

    def achievers(self, condition: Condition) -> tuple[GroundAction, ...]:
        """The actions after which a literal holds and before which it need not."""
        found = self._achievers.get(condition, ()) if condition.negated else self._adding(condition)
        return tuple(a for a in found if condition not in a.pre)


def _match(pattern: Pattern, fact: Condition, binding: Mapping[str, str]) -> dict[str, str] | None:
    extended = dict(binding)
    for arg, value in zip(pattern.args, fact.args, strict=True):
        if not arg.startswith("{"):
            if arg != value:
                return None
        elif extended.setdefault(arg[1:-1], value) != value:
            return None
    return extended


def _natural(text: str) -> tuple[tuple[int, int, str], ...]:
    """A sort key under which position_2 comes before position_10."""
    parts: list[tuple[int, int, str]] = []
    digits = word = ""
    for ch in text + "\0":
        if ch.isdigit() and ch.isascii():
            if word:
                parts.append((1, 0, word))
                word = ""
            digits += ch
        else:
            if digits:
                parts.append((0, int(digits), ""))
                digits = ""
            word += ch
    parts.append((1, 0, word))
    return tuple(parts)


def domain_of(library: Library, semantic_map: SemanticMap) -> Domain:
    """The domain of a scene's map: its objects and places with their types, and how places contain places.

    A place marked as a buffer has the library's type `buffer` where there is one below its own type. E036 where a thing
    is of a type that the library does not declare.
    """
    faults = []
    entries = [(p.id, p.type, p.line) for p in semantic_map.places]
    entries += [(o.id, o.type, o.line) for o in semantic_map.objects]
    for id_, type_, line in entries:
        if type_ not in library.types:
            close = nearest(type_, library.types)
            title = f"`{id_}` is of type `{type_}`, which library `{library.name}` does not declare"
            hint = f"did you mean {', '.join(close)}?" if close else f"it declares {', '.join(library.types)}"
            span = Span(semantic_map.source, line)
            faults.append(Diagnostic("E036", title, span, help=hint, candidates=close))
    if faults:
        raise LlmbtError(*faults)
    types: dict[str, str] = dict(library.constants)
    for place in semantic_map.places:
        buffer = place.buffer and "buffer" in library.types and library.is_a("buffer", place.type)
        types[place.id] = "buffer" if buffer else place.type
    for thing in semantic_map.objects:
        types[thing.id] = thing.type
    parents = {p.id: p.parent for p in semantic_map.places if p.parent is not None}
    return Domain(library, types, parents)
