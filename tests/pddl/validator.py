"""A plan held against its PDDL text: an own reader of lists, states as sets of tuples, nothing of the product.

It knows STRIPS with typing (`either` too), and, or, not, imply, forall, exists and = in preconditions and goals.
"""

from __future__ import annotations

import re
from collections import deque
from itertools import product
from typing import Any

Sexp = Any
Fact = tuple[str, ...]


def parse(text: str) -> Sexp:
    """Nested lists of lower-case words."""
    tokens = re.findall(r"[()]|[^\s()]+", re.sub(r";[^\n]*", "", text).lower())
    stack: list[list[Sexp]] = [[]]
    for token in tokens:
        if token == "(":
            stack.append([])
        elif token == ")":
            done = stack.pop()
            stack[-1].append(done)
        else:
            stack[-1].append(token)
    (whole,) = stack[0]
    return whole


def section(definition: Sexp, head: str) -> list[Sexp]:
    """What a section holds; empty where there is none."""
    return next((part[1:] for part in definition[1:] if part and part[0] == head), [])


def typed(items: list[Sexp]) -> list[tuple[str, list[str]]]:
    """Names with their types."""
    found: list[tuple[str, list[str]]] = []
    names: list[str] = []
    rest = iter(items)
    for item in rest:
        if item == "-":
            kind = next(rest)
            kinds = kind[1:] if isinstance(kind, list) else [kind]
            found += [(n, kinds) for n in names]
            names = []
        else:
            names.append(item)
    return found + [(n, ["object"]) for n in names]


class Task:
    """A domain with a problem."""

    def __init__(self, domain: str, problem: str) -> None:
        d, p = parse(domain), parse(problem)
        self.above = {n: kinds[0] for n, kinds in typed(section(d, ":types"))}
        self.things = dict(typed(section(d, ":constants")) + typed(section(p, ":objects")))
        self.state = {tuple(f) for f in section(p, ":init") if f[0] not in ("=", "not")}
        (self.goal,) = section(p, ":goal")
        self.actions = {a[1]: dict(zip(a[2::2], a[3::2], strict=True)) for a in d[1:] if a[0] == ":action"}

    def is_a(self, thing: str, kind: str) -> bool:
        here: str | None = self.things[thing][0]
        while here is not None:
            if here == kind:
                return True
            here = self.above.get(here) if here in self.above else ("object" if here != "object" else None)
        return False

    def holds(self, formula: Sexp, of: dict[str, str]) -> bool:
        """Whether a formula is true in the present state."""
        if not formula:
            return True
        head, *rest = formula
        if head == "and":
            return all(self.holds(f, of) for f in rest)
        if head == "or":
            return any(self.holds(f, of) for f in rest)
        if head == "not":
            return not self.holds(rest[0], of)
        if head == "imply":
            return not self.holds(rest[0], of) or self.holds(rest[1], of)
        if head in ("forall", "exists"):
            names = typed(rest[0])
            pools = [[t for t in self.things if any(self.is_a(t, k) for k in kinds)] for _, kinds in names]
            ways = ({**of, **dict(zip((n for n, _ in names), way, strict=True))} for way in product(*pools))
            return (all if head == "forall" else any)(self.holds(rest[1], way) for way in ways)
        args = tuple(of.get(a, a) for a in rest)
        return args[0] == args[1] if head == "=" else (head, *args) in self.state

    def effects(self, formula: Sexp, of: dict[str, str]) -> tuple[set[Fact], set[Fact]]:
        """What begins and what ends."""
        if formula[0] == "and":
            parts = [self.effects(part, of) for part in formula[1:]]
            adds: set[Fact] = set().union(*(a for a, _ in parts))
            return adds, set().union(*(e for _, e in parts)) - adds
        if formula[0] == "increase":
            return set(), set()
        if formula[0] == "not":
            return set(), {(formula[1][0], *(of.get(a, a) for a in formula[1][1:]))}
        return {(formula[0], *(of.get(a, a) for a in formula[1:]))}, set()

    def do(self, line: str) -> None:
        """One line of a plan; AssertionError where it cannot be done."""
        name, *args = line.strip().lower().strip("()").split()
        action = self.actions[name]
        params = typed(action.get(":parameters", []))
        assert len(params) == len(args), line
        for (_, kinds), arg in zip(params, args, strict=True):
            assert any(self.is_a(arg, k) for k in kinds), f"{line}: {arg} is no {kinds}"
        of = {p: a for (p, _), a in zip(params, args, strict=True)}
        assert self.holds(action.get(":precondition", []), of), f"{line} cannot be done"
        adds, ends = self.effects(action[":effect"], of)
        self.state = (self.state - ends) | adds


def validate(domain: str, problem: str, plan: list[str]) -> None:
    """AssertionError where a plan does not reach the problem's goal."""
    task = Task(domain, problem)
    for line in plan:
        task.do(line)
    assert task.holds(task.goal, {}), "the goal does not hold after the plan"


def solvable(domain: str, problem: str, states: int) -> bool | None:
    """Whether any actions reach the goal, by looking at every state; None where there are more than `states`."""
    task = Task(domain, problem)
    calls = []
    for name, action in task.actions.items():
        pools = [
            [t for t in task.things if any(task.is_a(t, k) for k in kinds)]
            for _, kinds in typed(action.get(":parameters", []))
        ]
        calls += [f"({' '.join([name, *chosen])})" for chosen in product(*pools)]
    seen = {frozenset(task.state)}
    queue = deque(seen)
    while queue:
        here = queue.popleft()
        task.state = set(here)
        if task.holds(task.goal, {}):
            return True
        for call in calls:
            task.state = set(here)
            try:
                task.do(call)
            except AssertionError:
                continue
            then = frozenset(task.state)
            if then not in seen:
                seen.add(then)
                queue.append(then)
        if len(seen) > states:
            return None
    return False
