"""Our reader of PDDL, held against two kept ones from PyPI: `pddl` (what is written: types, objects, predicates,
actions, init, goal) and the translator of Fast Downward (what it means: every action in every state that is looked at).

Where one of them does not take a text, the reason stands in a table here, and the text must be refused.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from llmbt_atl.library import Library
from llmbt_atl.pddl import PddlProblem, import_domain, import_problem, pddl_fact
from llmbt_atl.state import applicable, apply
from llmbt_atl.template import Pattern, Template
from llmbt_ir.condition import Facts, holds
from tests.pddl.awkward import AWKWARD
from tests.pddl.domains import CLASSICS
from tests.pddl.flavours import FLAVOURS
from tests.pddl.generated import generated
from tests.search.bench import BLOCKS, PLACES, blocks_problem, places_problem

pytestmark = pytest.mark.extras

TEXTS = {
    **{f"classic {n}": t for n, t in CLASSICS.items()},
    **{f"awkward {n}": t for n, t in AWKWARD.items()},
    **{f"flavour {n}": (d, p) for n, (d, p, _) in FLAVOURS.items()},
    "bench blocks": (BLOCKS, blocks_problem(5, 1)),
    "bench places": (PLACES, places_problem(3, 5, 1)),
}
Literal = tuple[str, tuple[str, ...], bool]
"""Predicate, arguments (`?0`, `?1`, ... for parameters), whether negated; all in small letters."""


def ours(texts: tuple[str, str]) -> PddlProblem:
    return import_problem(texts[1], import_domain(texts[0], "domain.pddl"))


# -- pddl --------------------------------------------------------------------------------------------------------------

REFUSED_BY_PDDL = {
    "classic paint": "names that begin with an underscore",
    "awkward hydra": "names with a point, a lone `?` and a lone `_`",
    "awkward odd": "names with `@`, `%`, `&` and others that PDDL does not have",
    "awkward gripper": "actions whose effect stands before the precondition, no requirements",
}
SHAPED = {"or", "imply", "forall", "exists", "="}
"""What becomes several templates or goals here; compared by its meaning below."""


def tidied(texts: tuple[str, str]) -> tuple[str, str]:
    """What `pddl` insists on: small letters, a precondition in each action and none that is (), every requirement
    declared in both files, and every type that is used."""
    domain, problem = (re.sub(r"\(:requirements[^)]*\)", "", re.sub(r";[^\n]*", "", t).lower()) for t in texts)
    wants = " (:requirements :strips :typing :equality :disjunctive-preconditions :negative-preconditions"
    wants += " :universal-preconditions :existential-preconditions"
    wants += " :action-costs)" if "total-cost" in domain + problem else ")"
    domain = re.sub(r"(\(\s*domain\s+[^)]*\))", rf"\1{wants}", domain, count=1)
    before, goal = problem.split("(:goal", 1)
    if SHAPED & set(re.findall(r"[\w=]+", goal)):  # its problems know no requirements
        problem = before + "(:goal (and)))"
    domain = re.sub(r"(:action\s+\S+)\s+(?=:precondition|:effect)", r"\1 :parameters () ", domain)
    domain = re.sub(r":precondition\s*\(\s*\)", ":precondition (and)", domain)
    domain = re.sub(r"(:parameters\s*\([^)]*\))\s*:effect", r"\1 :precondition (and) :effect", domain)
    return domain, problem


def literals(formula: Any, at: dict[str, str]) -> list[Literal] | None:
    """The literals of a conjunction of `pddl`; None where it is false whatever holds."""
    from pddl.logic.base import And, Not
    from pddl.logic.functions import Increase
    from pddl.logic.predicates import EqualTo

    if isinstance(formula, And):
        parts = [literals(o, at) for o in formula.operands]
        return None if None in parts else [x for p in parts if p for x in p]
    negated = isinstance(formula, Not)
    atom = formula.argument if negated else formula
    if isinstance(atom, Increase):
        return []
    if isinstance(atom, EqualTo):
        pair = sorted(at.get(str(t.name), str(t.name)) for t in (atom.left, atom.right))
        same = pair[0] == pair[1]
        if same or not any(p.startswith("?") for p in pair):
            return [] if same != negated else None
        return [("=", tuple(pair), negated)]
    return [(str(atom.name), tuple(at.get(str(t.name), str(t.name)) for t in atom.terms), negated)]


def of_template(library: Library, template: Template, patterns: Iterable[Pattern]) -> set[Literal]:
    """A template's patterns in PDDL's words."""
    at = {f"{{{p.name}}}": f"?{i}" for i, p in enumerate(template.params)}
    found = set()
    for p in patterns:
        words = library.conditions[p.name].words.split()
        args = [at.get(a, a.lower()) for a in p.args]
        if words[0] == "=":
            args = sorted([*args, *(w.lower() for w in words[1:] if not w.startswith("{"))])
        found.add((words[0].lower(), tuple(args), p.negated))
    return found


def compare_what_is_written(texts: tuple[str, str]) -> int:
    """The number of actions compared; AssertionError for a difference."""
    from pddl.logic.predicates import Predicate
    from pddl.parser.domain import DomainParser
    from pddl.parser.problem import ProblemParser

    given = ours(texts)
    library, (domain_text, problem_text) = given.domain.library, tidied(texts)
    domain, problem = DomainParser()(domain_text), ProblemParser()(problem_text)

    assert {str(p.name) for p in domain.predicates} == {
        c.words.split()[0].lower() for c in library.conditions.values() if not c.words.startswith("=")
    }
    things = {str(o.name): str(o.type_tag or "object") for o in (*domain.constants, *problem.objects)}
    assert things == {n.lower(): t.lower() for n, t in given.domain.types.items()}
    above = {str(t): str(up) if up is not None else "object" for t, up in domain.types.items() if str(t) != "object"}
    assert above.items() <= {t.lower(): (up or "").lower() for t, up in library.types.items()}.items()
    stated = {x for f in problem.init if isinstance(f, Predicate) for x in literals(f, {}) or ()}
    assert stated == {_fact(library, f) for f in given.facts if not library.conditions[f.name].words.startswith("=")}
    if not SHAPED & set(re.findall(r"[\w=]+", texts[1].lower().split("(:goal")[1])):
        goal = literals(problem.goal, {})
        contrary = goal is not None and any((n, a, not neg) in goal for n, a, neg in goal)
        (ground,) = given.goals or ((),)
        if goal is None:
            assert not given.goals
        elif not contrary:
            assert set(goal) == {_fact(library, c) for c in ground}

    templates: dict[str, list[Template]] = {}
    for t in library.templates.values():
        templates.setdefault(t.words.split()[0].lower(), []).append(t)
    compared = 0
    for action in domain.actions:
        at = {str(v.name): f"?{i}" for i, v in enumerate(action.parameters)}
        mine = templates.pop(str(action.name), [])
        kinds = [sorted(map(str, v.type_tags)) or ["object"] for v in action.parameters]
        if (SHAPED - {"="}) & set(re.findall(r"\w+", str(action.precondition))) or any(len(k) > 1 for k in kinds):
            continue  # several templates
        pre = literals(action.precondition, at)
        if pre is None or any((n, a, not neg) in pre for n, a, neg in pre if n != "="):
            assert not mine, f"{action.name} can never be done"
            continue
        (template,) = mine
        assert kinds == [[p.type.lower()] for p in template.params]
        unequal = {("=", tuple(sorted(at_[f"{{{x}}}"] for x in pair)), True) for pair in template.unequal
                   for at_ in [{f"{{{p.name}}}": f"?{i}" for i, p in enumerate(template.params)}]}  # fmt: skip
        assert set(pre) == of_template(library, template, template.pre) | unequal
        effects = literals(action.effect, at) or []
        adds = {e for e in effects if not e[2]}
        assert adds == of_template(library, template, template.post)
        ends = {(n, a, False) for n, a, neg in effects if neg} - adds
        assert ends == of_template(library, template, template.deletes)
        compared += 1
    assert not templates, f"actions that are not in the text: {list(templates)}"
    return compared


def _fact(library: Library, condition: Any) -> Literal:
    name, *args = pddl_fact(library, condition.fact).strip("()").lower().split()
    return name, tuple(args), condition.negated


@pytest.mark.parametrize("name", [n for n in TEXTS if n not in REFUSED_BY_PDDL])
def test_what_is_written_is_what_pddl_reads(name: str) -> None:
    compare_what_is_written(TEXTS[name])


def test_what_is_written_in_random_domains_is_what_pddl_reads() -> None:
    assert sum(compare_what_is_written(generated(seed, plain=True)) for seed in range(40)) > 60


@pytest.mark.parametrize("name", REFUSED_BY_PDDL)
def test_what_pddl_does_not_read(name: str) -> None:
    from pddl.parser.domain import DomainParser

    ours(TEXTS[name])
    with pytest.raises(Exception):  # noqa: B017 - of its grammar or of its checks
        DomainParser()(tidied(TEXTS[name])[0])


# -- the translator of Fast Downward -----------------------------------------------------------------------------------

REFUSED_BY_THE_TRANSLATOR = {
    "classic logistics": "`either` for a parameter",
    "awkward rooms": "`either` for a parameter",
    "awkward gripper": "an action whose effect stands before the precondition",
    "awkward odd": "names that are not ASCII",
}


def transitions(given: PddlProblem, state: Facts) -> dict[tuple[str, frozenset[str]], None]:
    """What ours can do in a state: each action's PDDL name and arguments, with what then holds, where that changes."""
    library, found = given.domain.library, {}
    for action in given.domain.actions:
        if applicable(action, state):
            then = apply(action, state)
            if then != state:
                name = library.templates[action.call.name].words.split()[0]
                found[" ".join([name, *action.call.args]).lower(), _plain(library, then)] = None
    return found


