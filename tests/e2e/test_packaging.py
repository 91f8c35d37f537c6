"""Shipped things are found by name from a wheel and from an sdist as they are from this checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("ir", "atl", "compiler", "runtime", "cli")
LOOK = """
import llmbt_ir, llmbt_atl.library, llmbt_compiler.keywords.tagger
from llmbt_ir.scene import scene_names
from llmbt_ir.shipped import shipped
from llmbt.main import main
print(llmbt_ir.__file__)
print(*scene_names(), *llmbt_atl.library.library_names())
print(len(list(shipped("llm_cassettes").glob("*.yaml"))))
raise SystemExit(main(["run", "Put the red block on position 32.", "--scene", "cargo_sorting", "-o", "out",
                       "--world", "symbolic", "-q"]))
"""


def unpacked(kind, folder):
    if kind == "wheel":
        (built,) = WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])
        zipfile.ZipFile(built).extractall(folder / "in")
        return [folder / "in"]
    (built,) = SdistBuilder(str(ROOT)).build(directory=str(folder))
    with tarfile.open(built) as archive:
        archive.extractall(folder / "in", filter="data")
    (top,) = (folder / "in").iterdir()
    return [top / room for room in ROOMS]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wheel", "sdist", "editable"])
def test_names_resolve(tmp_path, kind):
    paths = [ROOT / room for room in ROOMS] if kind == "editable" else unpacked(kind, tmp_path)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths))}
    done = subprocess.run(
        [sys.executable, "-c", LOOK], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    where, names, tapes, outcome, *_ = done.stdout.splitlines()
    assert where.startswith(str(paths[0]))
    found = names.split()
    assert {"cargo_sizes", "cargo_sorting", "cargo_swap", "household"} <= set(found)
    assert found[-2:] == ["cargo_sorting", "household"], "the libraries"
    assert int(tapes) >= 10
    assert outcome == "SUCCESS"
