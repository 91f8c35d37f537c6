"""`make bench`, planning: our whole process, with the certified tree and its versions, beside other planners."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.bench.clock import section
from tests.search.bench import BLOCKS, OURS, PLACES, blocks_problem, places_problem

LIMIT_S = 60
"""Of CPU time, so that what else the machine does decides nothing."""
LLMBT = str(Path(sys.executable).with_name("llmbt"))
MIMIR = """
import sys, time, pymimir
problem = pymimir.Problem(pymimir.Domain(sys.argv[1]), sys.argv[2])
start = time.perf_counter()
found = pymimir.gbfs_eager(problem, problem.get_initial_state(), pymimir.FFHeuristic(problem))
print("Search time:", time.perf_counter() - start)
print("Plan length:", len(found.solution))
"""
FIGURES = {
    "search": re.compile(r"^(?:\[t=.*\] |.*INFO *)?(?:search|Search time:) *([\d.e+-]+)", re.MULTILINE),
    "actions": re.compile(r"[Pp]lan length:? *(\d+)"),
}


def installed() -> Iterator[tuple[str, list[str]]]:
    """Each planner that is there, and its command before the two files."""
    yield "ours, search alone", [sys.executable, "-c", OURS]
    home = Path(sys.prefix)
    down = next(home.glob("lib/python*/site-packages/up_fast_downward/downward/fast-downward.py"), None)
    if down is not None:
        yield "lama-first", [sys.executable, str(down), "--alias", "lama-first"]
    if (home / "bin" / "pyperplan").exists():
        yield "pyperplan gbf hff", [sys.executable, str(home / "bin" / "pyperplan"), "-H", "hff", "-s", "gbf"]
    if next(home.glob("lib/python*/site-packages/pymimir"), None) is not None:
        yield "pymimir gbfs ff", [sys.executable, "-c", MIMIR]


def as_installed(cache: Path) -> dict[str, str]:
    """The environment of an installation: Python's byte code is kept, here in `cache`."""
    rest = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    return {**rest, "PYTHONPYCACHEPREFIX": str(cache), "OMP_NUM_THREADS": "1"}


@dataclass(frozen=True)
class Timed:
    """Whole processes: the median of wall time and the least CPU time, both in seconds; what was printed."""

    wall: str
    cpu: str
    text: str = ""


def timed(command: list[str], work: Path, env: dict[str, str], repeats: int) -> Timed:
    """A planner, after one run that warms up; `none` where it takes too long."""
    walls, cpus, text = list[float](), list[float](), ""
    for number in range(repeats + 1):
        began, start = os.times(), time.perf_counter()
        done = subprocess.run(
            ["/bin/sh", "-c", f'ulimit -t {LIMIT_S}; exec "$@"', "sh", *command],
            cwd=work,
            env=env,
            capture_output=True,
            text=True,
            check=False,
            stdin=subprocess.DEVNULL,
        )
        if done.returncode < 0:
            return Timed("none", "none")
        taken, ended = time.perf_counter() - start, os.times()
        text = done.stdout + done.stderr
        cpu = ended[2] + ended[3] - began[2] - began[3]
        if number or cpu > 5:
            walls.append(taken)
            cpus.append(cpu)
        if cpu > 5:
            break
    return Timed(f"{sorted(walls)[len(walls) // 2]:.2f}", f"{min(cpus):.2f}", text)


CASES = {f"blocks {n}": (BLOCKS, blocks_problem(n, 1)) for n in (5, 10, 20, 50)} | {
    f"places {n}/{k}": (PLACES, places_problem(n, k, 1)) for n, k in ((3, 5), (6, 9), (12, 16), (40, 60))
}


def trees(samples: int = 3_000) -> None:
    """The trees that one plan gives, and how many plans nest."""
    from llmbt_atl.pddl import import_domain, import_problem
    from llmbt_runtime.search import Plan, search
    from llmbt_runtime.update.chain import chain_tree
    from llmbt_runtime.update.links import linked_tree
    from tests.update.test_plan_trees import flat_chain, planned

    with section("Trees of our plan: nodes along its causal links, as grouped rows, as rows one beside the other"):
        print(f"{'problem':14}{'actions':>9}{'links':>9}{'grouped':>9}{'flat':>9}")
        for title, (domain, text) in CASES.items():
            problem = import_problem(text, import_domain(domain, "domain.pddl"))
            plan = search(problem.domain, problem.facts, problem.goals[0])
            assert isinstance(plan, Plan)
            made = linked_tree(problem.goals, 0, plan.actions, problem.facts)
            rows = len(chain_tree(problem.goals[0], plan.actions)), len(flat_chain(problem.goals[0], plan.actions))
            links = len(made[0]) if made is not None else "-"
            print(f"{title:14}{len(plan.actions):>9}{links:>9}{rows[0]:>9}{rows[1]:>9}", flush=True)
        plans = [(p, plan) for p, plan in planned(range(samples))]
        nested = sum(linked_tree(p.goals[:1], 0, plan, p.facts) is not None for p, plan in plans)
        print(f"of {len(plans)} plans for random problems {nested} nest")


def planning(repeats: int = 5) -> None:
    """Blocks and pick-and-place problems of growing size."""
    heading = (
        f"Planning: seconds of whole processes (wall, median of {repeats}; CPU, the least; none in {LIMIT_S} s of "
        "CPU) and of the search alone, actions, nodes of the certified tree"
    )
    with section(heading), tempfile.TemporaryDirectory() as cache:
        env = as_installed(Path(cache))
        print(f"{'problem':14}{'planner':20}{'wall':>9}{'CPU':>9}{'search':>9}{'actions':>9}{'nodes':>7}")
        for title, texts in CASES.items():
            with tempfile.TemporaryDirectory() as name:
                work = Path(name)
                files = [str(work / "domain.pddl"), str(work / "problem.pddl")]
                for path, text in zip(files, texts, strict=True):
                    Path(path).write_text(text)
                took = timed([LLMBT, "solve", *files, "-o", str(work / "out"), "--force", "-q"], work, env, repeats)
                newest = max(work.glob("out/tree.v*.json"))
                nodes = json.loads(newest.read_text())["nodes"]
                actions = len(json.loads((work / "out" / "result.json").read_text())["actions"])
                print(
                    f"{title:14}{'llmbt solve':20}{took.wall:>9}{took.cpu:>9}{'':>9}{actions:>9}{nodes:>7}", flush=True
                )
                for planner, command in installed():
                    took = timed([*command, *files], work, env, repeats)
                    found = {k: m.group(1)[:7] if (m := r.search(took.text)) else "-" for k, r in FIGURES.items()}
                    figures = f"{took.wall:>9}{took.cpu:>9}{found['search']:>9}{found['actions']:>9}"
                    print(f"{'':14}{planner:20}{figures}", flush=True)
