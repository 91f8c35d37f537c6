"""`make bench`: the figures of docs/benchmarks.md, measured on this machine in this run."""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

from tests.bench.clock import Ledger, process, python, section
from tests.bench.engines import ticking
from tests.bench.planners import planning, trees

CANONICAL = "Please sort the cargo by colour: green on shelf level 1, yellow on level 2, red on level 3."
LLMBT = str(Path(__file__).resolve().parents[2] / ".venv" / "bin" / "llmbt")
TORCH = """
import os; os.environ["HF_HUB_OFFLINE"] = "1"
import torch; torch.set_num_threads(1)
import transformers.models.bert.modeling_bert
"""
TORCH_TAG = """
from llmbt_compiler.keywords.tagger import load_tagger
load_tagger("torch").tag(["Pick up object 1 and place it on position 12."])
"""
DEFAULT_TAG = TORCH_TAG.replace('"torch"', '"default"')


def starting() -> None:
    """The command line and the compiler."""
    with section("Starting and compiling (whole processes, wall time)"):
        print(f"llmbt --help                                       {process([LLMBT, '--help'])}")
        with tempfile.TemporaryDirectory() as folder:
            command = [LLMBT, "compile", CANONICAL, "--scene", "cargo_sorting", "-o", f"{folder}/out", "--force", "-q"]
            print(f"llmbt compile, replayed                            {process(command)}")
            torch = [*command, "--tagger", "torch"]
            print(f"llmbt compile --tagger torch, replayed             {process(torch)}")
        print(f"bare: import torch and transformers' BERT          {python(TORCH)}")
        print(f"bare: the same, load the weights, tag one step     {python(TORCH_TAG)}")
        print(f"default tagger: load the weights, tag one step     {python(DEFAULT_TAG)}")


def executing(runs: int = 3) -> None:
    """Where an execution's wall time goes."""
    from llmbt.execution import Order, execute_tree
    from llmbt.progress import Progress
    from llmbt_ir.scene import load_scene
    from llmbt_runtime.bullet import approach, bench, conditions, skills
    from llmbt_runtime.bullet.world import BulletWorld

    title = "Executing the canonical tree in physics (this process, wall time)"
    with section(title), tempfile.TemporaryDirectory() as folder:
        process([LLMBT, "compile", CANONICAL, "--scene", "cargo_sorting", "-o", f"{folder}/c", "-q"], runs=1, warm=0)
        data = Path(folder, "c", "tree.v000.xml").read_bytes()
        totals: list[tuple[float, Ledger]] = []
        ledger = Ledger()
        ledger.wrap(BulletWorld, "__init__", "building the world")
        ledger.wrap(bench.Bench, "tick", "stepping the physics and reading its sensors")
        ledger.wrap(conditions.Conditions, "read", "conditions, with their IK and collision queries")
        for name in ("grasp", "let_go", "spot", "spots"):
            ledger.wrap(approach.Approach, name, "planning grasps, places and motions")
        ledger.wrap(skills, "plan_line", "planning grasps, places and motions")
        for i in range(runs):
            ledger.spent.clear()
            start = time.perf_counter()
            document = execute_tree(
                data, "tree.xml", Path(folder, f"run{i}"), Order(load_scene("cargo_sorting")), Progress(quiet=True)
            )
            total = time.perf_counter() - start
            assert document["outcome"] == "SUCCESS"
            totals.append((total, Ledger(ledger.spent.copy())))
        total, parts = sorted(totals, key=lambda t: t[0])[len(totals) // 2]
        print(f"{'whole (median of ' + str(runs) + ')':<52}{total:6.2f} s   for {document['sim_time_s']} s simulated")
        for part, seconds in parts.spent.most_common():
            print(f"  {part:<50}{seconds:6.2f} s   {100 * seconds / total:4.0f} %")
        rest = total - sum(parts.spent.values())
        print(f"  {'everything else: ticks, updates, files':<50}{rest:6.2f} s   {100 * rest / total:4.0f} %")


def tagging() -> None:
    """Tagging sixteen steps, once loaded."""
    with section("Tagging 16 steps, one thread, once loaded"):
        from tests.bench.tagging import measure

        measure()


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__)
    parts = (starting, tagging, executing, ticking, planning, trees)
    options.add_argument("--only", choices=[p.__name__ for p in parts], default=None)
    wanted = options.parse_args().only
    print("# Benchmarks\n")
    machine = f"{platform.machine()}, {os.cpu_count()} cores that may be shared"
    print(f"Printed by `make bench` on {datetime.now(UTC).date()}, {machine}: medians with their range.")
    for part in parts:
        if wanted in (None, part.__name__):
            part()
