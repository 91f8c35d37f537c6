"""Our search next to other planners, on the same PDDL: whole process and search alone.

    python tests/search/bench.py [PLANNERS_VENV]

The other planners are taken from a scratch environment, where it exists:
    python -m venv /tmp/planners && /tmp/planners/bin/pip install up-fast-downward pyperplan pymimir
"""

from __future__ import annotations

import os
import random
import re
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIMIT_S = 60.0

BLOCKS = """(define (domain blocks)
  (:requirements :strips)
  (:predicates (on ?x ?y) (ontable ?x) (clear ?x) (handempty) (holding ?x))
  (:action pick-up :parameters (?x) :precondition (and (clear ?x) (ontable ?x) (handempty))
    :effect (and (not (ontable ?x)) (not (clear ?x)) (not (handempty)) (holding ?x)))
  (:action put-down :parameters (?x) :precondition (holding ?x)
    :effect (and (not (holding ?x)) (clear ?x) (handempty) (ontable ?x)))
  (:action stack :parameters (?x ?y) :precondition (and (holding ?x) (clear ?y))
    :effect (and (not (holding ?x)) (not (clear ?y)) (clear ?x) (handempty) (on ?x ?y)))
  (:action unstack :parameters (?x ?y) :precondition (and (on ?x ?y) (clear ?x) (handempty))
    :effect (and (holding ?x) (clear ?y) (not (clear ?x)) (not (handempty)) (not (on ?x ?y)))))
"""

PLACES = """(define (domain pick-and-place)
  (:requirements :strips :typing)
  (:types thing place)
  (:predicates (on ?t - thing ?p - place) (free ?p - place) (holding ?t - thing) (handempty))
  (:action pick :parameters (?t - thing ?p - place) :precondition (and (handempty) (on ?t ?p))
    :effect (and (holding ?t) (free ?p) (not (handempty)) (not (on ?t ?p))))
  (:action put :parameters (?t - thing ?p - place) :precondition (and (holding ?t) (free ?p))
    :effect (and (on ?t ?p) (handempty) (not (holding ?t)) (not (free ?p)))))
"""


def blocks_problem(n: int, seed: int) -> str:
    """Random towers to random towers."""
    rng = random.Random(seed)

    def towers() -> list[list[str]]:
        found: list[list[str]] = []
        for b in rng.sample([f"b{i}" for i in range(n)], n):
            k = rng.randrange(len(found) + 1)
            if k == len(found):
                found.append([b])
            else:
                found[k].append(b)
        return found

    def on(ts: list[list[str]]) -> str:
        return " ".join(f"(on {up} {low})" for t in ts for low, up in pairwise(t))

    first, last = towers(), towers()
    ends = " ".join(f"(ontable {t[0]}) (clear {t[-1]})" for t in first)
    names = " ".join(f"b{i}" for i in range(n))
    return (
        f"(define (problem b) (:domain blocks) (:objects {names})\n"
        f"(:init (handempty) {ends} {on(first)})\n(:goal (and {on(last)})))"
    )


def places_problem(n: int, k: int, seed: int) -> str:
    """`n` things on `k` places, each to another place; what is in the way has to go first."""
    rng = random.Random(seed)
    first, last = rng.sample(range(k), n), rng.sample(range(k), n)
    init = " ".join(f"(on t{i} p{p})" for i, p in enumerate(first))
    free = " ".join(f"(free p{p})" for p in range(k) if p not in first)
    goal = " ".join(f"(on t{i} p{p})" for i, p in enumerate(last))
    things, places = " ".join(f"t{i}" for i in range(n)), " ".join(f"p{i}" for i in range(k))
    return (
        f"(define (problem p) (:domain pick-and-place) (:objects {things} - thing {places} - place)\n"
        f"(:init (handempty) {init} {free})\n(:goal (and {goal})))"
    )


OURS = """
import sys, time
from pathlib import Path
from llmbt_atl.pddl import import_domain, import_problem, pddl_call
from llmbt_runtime.search import Plan, search
library = import_domain(Path(sys.argv[1]).read_text(), "d")
p = import_problem(Path(sys.argv[2]).read_text(), library)
start = time.perf_counter()
result = search(p.domain, p.facts, p.goals)
spent = time.perf_counter() - start
print("search", spent, "expanded", result.expansions)
if isinstance(result, Plan):
    print("plan length", len(result.actions))
"""


def commands(planners: Path, domain: Path, problem: Path, work: Path) -> dict[str, list[str]]:
    """What to run for each planner that is there."""
    found = {"ours": [sys.executable, "-c", OURS, str(domain), str(problem)]}
    down = next(planners.glob("lib/python*/site-packages/up_fast_downward/downward/fast-downward.py"), None)
    python = str(planners / "bin" / "python")
    if down is not None:
        found["lama-first"] = [
            python,
            str(down),
            "--plan-file",
            str(work / "sas_plan"),
            "--sas-file",
            str(work / "o.sas"),
            "--alias",
            "lama-first",
            str(domain),
            str(problem),
        ]
    if (planners / "bin" / "pyperplan").exists():
        found["pyperplan gbf hff"] = [
            python,
            str(planners / "bin" / "pyperplan"),
            "-H",
            "hff",
            "-s",
            "gbf",
            str(domain),
            str(problem),
        ]
    return found


def run(command: list[str], work: Path) -> tuple[float, str]:
    """Seconds and what was printed; `none` where it takes too long."""
    env = {**os.environ, "PYTHONPATH": ":".join(str(ROOT / p) for p in ("ir", "atl", "runtime"))}
    start = time.perf_counter()
    try:
        done = subprocess.run(command, cwd=work, env=env, capture_output=True, text=True, timeout=LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        return time.perf_counter() - start, "none"
    return time.perf_counter() - start, done.stdout + done.stderr


_NUMBERS = {
    "length": re.compile(r"(?:[Pp]lan length:?|Plan length: ) *(\d+)"),
    "search": re.compile(r"(?:^search |Search time: |Search time: )([\d.e-]+)", re.MULTILINE),
}


def main(planners: Path = Path("/tmp/planners"), repeats: int = 3) -> None:
    """Print the table."""
    problems = {f"blocks {n}": (BLOCKS, blocks_problem(n, 1)) for n in (5, 10, 20, 50)}
    for n, k in ((3, 5), (6, 9), (12, 16), (40, 60)):
        problems[f"places {n}/{k}"] = (PLACES, places_problem(n, k, 1))
    print(f"{'problem':14} {'planner':18} {'process s':>10} {'search s':>10} {'actions':>8}")
    for title, (domain_text, problem_text) in problems.items():
        with tempfile.TemporaryDirectory() as name:
            work = Path(name)
            domain, problem = work / "domain.pddl", work / "problem.pddl"
            domain.write_text(domain_text)
            problem.write_text(problem_text)
            for planner, command in commands(planners, domain, problem, work).items():
                times = []
                text = ""
                for _ in range(repeats):
                    spent, text = run(command, work)
                    times.append(spent)
                    if text == "none" or spent > 10:
                        break
                shown = {k: m.group(1) if (m := r.search(text)) else "-" for k, r in _NUMBERS.items()}
                whole = "none" if text == "none" else f"{min(times):.3f}"
                print(f"{title:14} {planner:18} {whole:>10} {shown['search'][:8]:>10} {shown['length']:>8}", flush=True)


if __name__ == "__main__":
    main(*(Path(a) for a in sys.argv[1:2]))