def _plain(library: Library, facts: Facts) -> frozenset[str]:
    return frozenset(
        pddl_fact(library, f).lower() for f in facts if not library.conditions[f.name].words.startswith("=")
    )


def compare_what_it_means(texts: tuple[str, str], folder: Path, states: int = 150) -> int:
    """The number of transitions compared; AssertionError for a difference."""
    from fast_downward.translate import instantiate, normalize, options, pddl, pddl_parser

    files = [folder / "domain.pddl", folder / "problem.pddl"]
    for path, text in zip(files, texts, strict=True):
        path.write_text(text)
    options.set_options([*map(str, files)])
    task = pddl_parser.open(*map(str, files))
    start = frozenset(_atom(f) for f in task.init if isinstance(f, pddl.Atom) and f.predicate != "=")
    given = ours(texts)
    assert start == _plain(given.domain.library, given.facts)
    normalize.normalize(task)
    _, _, ground, goal, axioms, _ = instantiate.explore(task)
    reached = None if axioms or goal is None else [(_atom(g), g.negated) for g in goal]
    seen, queue, compared = {given.facts}, deque([given.facts]), 0
    while queue:
        here = queue.popleft()
        there = _plain(given.domain.library, here)
        if reached is not None:
            theirs = all((g in there) != negated for g, negated in reached)
            assert any(all(holds(c, here) for c in alternative) for alternative in given.goals) == theirs
        expected = set()
        for a in ground:
            if all((_atom(p) in there) != p.negated for p in a.precondition):
                ends = {_atom(e) for cond, e in a.del_effects if not cond}
                then = there - ends | {_atom(e) for cond, e in a.add_effects if not cond}
                if then != there:
                    expected.add((a.name.strip("()").strip().lower(), then))
        mine = transitions(given, here)
        assert set(mine) == expected
        compared += len(mine)
        for action in given.domain.actions:
            then_ = apply(action, here) if applicable(action, here) else here
            if then_ not in seen and len(seen) < states:
                seen.add(then_)
                queue.append(then_)
    return compared


def _atom(atom: Any) -> str:
    return f"({' '.join([atom.predicate, *atom.args])})".lower()


@pytest.mark.parametrize("name", [n for n in TEXTS if n not in REFUSED_BY_THE_TRANSLATOR])
def test_what_it_means_is_what_fast_downward_makes_of_it(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    compare_what_it_means(TEXTS[name], tmp_path)


def test_what_random_domains_mean_is_what_fast_downward_makes_of_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    texts = [generated(seed) for seed in range(250)]
    taken = [t for t in texts if "(either" not in t[0]]
    assert len(taken) > 100
    assert sum(compare_what_it_means(t, tmp_path, 40) for t in taken) > 1_000


@pytest.mark.parametrize("name", REFUSED_BY_THE_TRANSLATOR)
def test_what_the_translator_does_not_read(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ours(TEXTS[name])
    with pytest.raises((Exception, SystemExit)):
        compare_what_it_means(TEXTS[name], tmp_path)
