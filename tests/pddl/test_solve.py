"""`llmbt solve` on legal but awkward domains: every plan is held against its PDDL text by an independent validator."""

from __future__ import annotations

import json
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from llmbt.main import main
from llmbt.progress import Progress
from llmbt.solving import read_problem, solve_problem
from llmbt_atl.library import parse_library
from llmbt_ir.tree_xml import parse_tree
from llmbt_ir.versions import VersionStore
from llmbt_runtime.record import signatures_of
from tests.pddl.awkward import AWKWARD
from tests.pddl.domains import CLASSICS
from tests.pddl.flavours import FLAVOURS, PUZZLE
from tests.pddl.generated import generated
from tests.pddl.validator import Task, solvable, validate
from tests.search.bench import BLOCKS, blocks_problem

Solve = Callable[..., tuple[int, dict[str, Any], Path]]


@pytest.fixture
def solve(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Solve:
    """Solve a domain and a problem given as text: the exit code, what was printed as JSON, the folder."""

    def run(domain: str, problem: str, *options: str) -> tuple[int, dict[str, Any], Path]:
        files = [tmp_path / "domain.pddl", tmp_path / "problem.pddl"]
        for path, text in zip(files, (domain, problem), strict=True):
            path.write_text(text)
        folder = tmp_path / "out"
        code = main(["solve", *map(str, files), "-o", str(folder), "--force", "--json", *options])
        return code, json.loads(capsys.readouterr().out), folder

    return run


def checked(domain: str, problem: str, document: dict[str, Any], folder: Path) -> None:
    """The plan is valid, `actions` are those of the plan, every version is a tree of the library that was written."""
    lines = (folder / "plan.txt").read_text().splitlines()
    validate(domain, problem, lines)
    done = [a for a in document["actions"] if a["result"] == "SUCCESS"]
    assert [f"({' '.join([a['name'], *a['args']])})" for a in done] == lines
    library = parse_library((folder / "library.xml").read_bytes(), "library.xml")
    versions = VersionStore(folder).versions()
    assert len(versions) == document["versions"] and versions[0].number == 0
    for version in versions:
        parse_tree(version.path.read_bytes(), str(version.path), signatures_of(library))
    assert json.loads((folder / "result.json").read_text())["outcome"] == document["outcome"]


@pytest.mark.parametrize("name", [*AWKWARD, *CLASSICS])
def test_the_plan_is_valid(name: str, solve: Solve) -> None:
    domain, problem = (AWKWARD | CLASSICS)[name]
    code, document, folder = solve(domain, problem)
    assert code == 0 and document["outcome"] == "SUCCESS"
    assert document["actions"]
    checked(domain, problem, document, folder)


@pytest.mark.parametrize("name", AWKWARD)
def test_the_plan_is_valid_where_actions_fail(name: str, solve: Solve) -> None:
    domain, problem = AWKWARD[name]
    code, document, folder = solve(domain, problem, "--failure-rate", "0.1", "--seed", "3")
    assert code == 0 and document["outcome"] == "SUCCESS"
    checked(domain, problem, document, folder)


@pytest.mark.parametrize("name", FLAVOURS)
def test_problems_of_many_flavours_end_rightly(name: str, solve: Solve) -> None:
    domain, problem, outcome = FLAVOURS[name]
    code, document, folder = solve(domain, problem)
    assert (document["outcome"], code) == (outcome, 0 if outcome == "SUCCESS" else 3)
    if outcome == "SUCCESS":
        checked(domain, problem, document, folder)
    else:
        assert document["unsolvable_goals"] and document["reason"] and not document["actions"]


@pytest.mark.parametrize("block", range(4))
def test_random_domains_end_as_an_independent_search_says(block: int, tmp_path: Path) -> None:
    """By breadth first search over the validator, which knows nothing of ours."""
    outcomes: Counter[str] = Counter()
    for seed in range(100 * block, 100 * block + 100):
        domain, problem = generated(seed)
        stated, folder = read_problem((domain, problem), ("d", "p")), tmp_path / str(seed)
        document = solve_problem(
            stated, folder, Progress(quiet=True), seed=seed, budget=20_000, failure_rate=0.1 * (seed % 2)
        )
        there = solvable(domain, problem, 3_000)
        assert document["outcome"] in ("SUCCESS", "UNSOLVABLE", "ACTION_FAILED"), f"seed {seed}"
        outcomes[document["outcome"]] += 1
        if document["outcome"] == "SUCCESS":
            validate(domain, problem, (folder / "plan.txt").read_text().splitlines())
        elif document["outcome"] == "UNSOLVABLE" and not document["actions"]:
            assert not there, f"seed {seed}"
        if not seed % 2 and there is not None:
            assert (document["outcome"] == "SUCCESS") == there, f"seed {seed}"
    assert outcomes["SUCCESS"] > 20 and outcomes["UNSOLVABLE"] > 20


def test_a_problem_of_too_many_ground_actions_is_a_diagnostic(solve: Solve) -> None:
    """Where it was written out, 40 things in five parameters were a hundred million."""
    domain = (
        "(define (domain h) (:predicates (p ?a ?b ?c ?d ?e) (q ?a)) (:action a :parameters (?a ?b ?c ?d ?e)"
        " :precondition (and (q ?a) (q ?b)) :effect (p ?a ?b ?c ?d ?e)))"
    )
    things = [f"o{i}" for i in range(40)]
    problem = (
        f"(define (problem x) (:domain h) (:objects {' '.join(things)}) (:init {' '.join(f'(q {t})' for t in things)})"
        " (:goal (p o0 o1 o2 o3 o4)))"
    )
    code, document, folder = solve(domain, problem)
    assert code == 1 and document["diagnostics"][0]["code"] == "E096"
    assert not folder.exists()


def test_a_long_way_is_found_in_reasonable_time(solve: Solve) -> None:
    """A tree of 80 levels: at each one asks whether an ancestor has a cheaper achiever now (it took minutes once)."""
    n = 80
    ring = " ".join(f"(adj p{i} p{(i + 1) % n})" for i in range(n))
    lie = " ".join(f"(at t{i} p{i})" for i in range(n - 1))
    problem = (
        f"(define (problem x) (:domain puzzle) (:objects {' '.join(f't{i}' for i in range(n))} - tile"
        f" {' '.join(f'p{i}' for i in range(n))} - pos)\n(:init {ring} {lie} (blank p{n - 1})) (:goal (at t0 p1)))"
    )
    began = time.process_time()
    code, document, folder = solve(PUZZLE, problem)
    assert time.process_time() - began < 10
    assert code == 0 and len(document["actions"]) == n - 1
    checked(PUZZLE, problem, document, folder)


def test_the_validator_refuses_what_is_no_plan() -> None:
    domain, problem = CLASSICS["blocks"]
    with pytest.raises(AssertionError, match="cannot be done"):
        validate(domain, problem, ["(pick-up a)"])
    with pytest.raises(AssertionError, match="does not hold after"):
        validate(domain, problem, ["(pick-up d)"])
    task = Task(*AWKWARD["rooms"])
    assert task.is_a("b1", "thing") and not task.is_a("b1", "room") and task.is_a("b1", "object")


P1 = "(define (problem p) (:domain d) (:init (p)) (:goal GOAL))"
ONE = (
    "(define (domain d) (:predicates (p) (q) (r)) (:action a :precondition (p) :effect (and (q) (not (p))))"
    " (:action b :precondition (q) :effect (p)))"
)


@pytest.mark.parametrize(
    ("goal", "plan"),
    [
        ("(and)", []),
        ("()", []),
        ("(and (and) (or (and) (q)))", []),
        ("(imply (r) (q))", []),
        ("(or (r) (q))", ["(a)"]),
        ("(not (and (p) (not (q))))", ["(a)"]),
        ("(and (or (r) (p)) (or (r) (q)))", ["(a)", "(b)"]),
        ("(or (and (r) (q)) (and (not (p)) (not (not (q)))))", ["(a)"]),
    ],
)
def test_goals_of_any_shape(goal: str, plan: list[str], solve: Solve) -> None:
    problem = P1.replace("GOAL", goal)
    code, document, folder = solve(ONE, problem)
    assert code == 0 and document["outcome"] == "SUCCESS"
    assert (folder / "plan.txt").read_text().splitlines() == plan
    validate(ONE, problem, plan)


@pytest.mark.parametrize(("goal", "named"), [("(or)", []), ("(and (q) (r))", ["r"]), ("(or (r) (and (p) (r)))", ["r"])])
def test_goals_that_cannot_be_reached_are_named(goal: str, named: list[str], solve: Solve) -> None:
    code, document, _ = solve(ONE, P1.replace("GOAL", goal))
    assert code == 3 and document["outcome"] == "UNSOLVABLE" and document["reason"]
    assert document.get("unsolvable_goals", []) == named
    assert document["actions"] == []


def test_bad_input_is_a_diagnostic_with_its_place(solve: Solve) -> None:
    code, document, folder = solve(ONE, P1.replace("GOAL", "(and (q) (s))"))
    assert code == 1
    (fault,) = document["diagnostics"]
    assert fault["code"] == "E093"
    assert (fault["span"]["line"], fault["span"]["column"]) == (1, P1.index("GOAL") + len("(and (q) (") + 1)
    assert not folder.exists()


def test_an_unknown_planner_and_one_that_is_not_there(solve: Solve, monkeypatch: pytest.MonkeyPatch) -> None:
    code, _, _ = solve(*CLASSICS["ferry"], "--planner", "ours")
    assert code == 2
    monkeypatch.setitem(sys.modules, "up_fast_downward", None)
    code, document, _ = solve(*CLASSICS["ferry"], "--planner", "fast-downward")
    assert code == 2
    assert document["diagnostics"][0]["code"] == "E075" and "planners" in document["diagnostics"][0]["help"]
    code, document, _ = solve(*CLASSICS["ferry"], "--planner", "auto")
    assert code == 0, "without the extra it is our own search"


TOWERS = (BLOCKS, blocks_problem(20, 1))


@pytest.mark.extras
@pytest.mark.parametrize("budget", ["10", "200000"])
def test_fast_downward_plans_where_it_is_asked(budget: str, solve: Solve) -> None:
    """Its limit is time, not our budget."""
    code, document, folder = solve(*TOWERS, "--planner", "fast-downward", "--budget", budget)
    assert code == 0 and document["planner_calls"] == 1
    checked(*TOWERS, document, folder)


@pytest.mark.extras
def test_fast_downward_takes_over_where_our_own_search_has_spent_its_share(solve: Solve) -> None:
    code, document, _ = solve(*TOWERS, "--planner", "own", "--budget", "20")
    assert (code, document["outcome"]) == (3, "BUDGET")
    code, document, folder = solve(*TOWERS, "--planner", "auto", "--budget", "20")
    assert code == 0 and document["planner_calls"] == 1
    checked(*TOWERS, document, folder)
