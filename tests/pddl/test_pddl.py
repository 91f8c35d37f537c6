"""PDDL in, libraries out: classics are solved, the meaning is kept, what is not supported says so with its line."""

from __future__ import annotations

import subprocess
import sys
from collections import deque
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import pytest
from hypothesis import assume, given, settings

from llmbt_atl.library import Library, load_library, parse_library
from llmbt_atl.pddl import import_domain, import_problem, pddl_call, pddl_fact, write_library
from llmbt_atl.pddl.invariants import with_invariants
from llmbt_atl.state import Domain, applicable, apply
from llmbt_atl.template import Param
from llmbt_ir.condition import Condition, Facts, holds
from llmbt_ir.diagnostics import LlmbtError
from llmbt_runtime.search import Plan, Unsolvable, search

from ..search.random_problems import Sample, samples
from .awkward import AWKWARD
from .domains import CLASSICS


def without_lines(library: Library) -> Library:
    """The library without what tells where it was read."""

    def plain(patterns):  # type: ignore[no-untyped-def]
        return tuple(replace(p, line=0) for p in patterns)

    return replace(
        library,
        source="",
        conditions={n: replace(c, line=0) for n, c in library.conditions.items()},
        variables=tuple(replace(v, line=0, values=plain(v.values)) for v in library.variables),
        templates={
            n: replace(
                t,
                line=0,
                start=plain(t.start),
                hold=plain(t.hold),
                post=plain(t.post),
                deletes=plain(t.deletes),
            )
            for n, t in library.templates.items()
        },
    )


@pytest.mark.parametrize("name", CLASSICS)
def test_classics_are_solved(name: str) -> None:
    domain, problem = CLASSICS[name]
    given_ = import_problem(problem, import_domain(domain, f"{name}.pddl"))
    result = search(given_.domain, given_.facts, given_.goals[0])
    assert isinstance(result, Plan)
    here = given_.facts
    for action in result.actions:
        assert applicable(action, here)
        here = apply(action, here)
    assert all(holds(g, here) for g in given_.goals[0])


@pytest.mark.parametrize("name", [*CLASSICS, *AWKWARD])
def test_actions_do_what_their_pddl_says(name: str) -> None:
    """Of every action that can be done in a state that can be reached, the effects are those that are written."""
    domain, problem = (CLASSICS | AWKWARD)[name]
    library = import_domain(domain, f"{name}.pddl")
    given_ = import_problem(problem, library)
    seen: set[Facts] = {given_.facts}
    queue = deque([given_.facts])
    while queue and len(seen) < 400:
        here = queue.popleft()
        for action in given_.domain.actions:
            if applicable(action, here):
                template = library.templates[action.call.name]
                binding = dict(zip((p.name for p in template.params), action.call.args, strict=True))
                expected = here - {p.bind(binding) for p in template.deletes} | {p.bind(binding) for p in template.post}
                assert apply(action, here) == expected
                if expected not in seen:
                    seen.add(expected)
                    queue.append(expected)


@pytest.mark.parametrize("name", [*CLASSICS, *AWKWARD])
def test_a_library_loads_back_as_it_was_written(name: str) -> None:
    domain, problem = (CLASSICS | AWKWARD)[name]
    library = import_domain(domain, f"{name}.pddl")
    written = write_library(library)
    again = parse_library(written, f"{name}.xml")
    assert without_lines(again) == without_lines(library)
    assert write_library(again) == written
    first, second = import_problem(problem, library), import_problem(problem, again)
    assert (first.facts, first.goals) == (second.facts, second.goals)


@pytest.mark.parametrize("name", ["cargo_sorting"])
def test_a_shipped_library_loads_back_as_it_was_written(name: str) -> None:
    library = load_library(name)
    assert without_lines(parse_library(write_library(library), "x.xml")) == without_lines(library)


def variables(name: str) -> dict[str, list[str]]:
    library = import_domain(CLASSICS[name][0], name)
    return {
        v.name: [f"{p.name}({', '.join(p.args)})" for p in v.values]
        for v in import_problem(CLASSICS[name][1], library).domain.library.variables
    }


