"""The simulated world: whole runs, where their time goes, going back to a trial's start, two processes."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from llmbt.execution import Order, execute_tree
from llmbt.progress import Progress
from llmbt.recorded import goal_records
from llmbt_atl.library import load_library
from llmbt_atl.state import domain_of
from llmbt_ir.condition import Condition
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import Provenance, write_tree
from llmbt_runtime import executor
from llmbt_runtime.record import signatures_of
from tests.bench.clock import Ledger, section

__all__ = ["world"]

_SORTED = (("1", "12"), ("2", "13"), ("4", "14"), ("3", "22"), ("5", "23"), ("6", "32"))
TASKS = {
    "cargo_sorting": tuple(Condition("On", (f"object_{o}", f"position_{p}")) for o, p in _SORTED),
    "household": (Condition("On", ("milk", "user")),),
}
WORDS = {"cargo_sorting": "canonical cargo run", "household": "household, the milk"}
_RUNS = 5
_ROUNDS = 5
_TRIALS = 2
_RESETS = 20


def executed(scene: str) -> dict[str, Any]:
    """One run in physics, from the goals alone, written to a folder as any run is."""
    loaded, goals = load_scene(scene), (TASKS[scene],)
    signatures = signatures_of(load_library(loaded.library))
    tree = write_tree(goal_tree(goals), signatures, Provenance(goals=goal_records(goals)))
    with tempfile.TemporaryDirectory() as folder:
        return execute_tree(tree, "tree.xml", Path(folder), Order(loaded), Progress(quiet=True))


# -- where the time goes -------------------------------------------------------------------------------------------

_BULLET = "llmbt_runtime.bullet."
_QUERIES = ("mirror", "grasp", "let_go", "spot", "fits", "touches", "is_free", "free_along", "reaches")
PARTS = {
    "physics": (("bench.Bench", "tick"),),
    "sensing: poses, contacts, forces": (("bench.Bench", "_sense"), ("bench.Bench", "_pressed")),
    "kinematics and trajectories": (
        ("kinematics", "solve"),
        ("kinematics", "solve_one"),
        ("kinematics", "solve_pitched"),
        ("motion", "plan_line"),
        ("motion", "plan_pitched"),
    ),
    "collision: grasps, places, ways of the arm": (
        *(("approach.Approach", name) for name in _QUERIES),
        ("planning", "plan_tip"),
    ),
    "ways on the floor, poses to stand at": (
        ("navigation.Floor", "route"),
        ("navigation.Floor", "connected"),
        ("docking", "find_docks"),
        ("docking", "around"),
    ),
    "conditions": (("conditions.Conditions", "read"),),
    "building the world": (("world.BulletWorld", "__init__"),),
}


def wrapped(ledger: Ledger) -> None:
    """Count the time of each part; a function that modules have imported by name is replaced in all of them."""
    importlib.import_module(f"{_BULLET}world")
    for part, functions in PARTS.items():
        for where, name in functions:
            module, _, owner = where.partition(".")
            home: Any = sys.modules[_BULLET + module]
            if owner:
                ledger.wrap(getattr(home, owner), name, part)
                continue
            before = getattr(home, name)
            ledger.wrap(home, name, part)
            for other in [m for n, m in sys.modules.items() if n.startswith(_BULLET)]:
                if getattr(other, name, None) is before:
                    setattr(other, name, getattr(home, name))
    for name in ("updated", "certify", "put", "prune"):
        ledger.wrap(executor._Run, name, "the update: search, certificate, insertion")


def _whole(scene: str) -> None:
    """The time of whole runs."""
    wall, cpu = [], []
    for _ in range(_RUNS):
        start = time.process_time()
        result = executed(scene)
        cpu.append(time.process_time() - start)
        wall.append(result["wall_time_s"])
        assert result["outcome"] == "SUCCESS"
    spread = f"{statistics.median(wall):6.2f} s  ({min(wall):.2f}-{max(wall):.2f}, {_RUNS} runs)"
    used = f"{statistics.median(cpu):.2f} s of CPU time, {result['sim_time_s']} s simulated"
    print(f"{WORDS[scene]:<50}{spread}, {used}", flush=True)


def _where(scene: str, ledger: Ledger) -> None:
    """The CPU time of a run's parts."""
    ledger.spent.clear()
    start = time.perf_counter()
    executed(scene)
    total = time.perf_counter() - start
    print(f"\n{f'where it goes, {WORDS[scene]}':<50}{total:6.2f} s")
    for part, seconds in ledger.spent.most_common():
        print(f"  {part:<48}{seconds:6.2f} s  {100 * seconds / total:4.0f} %")
    rest = total - sum(ledger.spent.values())
    print(f"  {'everything else: skills, ticks, files':<48}{rest:6.2f} s  {100 * rest / total:4.0f} %", flush=True)


