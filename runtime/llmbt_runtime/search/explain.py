"""What stands in the way of goals that cannot be reached, in plain words. None of it decides anything."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from llmbt_atl.state import Domain
from llmbt_atl.template import Pattern, Template
from llmbt_ir.condition import ActionCall, Condition, Facts, show
from llmbt_runtime.search.heuristic import initial_literals, relaxed_costs
from llmbt_runtime.search.mutex import Mutexes
from llmbt_runtime.search.problem import Problem, bits
from llmbt_runtime.search.task import Task

__all__ = ["exclusive", "never_complete", "together", "unreachable"]

LINKS = 3
"""So many steps of the chain from a goal to what is missing are told."""


def unreachable(task: Task, facts: Facts, goal: Condition, excluded: frozenset[ActionCall]) -> str:
    """Why a goal cannot be reached even if nothing that holds ever ended: the chain of what every action for it needs,
    down to what nothing brings about."""
    number = task.number.get(goal.fact)
    if number is None:
        return f"{goal} cannot be reached from here: {_nothing(task.domain, goal)}"
    banned = task.excluded_ops(excluded)
    negative = task.negative | ({number} if goal.negated else frozenset())
    effects = task.effects_for(negative)
    costs = relaxed_costs(task, initial_literals(task, facts, negative), banned, effects)
    said: list[str] = []
    here = 2 * number + goal.negated
    seen = {here}
    while len(said) < LINKS:
        ways = [a for a in (task.deleters if here & 1 else task.adders).get(here >> 1, ()) if a not in banned]
        if not ways:
            said.append(_nothing(task.domain, _literal(task, here)))
            break
        missing = [[q for q in task.ops[a].pre if costs[q] == inf] for a in ways]
        shared = [q for q in missing[0] if all(q in m for m in missing)]
        nearest = min(range(len(ways)), key=lambda k: (len(missing[k]), k))
        who = str(_literal(task, here)) if said else "it"
        here = next(iter(shared or missing[nearest]))
        by = "" if shared else f" (by {task.ops[ways[nearest]].call})"
        said.append(f"{who} takes {_literal(task, here)}{by}")
        if here in seen:
            said.append("which is a circle")
            break
        seen.add(here)
    return f"{goal} cannot be reached from here: {', '.join(said)}{_unknown(task.domain, facts, goal)}"


def _unknown(domain: Domain, facts: Facts, goal: Condition) -> str:
    """That of what a goal is about nothing is known, where its state variable has no value: it is gone."""
    for variable, key in domain.variables_of(goal.fact):
        if key and not any((variable, key) in domain.variables_of(f) for f in facts):
            return f"; no `{variable.name}` of {' '.join(key)} is known"
    return ""


def _literal(task: Task, p: int) -> Condition:
    return ~task.facts[p >> 1] if p & 1 else task.facts[p >> 1]


def _nothing(domain: Domain, literal: Condition) -> str:
    """That no action brings a literal about, and what one of them lacks here."""
    for template, pattern in _static(domain, literal):
        return f"nothing brings {literal} about here ({template.name} would need {pattern})"
    return f"nothing brings {literal} about"


def _static(domain: Domain, literal: Condition) -> Iterator[tuple[Template, str]]:
    """The templates that would bring a literal about, each with a lasting fact that it lacks."""
    lasting: dict[str, list[Condition]] = {}
    for fact in domain.fixed:
        lasting.setdefault(fact.name, []).append(fact)
    added = {p.name for t in domain.library.templates.values() for p in t.post}
    for template in domain.library.achievers(literal.name, negated=literal.negated):
        for effect in template.deletes if literal.negated else template.post:
            binding = _bound(effect, literal.fact, {}) if effect.name == literal.name else None
            for need in template.pre if binding is not None else ():
                if need.negated or need.name in added or binding is None:
                    continue
                if not any(_bound(need, f, binding) is not None for f in lasting.get(need.name, ())):
                    args = tuple(binding.get(a[1:-1], "any") if a.startswith("{") else a for a in need.args)
                    yield template, show(need.name, args)


def _bound(pattern: Pattern, fact: Condition, binding: dict[str, str]) -> dict[str, str] | None:
    found = dict(binding)
    for arg, value in zip(pattern.args, fact.args, strict=True):
        wanted = found.setdefault(arg[1:-1], value) if arg.startswith("{") else arg
        if wanted != value:
            return None
    return found


def together(problem: Problem, mutexes: Mutexes, a: Condition, b: Condition) -> str:
    """Why two goals cannot be had together, where it is simple: each takes a literal that holds once only, or whatever
    brings the one about ends the other. Empty otherwise."""
    bit = dict(problem.goals)
    i, j = bit[a], bit[b]
    if not (problem.init >> i | problem.init >> j) & 1 and not set(problem.added_by[i]) & set(problem.added_by[j]):
        for lost in bits(_consumed(problem, i) & _consumed(problem, j)):
            return f"each takes {_literal(problem.task, problem.literals[lost])}, and nothing brings that back"
    if _ends(problem, mutexes, i, j) and _ends(problem, mutexes, j, i):
        return f"whatever brings {a} about ends {b}, and the other way round"
    return ""


def _ends(problem: Problem, mutexes: Mutexes, goal: int, other: int) -> bool:
    """Whether after every action for a goal another literal does not hold."""
    p = problem.literals[other]

    def excludes(a: int) -> bool:
        if not problem.keep[a] >> other & 1:
            return True
        needs = (problem.literals[i] for i in problem.pre_ids[a])
        return any(q == p ^ 1 or (not p & 1 and not q & 1 and mutexes.exclusive(p >> 1, q >> 1)) for q in needs)

    return all(excludes(a) and not problem.add[a] >> other & 1 for a in problem.added_by[goal])


def exclusive(mutexes: Mutexes, a: int, b: int) -> str:
    """The state variable of which two facts are values."""
    key = next(k for k in mutexes.keys(a) if k in mutexes.keys(b))
    domain = mutexes.task.domain
    things = sorted(domain.types)
    of = show(domain.library.variables[key[0]].name, tuple(things[i] for i in key[1:]))
    return f"they are values of `{of}`, which has one at a time"


def _consumed(problem: Problem, goal: int) -> int:
    """The literals that every action for a goal needs and ends, and that no action brings about."""
    found = problem.init
    for a in problem.added_by[goal]:
        found &= problem.pre[a] & ~problem.keep[a]
    return sum(1 << i for i in bits(found) if not problem.added_by[i])


def never_complete(problem: Problem, goal: int, states: set[int]) -> str:
    """What an action for a goal lacks in the states that have most of what it needs: no state has all of it."""
    ways = problem.added_by[goal]
    if not ways:
        return ""
    best = min(
        ((problem.pre[a] & ~state).bit_count(), k, problem.pre[a] & ~state)
        for k, a in enumerate(ways)
        for state in states
    )
    _, k, missing = best
    lacking = " and ".join(str(_literal(problem.task, problem.literals[i])) for i in bits(missing))
    others = f" (or {len(ways) - 1} other actions)" if len(ways) > 1 else ""
    call = problem.task.ops[problem.ops[ways[k]]].call
    return f"it takes {call}{others}, and {lacking} never holds together with the rest of what that needs"
