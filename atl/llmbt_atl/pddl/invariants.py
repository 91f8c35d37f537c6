"""State variables of a library with explicit deletes, found as invariants.

Helmert, "Concise finite-domain representations for PDDL planning tasks", Artificial Intelligence 173 (2009), section 5:
a set of predicates, each with some arguments fixed and at most one counted, such that no action makes two of them hold
where one held before. A candidate is checked against every way in which an action's parameters may be the same thing,
so that no instance of an action is forgotten. That at most one holds in the first state is checked for each problem.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import permutations

from llmbt_atl.library import Library
from llmbt_atl.template import ANY, Param, Pattern, Template, Variable

__all__ = ["with_invariants"]

CANDIDATES = 400
PARAMETERS = 7
"""Limits: candidates looked at, and parameters of an action (one with more is only checked as if all were different
and may not touch a candidate where two could be the same)."""


@dataclass(frozen=True, order=True, slots=True)
class _Part:
    """A predicate in a candidate: for each argument the number of the candidate's parameter, or -1 where counted."""

    name: str
    places: tuple[int, ...]

    def key(self, args: tuple[str, ...]) -> tuple[str, ...]:
        """The candidate's parameters for a fact's arguments."""
        by_place = sorted((p, a) for p, a in zip(self.places, args, strict=True) if p >= 0)
        return tuple(a for _, a in by_place)