def test_state_variables_of_blocks() -> None:
    assert variables("blocks") == {
        "handempty_or_holding": ["handempty()", "holding(*)"],
        "on_or_clear_or_holding": ["on(*, {x})", "clear({x})", "holding({x})"],
        "on_or_ontable_or_holding": ["on({x}, *)", "ontable({x})", "holding({x})"],
    }


def test_state_variables_of_logistics() -> None:
    assert variables("logistics") == {"at_or_in": ["at({x}, *)", "in({x}, *)"]}


def test_state_variables_of_gripper() -> None:
    assert variables("gripper") == {
        "at-robby": ["at-robby(*)"],
        "at_or_carry": ["at({x}, *)", "carry({x}, *)"],
        "free_or_carry": ["free({x})", "carry(*, {x})"],
    }


def test_a_variable_that_the_first_state_breaks_is_left_out() -> None:
    library = import_domain(CLASSICS["ferry"][0], "ferry")
    two = CLASSICS["ferry"][1].replace("(at-ferry l1)", "(at-ferry l1) (at-ferry l2)")
    assert "at-ferry" in {v.name for v in library.variables}
    assert "at-ferry" not in {v.name for v in import_problem(two, library).domain.library.variables}


@settings(max_examples=200)
@given(samples())
def test_state_variables_are_invariants(sample: Sample) -> None:
    """On random templates: what is found holds in every state that can be reached from one in which it holds, and it
    changes no action that can be done in such a state."""
    bare = replace(
        sample.domain.library,
        variables=(),
        conditions={
            n: replace(c, params=tuple(Param(p.name, p.type) for p in c.params))
            for n, c in sample.domain.library.conditions.items()
        },
    )
    full = with_invariants(bare)
    types = dict(sample.domain.types)
    plain, ours = Domain(bare, types), Domain(full, types)

    def clean(facts: Facts) -> bool:
        return not any(ours.mutex(a, b) for a, b in combinations(sorted(facts), 2))

    assume(full.variables and clean(sample.facts))
    plain, ours = plain.for_state(sample.facts), ours.for_state(sample.facts)
    by_call = {a.call: a for a in ours.actions}
    seen = {sample.facts}
    queue = deque([sample.facts])
    while queue and len(seen) < 500:
        here = queue.popleft()
        for action in plain.actions:
            if applicable(action, here):
                new = apply(action, here)
                assert clean(new)
                assert apply(by_call[action.call], here) == new if action.call in by_call else new == here
                if new not in seen:
                    seen.add(new)
                    queue.append(new)


def test_names_are_mangled_and_mapped_back() -> None:
    library = import_domain(CLASSICS["paint"][0], "paint.pddl")
    assert list(library.conditions) == ["Sequence_", "painted", "wet", "paint"]
    assert library.parameters("Sequence_") == ("ID_",)
    assert library.parameters("wet") == ("p_p",)
    assert list(library.templates) == ["paint_", "strip", "Inverter_", "swap"]
    assert library.parameters("paint_") == ("name_", "c")
    given_ = import_problem(CLASSICS["paint"][1], library)
    result = search(given_.domain, given_.facts, given_.goals[0])
    assert isinstance(result, Plan)
    assert "(paint p2 blue)" in [pddl_call(library, a.call) for a in result.actions]
    assert [pddl_fact(library, g) for g in given_.goals[0]][:2] == ["(painted p1 red)", "(not (painted p1 blue))"]
    assert Condition("Sequence_", ("p1",)) in given_.facts


def test_names_are_compared_without_case_and_printed_as_declared() -> None:
    given_ = import_problem(CLASSICS["blocks"][1], import_domain(CLASSICS["blocks"][0], "blocks.pddl"))
    assert Condition("on", ("B", "A")) in given_.facts
    assert "Pick-Up" in given_.domain.library.templates


def test_either_makes_a_template_for_each_type() -> None:
    library = import_domain(CLASSICS["logistics"][0], "logistics.pddl")
    assert [n for n in library.templates if n.startswith("load")] == ["load__truck", "load__airplane"]
    assert library.templates["load__truck"].words.split()[0] == "load"