# -- trials --------------------------------------------------------------------------------------------------------


def trials_of(scene: str) -> tuple[Callable[[int], None], Callable[[], float]]:
    """What runs a trial of a seed in a world that is built once, and what times its going back to the start."""
    from llmbt_runtime.bullet.world import BulletWorld

    loaded, goals = load_scene(scene), (TASKS[scene],)
    domain = domain_of(load_library(loaded.library), to_semantic_map(loaded))
    world = BulletWorld(loaded)

    def trial(seed: int) -> None:
        world.reset(seed)
        found = executor.execute(world, domain, goal_tree(goals), goals, keep=lambda _: "v")
        assert found.outcome == "SUCCESS", found.reason

    def restoring() -> float:
        start = time.perf_counter()
        world.reset()
        return time.perf_counter() - start

    return trial, restoring


def _worker(core: int, pipe: Connection) -> None:
    """Runs so many trials each time it is told to, on one core, and answers with the CPU time that they took."""
    os.sched_setaffinity(0, {core})
    trial, _ = trials_of("cargo_sorting")
    trial(0)
    pipe.send(0.0)
    while number := pipe.recv():
        start = time.process_time()
        for seed in range(number):
            trial(seed)
        pipe.send(time.process_time() - start)


def _two_processes() -> None:
    """Trials of one process and of two, each on a core of its own, by turns: by the wall, which counts other people's
    load, and by CPU time, which does not."""
    cores = sorted(os.sched_getaffinity(0))[:2]
    if len(cores) < 2:
        print("two processes: there is but one core")
        return
    context = multiprocessing.get_context("spawn")
    pipes = []
    workers = []
    for core in cores:
        mine, theirs = context.Pipe()
        worker = context.Process(target=_worker, args=(core, theirs), daemon=True)
        worker.start()
        workers.append(worker)
        pipes.append(mine)
    for pipe in pipes:
        pipe.recv()

    def seconds(some: list[Any]) -> tuple[float, float]:
        start = time.perf_counter()
        for pipe in some:
            pipe.send(_TRIALS)
        spent = [pipe.recv() for pipe in some]
        return time.perf_counter() - start, sum(spent) / len(spent)

    by_wall, by_cpu = [], []
    for k in range(_ROUNDS):
        one, two = seconds([pipes[k % 2]]), seconds(pipes)
        by_wall.append(2 * one[0] / two[0])
        by_cpu.append(2 * one[1] / two[1])
    for pipe, worker in zip(pipes, workers, strict=True):
        pipe.send(0)
        worker.join()
    for words, ratios in (("by the wall", by_wall), ("by CPU time", by_cpu)):
        each = ", ".join(f"{r:.2f}" for r in ratios)
        print(
            f"{f'trials of two processes to one, {words}':<50}{statistics.median(ratios):6.2f}     (median of {each})"
        )


def _restored(scene: str) -> None:
    """Going back to the start, after runs and at once."""
    trial, restoring = trials_of(scene)
    times = []
    for seed in range(_RESETS):
        if seed % 10 == 0:
            trial(seed)
        times.append(1e3 * restoring())
    words = f"back to the start of a trial, {WORDS[scene]}"
    print(f"{words:<50}{statistics.median(times):6.2f} ms ({max(times):.2f} at most)", flush=True)


def world() -> None:
    """All of it."""
    with section("The world: executions in physics (this process, wall time)"):
        load = os.getloadavg()[0]
        print(f"{load:.1f} processes wanted the {os.cpu_count()} cores in the minute before\n")
        for scene in TASKS:
            _whole(scene)
        for scene in TASKS:
            _restored(scene)
        _two_processes()
        ledger = Ledger()
        wrapped(ledger)
        for scene in TASKS:
            _where(scene, ledger)