_Candidate = frozenset[_Part]
_Atom = tuple[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class _Case:
    """An action under one assumption of which of its parameters are the same thing."""

    pre: frozenset[_Atom]
    add: tuple[_Atom, ...]
    delete: frozenset[_Atom]


def with_invariants(library: Library) -> Library:
    """The library with the state variables that its templates keep; those it has are left as they are."""
    cases = [c for t in library.templates.values() for c in _cases(library, t)]
    if any(len(t.params) > PARAMETERS for t in library.templates.values()):
        return library
    kept: list[_Candidate] = []
    queue = list(_first(library, cases))
    seen = set(queue)
    for candidate in queue:  # grows
        if len(queue) > CANDIDATES:
            break
        trouble = _trouble(candidate, cases)
        if trouble is None:
            kept.append(candidate)
        else:
            for refined in _refined(candidate, *trouble):
                if refined not in seen:
                    seen.add(refined)
                    queue.append(refined)
    maximal = [c for c in kept if not any(c < other for other in kept)]
    named: dict[str, Variable] = {}
    for candidate in maximal:
        variable = _variable(library, candidate, named)
        if variable is not None:
            named[variable.name] = variable
    return replace(library, variables=(*library.variables, *named.values()))


def _cases(library: Library, template: Template) -> Iterator[_Case]:
    """Every way in which parameters and constants may be the same thing."""
    params = list(template.params)
    constants = sorted({a for p in (*template.pre, *template.post, *template.deletes) for a in p.args if a[:1] != "{"})
    below = {t: frozenset(s for s in library.types if library.is_a(s, t)) for t in library.types}
    unequal = {frozenset(pair) for pair in template.unequal}

    def extend(
        i: int, blocks: tuple[tuple[frozenset[str], str, frozenset[str]], ...], binding: dict[str, str]
    ) -> Iterator[dict[str, str]]:
        """`blocks`: the possible types, the representative and the parameters of each thing."""
        if i == len(params):
            yield binding
            return
        p = params[i]
        for b, (types, name, members) in enumerate(blocks):
            both = types & below[p.type]
            if both and not any(frozenset((p.name, m)) in unequal for m in members):
                joined = (*blocks[:b], (both, name, members | {p.name}), *blocks[b + 1 :])
                yield from extend(i + 1, joined, {**binding, p.name: name})
        new = (below[p.type], f"?{p.name}", frozenset({p.name}))
        yield from extend(i + 1, (*blocks, new), {**binding, p.name: f"?{p.name}"})

    first = tuple((frozenset({library.constants[c]}), c, frozenset[str]()) for c in constants)
    if len(params) > PARAMETERS:
        return
    for binding in extend(0, first, {}):

        def atom(p: Pattern, binding: Mapping[str, str] = binding) -> _Atom:
            return p.name, tuple(binding[a[1:-1]] if a[:1] == "{" else a for a in p.args)

        positive = frozenset(atom(p) for p in template.pre if not p.negated)
        if any(atom(p) in positive for p in template.pre if p.negated):
            continue
        add = tuple(dict.fromkeys(atom(p) for p in template.post))
        delete = frozenset(atom(p) for p in template.deletes) - set(add)
        yield _Case(positive, add, delete)


def _first(library: Library, cases: list[_Case]) -> Iterator[_Candidate]:
    """Each predicate that actions change, with no argument or one argument counted."""
    changed = {name for c in cases for name, _ in c.add}
    for c in library.conditions.values():
        if c.name not in changed:
            continue
        n = len(c.params)
        for counted in (None, *range(n)):
            places = [i for i in range(n) if i != counted]
            yield frozenset({_Part(c.name, tuple(places.index(i) if i != counted else -1 for i in range(n)))})


def _matched(candidate: _Candidate, atom: _Atom) -> tuple[str, ...] | None:
    """The key under which a fact belongs to a candidate."""
    for part in candidate:
        if part.name == atom[0]:
            return part.key(atom[1])
    return None


def _trouble(candidate: _Candidate, cases: list[_Case]) -> tuple[_Case, tuple[str, ...], bool] | None:
    """The first case in which the candidate may grow: the case, the key, and whether more could be counted in."""
    for case in cases:
        new: dict[tuple[str, ...], int] = {}
        for atom in case.add:
            key = _matched(candidate, atom)
            if key is not None and atom not in case.pre:
                new[key] = new.get(key, 0) + 1
        for key, n in new.items():
            if n > 1:
                return case, key, False
            if not any(_matched(candidate, d) == key for d in case.delete & case.pre):
                return case, key, True
    return None


def _refined(candidate: _Candidate, case: _Case, key: tuple[str, ...], open_: bool) -> Iterator[_Candidate]:
    """The candidate with one more predicate, one that the case deletes."""
    if not open_:
        return
    names = {part.name for part in candidate}
    for name, args in sorted(case.delete & case.pre):
        if name in names:
            continue
        for chosen in permutations(range(len(args)), len(key)):
            if len(args) - len(key) <= 1 and all(args[i] == k for i, k in zip(chosen, key, strict=True)):
                places = tuple(chosen.index(i) if i in chosen else -1 for i in range(len(args)))
                yield candidate | {_Part(name, places)}


def _variable(library: Library, candidate: _Candidate, taken: Mapping[str, Variable]) -> Variable | None:
    parts = sorted(candidate, key=lambda p: list(library.conditions).index(p.name))
    if all(-1 not in p.places for p in parts) and len(parts) == 1:
        return None  # a fact excludes nothing by itself
    arity = max(len(p.places) - p.places.count(-1) for p in parts)
    types: list[str] = []
    for k in range(arity):
        used = [library.conditions[p.name].params[p.places.index(k)].type for p in parts]
        above: list[str] = []
        here: str | None = used[0]
        while here is not None:
            above.append(here)
            here = library.types.get(here)
        types.append(next(t for t in above if all(library.is_a(u, t) for u in used)))
    base = "_or_".join(p.name for p in parts)[:90]
    name = base
    n = 2
    while name in taken:
        name, n = f"{base}_{n}", n + 1
    params = tuple(Param(f"x{k}" if arity > 1 else "x", t) for k, t in enumerate(types))
    values = tuple(Pattern(p.name, tuple(ANY if k < 0 else f"{{{params[k].name}}}" for k in p.places)) for p in parts)
    return Variable(name, params, values)