def test_goals_that_exclude_each_other() -> None:
    domain, problem = CLASSICS["gripper"]
    both = problem.replace("(:goal (and", "(:goal (and (at ball1 rooma)")
    given_ = import_problem(both, import_domain(domain, "gripper.pddl"))
    result = search(given_.domain, given_.facts, given_.goals[0])
    assert isinstance(result, Unsolvable)
    assert result.goals == (Condition("at", ("ball1", "rooma")), Condition("at", ("ball1", "roomb")))


HEAD = "(define (domain d)\n (:requirements :strips)\n (:predicates (p ?x) (q ?x))\n"


MANY = [f"?x{i}" for i in range(9)]
ORS = f"(and {' '.join(f'(or (p {x}) (q {x}))' for x in MANY)})"


def act(pre: str, effect: str, params: str = "?x ?y") -> str:
    return f"{HEAD} (:action go :parameters ({params})\n  :precondition {pre}\n  :effect {effect}))"


@pytest.mark.parametrize(
    ("text", "code", "line", "word"),
    [
        ("(define (domain d)\n (:predicates (p)", "E090", 2, "not closed"),
        ("(define (problem d))", "E090", 1, "does not define a domain"),
        ("", "E090", 0, "no definition"),
        ("x", "E090", 1, "expected"),
        ("(define (domain d)\n (:requirements :strips\n :fluents) (:predicates (p)))", "E091", 3, ":fluents"),
        ("(define (domain d)\n (:derived (p) (q)))", "E092", 2, ":derived"),
        ("(define (domain d)\n (:durative-action a))", "E092", 2, ":durative-action"),
        (act("(p ?x)", "(or (p ?y) (q ?y))"), "E092", 6, "`or` cannot be an effect"),
        (act(ORS, "(p ?x0)", " ".join(MANY)), "E092", 5, "more than 256 alternatives"),
        (act("(forall (?z) (p ?z))", "(p ?y)"), "E092", 5, "quantifier"),
        (act("(p ?x)", "(and (p ?y)\n (when (p ?x) (q ?x)))"), "E092", 7, "conditional effect"),
        (act("(or (p ?x) (exists (?z) (p ?z)))", "(p ?y)"), "E092", 5, "quantifier"),
        (act("(not (p ?x) (q ?x))", "(p ?y)"), "E090", 5, "`not` takes one"),
        (act("(= ?x)", "(p ?y)"), "E095", 5, "`=` takes 2"),
        (act("(= ?x nowhere)", "(p ?y)"), "E093", 5, "unknown constant `nowhere`"),
        (act("(= ?x ?z)", "(p ?y)"), "E093", 5, "unknown parameter `?z`"),
        (act("(p ?x)", "(= ?x ?y)"), "E092", 6, "`=` cannot be an effect"),
        (act("(>= (p ?x) 3)", "(p ?y)"), "E092", 5, "fluent"),
        (act("(at start (p ?x))", "(p ?y)"), "E092", 5, "time"),
        (
            act("(p ?x)", "(q ?y)")[:-1] + "\n (:action GO :parameters () :effect (p ?x)))",
            "E094",
            7,
            "`GO` is declared",
        ),
        (act("(r ?x)", "(p ?y)"), "E093", 5, "unknown predicate `r`"),
        (act("(p ?z)", "(p ?y)"), "E093", 5, "unknown parameter `?z`"),
        (act("(p a)", "(p ?y)"), "E093", 5, "unknown constant `a`"),
        (act("(p ?x)", "(p ?y)", "?x - thing ?y"), "E093", 4, "unknown type `thing`"),
        (act("(p ?x ?y)", "(p ?y)"), "E095", 5, "takes 1 arguments and not 2"),
        (act("(p ?x)", "(p ?y)", "?x ?X"), "E094", 4, "declared twice"),
        (HEAD.replace("(q ?x)", "(P ?y)") + ")", "E094", 3, "declared twice"),
        (act("(p ?x)", "()"), "E090", 4, "no effect"),
        ("(define (domain d)\n (:types a&b a|b)\n (:predicates (p)))", "E094", 2, "would both be named `a_b`"),
        ("(define (domain d)\n (:types sequence sequence_)\n (:predicates (p)))", "E094", 2, "`sequence_`"),
        ("(define (domain d)\n (:constants {x})\n (:predicates (p)))", "E090", 2, "a name cannot hold"),
        ("(define (domain d)\n (:constants *)\n (:predicates (p)))", "E090", 2, "no name of an object"),
    ],
)
def test_what_is_not_supported_says_so(text: str, code: str, line: int, word: str) -> None:
    with pytest.raises(LlmbtError) as caught:
        import_domain(text, "d.pddl")
    (fault,) = caught.value.diagnostics
    assert fault.span is not None
    assert (fault.code, fault.span.source, fault.span.line) == (code, "d.pddl", line)
    assert word in fault.title + fault.help


