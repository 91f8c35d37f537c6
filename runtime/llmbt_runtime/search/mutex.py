"""Which facts exclude each other, from the library's state variables, where this can be relied on.

A state variable is an invariant if it holds in the first state and no action breaks it. Both are checked here: what a
library declares wrongly, or a state that is observed wrongly, weakens the search but never makes a wrong proof.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from llmbt_ir.condition import Facts
from llmbt_runtime.search.task import Task

__all__ = ["Mutexes", "mutexes_of"]

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
    found: set[int] = set()
    keys = task.keys
    for op in task.ops:
        begun: dict[tuple[int, ...], list[int]] = {}
        for f in op.adds:
            for key in keys[f]:
                begun.setdefault(key, []).append(f)
        for key, values in begun.items():
            if key[0] in found:
                continue
            if not _together(task, values) or not _balanced(task, op.pre, set(op.deletes), key, values):
                found.add(key[0])
    return found


def _balanced(task: Task, pre: tuple[int, ...], deletes: set[int], key: tuple[int, ...], values: list[int]) -> bool:
    """Whether the variable's other values have gone once an action has set it."""
    before = [p >> 1 for p in pre if not p & 1 and key in task.keys[p >> 1]]
    coexist = set(values).union(*(task.related.get(v, ()) for v in values))
    if before:
        # what may hold beside the known value, and would not go with the new one
        possible = set(before).union(*(task.related.get(p, ()) for p in before))
        return possible - coexist <= deletes
    return set(task.groups[key]) - coexist <= deletes
