"""Which facts exclude each other, from the library's state variables, where this can be relied on.

A state variable is an invariant if it holds in the first state and no action breaks it. Both are checked here: what a
library declares wrongly, or a state that is observed wrongly, weakens the search but never makes a wrong proof.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from llmbt_ir.condition import Facts
from llmbt_runtime.search.task import Op, Task

__all__ = ["Mutexes", "impossible", "mutexes_of"]

_KEY = "_llmbt_search_broken"


@dataclass(frozen=True, eq=False)
class Mutexes:
    """The variables that are invariants from one state on: for each fact number its variables' keys."""

    task: Task
    broken_variables: frozenset[int]
    broken_keys: frozenset[tuple[int, ...]]
    groups: dict[tuple[int, ...], list[int]] = field(repr=False)

    def keys(self, fact: int) -> list[tuple[int, ...]]:
        """The keys of a fact's reliable variables."""
        return [k for k in self.task.keys[fact] if k[0] not in self.broken_variables and k not in self.broken_keys]

    def exclusive(self, a: int, b: int) -> bool:
        """Whether two facts can never hold together."""
        if a == b or b in self.task.related.get(a, ()):
            return False
        keys = self.keys(a)
        return bool(keys) and any(k in keys for k in self.keys(b))

    def others(self, fact: int) -> list[int]:
        """All facts that a fact excludes."""
        related = self.task.related.get(fact, frozenset())
        return [o for k in self.keys(fact) for o in self.groups.get(k, ()) if o != fact and o not in related]


def mutexes_of(task: Task, facts: Facts) -> Mutexes:
    """The mutexes that hold in every state that can be reached from `facts`."""
    held: dict[tuple[int, ...], list[int]] = {}
    for f in task.fact_numbers(facts):
        for key in task.keys[f]:
            held.setdefault(key, []).append(f)
    return Mutexes(
        task,
        _broken_by_actions(task),
        frozenset(k for k, values in held.items() if not _together(task, values)),
        task.groups,
    )


def _together(task: Task, values: list[int]) -> bool:
    return len(values) < 2 or all(b in task.related.get(a, ()) for i, a in enumerate(values) for b in values[i + 1 :])


def _broken_by_actions(task: Task) -> frozenset[int]:
    """Variables that an action can make take two values."""
    cache = vars(task)
    broken = cache.get(_KEY)
    if broken is None:
        broken = cache[_KEY] = frozenset(_breaking(task))
    assert isinstance(broken, frozenset)
    return broken


def _breaking(task: Task) -> set[int]:
    """By induction: an action that needs two values of a variable that holds so far can never be done."""
    suspects = [(op, keys) for op in task.ops if (keys := set(_broken_keys(task, op)))]
    broken: set[int] = set()
    while True:
        more = {key[0] for op, keys in suspects if not impossible(task, op.pre, broken) for key in keys}
        if more <= broken:
            return broken
        broken |= more


def impossible(task: Task, pre: tuple[int, ...], broken: Collection[int]) -> bool:
    """Whether preconditions exclude each other by a variable that is not `broken`."""
    held: dict[tuple[int, ...], list[int]] = {}
    for p in pre:
        if not p & 1:
            for key in task.keys[p >> 1]:
                if key[0] not in broken:
                    held.setdefault(key, []).append(p >> 1)
    return any(len(values) > 1 and not _together(task, values) for values in held.values())


def _broken_keys(task: Task, op: Op) -> Iterator[tuple[int, ...]]:
    """The variables that an action can make take two values."""
    keys = task.keys
    begun: dict[tuple[int, ...], list[int]] = {}
    for f in op.adds:
        for key in keys[f]:
            begun.setdefault(key, []).append(f)
    if not begun:
        return
    before: dict[tuple[int, ...], list[int]] = {}
    for p in op.pre:
        if not p & 1:
            for key in keys[p >> 1]:
                before.setdefault(key, []).append(p >> 1)
    for key, values in begun.items():
        known = before.get(key)
        if (len(values) > 1 and not _together(task, values)) or not _balanced(task, op, key, values, known):
            yield key


def _balanced(task: Task, op: Op, key: tuple[int, ...], values: list[int], known: list[int] | None) -> bool:
    """Whether a variable's other values have gone once an action has set it to `values`."""
    related = task.related
    if known is not None and not related:
        return all(p in op.deletes or p in values for p in known)
    coexist = set(values).union(*(related.get(v, ()) for v in values))
    if known is not None:
        # what may hold beside the known value, and would not go with the new one
        possible = set(known).union(*(related.get(p, ()) for p in known))
        return possible - coexist <= set(op.deletes)
    return set(task.groups[key]) - coexist <= set(op.deletes)