@pytest.mark.parametrize(
    ("old", "new", "code", "word"),
    [
        ("(at c1 l2)", "(at c9 l2)", "E093", "unknown object `c9`"),
        ("(at c1 l2)", "(att c1 l2)", "E093", "unknown predicate `att`"),
        ("(at c1 l2)", "(at c1)", "E095", "takes 2 arguments and not 1"),
        ("(at c1 l2)", "(at l1 l2)", "E095", "is a location and not a car"),
        ("(at-ferry l1)", "(or (at-ferry l1))", "E092", "`or` is not supported here"),
        ("(and (at c1 l2)", "(and (when (at c1 l2) (at c1 l3))", "E092", "`when` is not supported here"),
        ("(and (at c1 l2)", "(at c1 l2) (and", "E090", "a :goal is one condition"),
        ("(at c1 l2)", "(= c1)", "E095", "`=` takes 2 arguments"),
        ("(at c1 l2)", "(= c1 c7)", "E093", "unknown object `c7`"),
        ("(at c1 l2)", "(exists (x) (at c1 l2))", "E090", "a variable begins with `?`"),
        ("(at c1 l2)", "(exists (?x - lorry) (at c1 ?x))", "E093", "unknown type `lorry`"),
        ("- car", "- lorry", "E093", "unknown type `lorry`"),
        ("(:goal", "(:gaol", "E092", ":gaol"),
        ("(:goal", "(:init (empty-ferry)) (:goal", "E094", "`:init` is there twice"),
        ("(:goal", "(:goal (at-ferry l1)) (:goal", "E094", "`:goal` is there twice"),
        ("(at-ferry l1)", "(at-ferry l1) (not (at c9 l2))", "E093", "unknown object `c9`"),
        ("(at-ferry l1)", "(at-ferry l1) (not (at c1 l2) (at c1 l3))", "E090", "`not` takes one fact"),
        ("- car", "* - car", "E090", "`*` is no name of an object"),
        ("- car", "?x - car", "E090", "`?x` is no name of an object"),
        ("- car", "{c} - car", "E090", "a name cannot hold '{'"),
        ("- car", "c\x00 - car", "E090", "a name cannot hold"),
    ],
)
def test_faults_of_a_problem(old: str, new: str, code: str, word: str) -> None:
    library = import_domain(CLASSICS["ferry"][0], "ferry.pddl")
    with pytest.raises(LlmbtError) as caught:
        import_problem(CLASSICS["ferry"][1].replace(old, new), library, "p.pddl")
    (fault,) = caught.value.diagnostics
    assert fault.code == code
    assert fault.span is not None
    assert fault.span.line > 0
    assert word in fault.title


def test_the_library_does_not_depend_on_the_order_of_hashes() -> None:
    script = (
        "import sys; from llmbt_atl.pddl import *\n"
        "from tests.pddl.domains import CLASSICS\n"
        "for n, (d, _) in CLASSICS.items(): sys.stdout.write(write_library(import_domain(d, n)).decode())\n"
    )
    outputs = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={"PYTHONHASHSEED": seed, "PYTHONPATH": ":".join(sys.path), "PATH": ""},
            cwd=Path(__file__).parents[2],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("0", "1", "2")
    }
    assert len(outputs) == 1
