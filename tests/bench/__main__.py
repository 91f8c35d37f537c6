"""`make bench`: the figures of docs/benchmarks.md, measured on this machine in this run."""

from __future__ import annotations

import argparse
import os
import platform
import tempfile
from datetime import UTC, datetime
from pathlib import Path

from tests.bench.clock import process, python, section
from tests.bench.engines import ticking
from tests.bench.planners import planning, trees
from tests.bench.world import world

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


def tagging() -> None:
    """Tagging sixteen steps, once loaded."""
    with section("Tagging 16 steps, one thread, once loaded"):
        from tests.bench.tagging import measure

        measure()


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__)
    parts = (starting, tagging, world, ticking, planning, trees)
    options.add_argument("--only", choices=[p.__name__ for p in parts], default=None)
    wanted = options.parse_args().only
    print("# Benchmarks\n")
    machine = f"{platform.machine()}, {os.cpu_count()} cores that may be shared"
    print(f"Printed by `make bench` on {datetime.now(UTC).date()}, {machine}: medians with their range.")
    for part in parts:
        if wanted in (None, part.__name__):
            part()
