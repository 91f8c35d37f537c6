"""Compiling a domain to numbers, once for each.

The actions are exactly those of `Domain.actions`, in the same order (a test holds the two against each other),
but what variables and containment imply is looked up by number, so that thousands of actions take milliseconds.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice, product
from math import prod

from llmbt_atl.state import Domain
from llmbt_atl.template import ANY, Pattern, Template
from llmbt_ir.condition import Condition, Facts
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
from llmbt_runtime.search.task import Op, Task

__all__ = ["MAX_BINDINGS", "task_of"]

MAX_BINDINGS = 1_000_000
"""Of all templates together. So many actions take half a minute and a gigabyte to write out."""

_KEY = "_llmbt_search_task"
_Fact = tuple[int, ...]
"""The number of a condition, or of a state variable, then those of things."""


def task_of(domain: Domain, facts: Facts = frozenset()) -> Task:
    """The compiled task of a domain, made once for each domain object.

    Where `facts` has things or lasting facts that the domain does not know, the domain for them is used. E096 where
    there are more than `MAX_BINDINGS` ways to bind the templates' parameters.
    """
    if any(f.name in domain._never_added and f not in domain.fixed for f in facts) or any(
        a not in domain.types for f in facts for a in f.args
    ):
        domain = domain.for_state(facts | domain.fixed)
    cache = vars(domain)
    task = cache.get(_KEY)
    if task is None:
        task = cache[_KEY] = _Compiler(domain).task()
    assert isinstance(task, Task)
    return task


class _Compiler:
    """Grounds templates by number. Tables are keyed by fact: (condition, thing, thing, ...)."""

    def __init__(self, domain: Domain) -> None:
        self.domain = domain
        library = domain.library
        self.things = sorted(domain.types)
        self.thing = {t: i for i, t in enumerate(self.things)}
        self.names = list(library.conditions)
        self.name = {n: i for i, n in enumerate(self.names)}
        fits: dict[str, frozenset[int]] = {}
        for type_ in library.types:
            fits[type_] = frozenset(self.thing[t] for t in domain.by_type.get(type_, ()))
        self.fits = fits
        self.param_fits = [tuple(fits[p.type] for p in library.conditions[n].params) for n in self.names]
        self.upward_at = [tuple(i for i, p in enumerate(library.conditions[n].params) if p.upward) for n in self.names]
        self.outer = [tuple(self.thing[c] for c in domain.containers(t) if c in self.thing) for t in self.things]
        inner: list[list[int]] = [[] for _ in self.things]
        for place in domain.parents:
            for o in domain.containers(place):
                if o in self.thing and place in self.thing:
                    inner[self.thing[o]].append(self.thing[place])
        self.inner = inner
        self.depth = [len(o) for o in self.outer]
        self.number: dict[_Fact, int] = {}
        self.lookup: dict[_Fact, int] = {}
        self.facts: list[_Fact] = []
        self.upward: list[tuple[int, ...]] = []
        self.keys: list[tuple[_Fact, ...]] = []
        self.family: dict[int, tuple[int, ...]] = {}
        self.rest: dict[tuple[int, _Fact], tuple[int, ...]] = {}
        self.left = MAX_BINDINGS
        self.values: dict[int, list[tuple[int, tuple[int, ...]]]] = {}
        for v, variable in enumerate(library.variables):
            for value in variable.values:
                at = {a[1:-1]: i for i, a in enumerate(value.args) if a.startswith("{")}
                self.values.setdefault(self.name[value.name], []).append(
                    (v, tuple(at[p.name] for p in variable.params))
                )

    # -- what follows from one fact ----------------------------------------------------------------

    def typed_number(self, fact: _Fact) -> int:
        """The number of a fact, -1 where an argument is not of the declared type."""
        pools = self.param_fits[fact[0]]
        fits = all(a in pool for a, pool in zip(fact[1:], pools, strict=True))
        known = self.lookup[fact] = self.fact_number(fact) if fits else -1
        return known

    def fact_number(self, fact: _Fact) -> int:
        """The number of a fact, with what it implies and the variables of which it is a value."""
        known = self.number.get(fact)
        if known is None:
            known = self.number[fact] = len(self.facts)
            self.facts.append(fact)
            self.keys.append(self.variables_of(fact))
            self.upward.append((known,))
            above = [known]
            for i in self.upward_at[fact[0]]:
                above += [self.fact_number((*fact[: i + 1], o, *fact[i + 2 :])) for o in self.outer[fact[i + 1]]]
            self.upward[known] = tuple(above)
        return known

    def related(self, number: int) -> tuple[int, ...]:
        """A fact with what it implies and what implies it."""
        known = self.family.get(number)
        if known is None:
            fact = self.facts[number]
            found = list(self.upward[number])
            for i in self.upward_at[fact[0]]:
                found += [self.fact_number((*fact[: i + 1], o, *fact[i + 2 :])) for o in self.inner[fact[i + 1]]]
            known = self.family[number] = tuple(found)
        return known

    def variables_of(self, fact: _Fact) -> tuple[_Fact, ...]:
        found = []
        for v, at in self.values.get(fact[0], ()):
            key = tuple([fact[i + 1] for i in at])
            params = self.domain.library.variables[v].params
            if all(k in self.fits[p.type] for k, p in zip(key, params, strict=True)):
                found.append((v, *key))
        return tuple(found)

    def together(self, a: _Fact, b: _Fact) -> bool:
        if a[0] != b[0]:
            return False
        upward = self.upward_at[a[0]]
        return all(
            x == y or (i in upward and (y in self.outer[x] or x in self.outer[y]))
            for i, (x, y) in enumerate(zip(a[1:], b[1:], strict=True))
        )

    def others(self, number: int, key: _Fact) -> tuple[int, ...]:
        """All other values of a variable."""
        known = self.rest.get((number, key))
        if known is None:
            fact = self.facts[number]
            library = self.domain.library
            variable = library.variables[key[0]]
            binding = dict(zip((p.name for p in variable.params), key[1:], strict=True))
            found = []
            for value in variable.values:
                pools: list[Iterable[int]] = []
                for a, p in zip(value.args, library.conditions[value.name].params, strict=True):
                    if a == ANY:
                        pools.append(self.thing[t] for t in self.domain.by_type.get(p.type, ()))
                    else:
                        pools.append((binding[a[1:-1]],))
                for args in product(*pools):
                    other = (self.name[value.name], *args)
                    if not self.together(fact, other):
                        found.append(self.fact_number(other))
            known = self.rest[number, key] = tuple(found)
        return known

    # -- actions -----------------------------------------------------------------------------------

    def task(self) -> Task:
        ops = tuple(op for t in self.domain.library.templates.values() for op in self.template(t))
        mentioned = range(len(self.facts))
        related = {i: frozenset(self.related(i)) for i in mentioned if self.upward_at[self.facts[i][0]]}
        things, names = self.things, self.names
        facts = tuple([Condition(names[f[0]], tuple([things[a] for a in f[1:]])) for f in self.facts])
        keys = tuple(k if len(self.upward_at[f[0]]) < 2 else () for f, k in zip(self.facts, self.keys, strict=True))
        return Task(self.domain, facts, {f: i for i, f in enumerate(facts)}, ops, keys, related)

    def template(self, template: Template) -> Iterator[Op]:
        names = [p.name for p in template.params]
        at = {n: i for i, n in enumerate(names)}

        def compiled(patterns: Iterable[Pattern]) -> list[tuple[int, tuple[int, ...], bool]]:
            """Condition number, and for each argument the parameter's place or ~constant."""
            return [
                (
                    self.name[p.name],
                    tuple(at[a[1:-1]] if a.startswith("{") else ~self.thing[a] for a in p.args),
                    p.negated,
                )
                for p in patterns
            ]

        if any(
            not a.startswith("{") and a not in self.thing
            for p in (*template.pre, *template.post, *template.deletes)
            for a in p.args
        ):
            return
        pre_p, post_p, del_p = compiled(template.pre), compiled(template.post), compiled(template.deletes)
        starts = len(template.start)
        innermost = {at[p.name] for p in template.params if p.innermost}
        inmost = [(c, args, i) for c, args, neg in pre_p if not neg for i in self.upward_at[c] if args[i] in innermost]
        unequal = [(at[a], at[b]) for a, b in template.unequal]
        order = 100 * list(self.domain.library.templates).index(template.name)
        lookup, typed = self.lookup, self.typed_number
        upward, keys, depth = self.upward, self.keys, self.depth
        for values in self.bindings(template, unequal):
            pre: list[int] = []
            for c, args, negated in pre_p:
                fact = (c, *[values[a] if a >= 0 else ~a for a in args])
                number = lookup.get(fact)
                if number is None:
                    number = typed(fact)
                if number < 0:
                    break
                pre.append(2 * number + negated)
            else:
                inner: list[int] = []
                for c, args, i in inmost:
                    f = (c, *[values[a] if a >= 0 else ~a for a in args])
                    inner += [
                        2 * self.fact_number((*f[: i + 1], place, *f[i + 2 :])) + 1 for place in self.inner[f[i + 1]]
                    ]
                start, hold = (*pre[:starts], *inner), tuple(pre[starts:])
                literals = dict.fromkeys(start + hold)
                if any(p ^ 1 in literals for p in literals):
                    continue
                post = self.effects(post_p, values)
                adds = {u for f in post for u in upward[f]}
                deletes = set(self.effects(del_p, values))
                if any(keys[f] for f in post):
                    self.ended(post, literals, deletes)
                deletes -= adds
                if not deletes and all(2 * f in literals for f in adds):
                    continue
                yield Op(
                    template.name,
                    tuple([self.things[v] for v in values]),
                    start,
                    hold,
                    tuple(literals),
                    tuple(sorted(adds)),
                    tuple(sorted(deletes)),
                    order - sum([depth[v] for v in values]),
                )

    def effects(self, patterns: list[tuple[int, tuple[int, ...], bool]], values: tuple[int, ...]) -> list[int]:
        """The numbers of the effects; an ill-typed one is void."""
        found = []
        for c, args, _ in patterns:
            fact = (c, *[values[a] if a >= 0 else ~a for a in args])
            number = self.lookup.get(fact)
            if number is None:
                number = self.typed_number(fact)
            if number >= 0:
                found.append(number)
        return found

    def ended(self, post: list[int], literals: Mapping[int, None], deletes: set[int]) -> None:
        """What ends when effects begin: of each of their variables the value in `literals`, or else all others."""
        known: dict[_Fact, list[int]] = {}
        for p in literals:
            if not p & 1:
                for key in self.keys[p >> 1]:
                    known.setdefault(key, []).append(p >> 1)
        for fact in post:
            for key in self.keys[fact]:
                before = [p for p in known.get(key, ()) if p != fact]
                for p in before:
                    deletes.update(self.related(p))
                if not before and 2 * fact not in literals:
                    deletes.update(self.others(fact, key))

    def spend(self, template: Template, bindings: int) -> None:
        """E096 where there are more bindings than are left."""
        self.left = self.left - bindings if bindings <= self.left else -1
        if self.left < 0:
            title = f"there are more than {MAX_BINDINGS:,} ground actions, counted up to `{template.name}`"
            hint = "fewer things, narrower types, or actions of fewer parameters"
            raise LlmbtError(Diagnostic("E096", title, Span(self.domain.library.source, template.line), help=hint))

    def bindings(self, template: Template, unequal: list[tuple[int, int]]) -> Iterator[tuple[int, ...]]:
        """All bindings, preconditions that nothing brings about joined first."""
        domain = self.domain
        at = {p.name: i for i, p in enumerate(template.params)}
        pools = [[self.thing[t] for t in domain.by_type.get(p.type, ())] for p in template.params]
        sets = [frozenset(pool) for pool in pools]
        partial: list[dict[int, int]] = [{}]
        for anchor in template.pre:
            if anchor.negated or anchor.name not in domain._never_added:
                continue
            facts = [tuple(self.thing[a] for a in f.args) for f in domain._fixed_by_name.get(anchor.name, ())]
            slots = [at[a[1:-1]] if a.startswith("{") else ~self.thing[a] for a in anchor.args]
            partial = list(islice(_joined(partial, slots, facts, sets, unequal), MAX_BINDINGS + 1))
            if len(partial) > MAX_BINDINGS:
                self.spend(template, len(partial))
        if partial:
            free = prod(len(pool) for i, pool in enumerate(pools) if i not in partial[0])
            self.spend(template, len(partial) * free)
        for binding in partial:
            for values in product(*([binding[i]] if i in binding else pools[i] for i in range(len(pools)))):
                if unequal and any(values[a] == values[b] for a, b in unequal):
                    continue
                yield values


def _joined(
    partial: list[dict[int, int]],
    slots: list[int],
    facts: list[tuple[int, ...]],
    sets: list[frozenset[int]],
    unequal: list[tuple[int, int]],
) -> Iterator[dict[int, int]]:
    """Partial bindings extended by the facts of one static precondition, by a hash join on what is bound."""
    if not partial:
        return
    bound = [i for i, s in enumerate(slots) if s < 0 or s in partial[0]]
    index: dict[tuple[int, ...], list[tuple[int, ...]]] = {}
    for fact in facts:
        index.setdefault(tuple(fact[i] for i in bound), []).append(fact)
    for binding in partial:
        key = tuple(binding[slots[i]] if slots[i] >= 0 else ~slots[i] for i in bound)
        for fact in index.get(key, ()):
            new = dict(binding)
            if all(
                s < 0 or (new.setdefault(s, v) == v and v in sets[s]) for s, v in zip(slots, fact, strict=True)
            ) and all(a not in new or b not in new or new[a] != new[b] for a, b in unequal):
                yield new
