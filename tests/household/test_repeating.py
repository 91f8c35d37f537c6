"""The same seed gives the same run in another process too: the story, the trees and where everything ends up."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
import sys
from pathlib import Path
from llmbt.execution import Order, execute_tree
from llmbt.progress import Progress
from llmbt.recorded import goal_records
from llmbt_atl.library import load_library
from llmbt_ir.condition import Condition
from llmbt_ir.scene import load_scene
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import Provenance, write_tree
from llmbt_runtime.record import signatures_of

folder, scene, disturb, perception, *pairs = sys.argv[1:]
goals = (tuple(Condition("On", tuple(p.split(":"))) for p in pairs),)
signatures = signatures_of(load_library(load_scene(scene).library))
tree = write_tree(goal_tree(goals), signatures, Provenance(goals=goal_records(goals)))
order = Order(load_scene(scene), seed=11, disturb=disturb, perception=perception)
execute_tree(tree, "tree.xml", Path(folder), order, Progress(quiet=True))
"""


def story(folder: Path, hash_seed: str, *arguments: str) -> tuple[dict[str, Any], dict[str, bytes]]:
    """A run in a process of its own: its result without the wall time, and every other file's bytes."""
    path = os.pathsep.join(str(ROOT / p) for p in ("ir", "atl", "compiler", "runtime", "cli"))
    env = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": hash_seed}
    folder.mkdir()
    subprocess.run(
        [sys.executable, "-c", PROGRAM, str(folder), *arguments], check=True, env=env, stdout=subprocess.DEVNULL
    )
    result = json.loads((folder / "result.json").read_bytes())
    del result["wall_time_s"]
    return result, {f.name: f.read_bytes() for f in sorted(folder.iterdir()) if f.name != "result.json"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "disturb", "perception", "pairs"),
    [
        ("household", "base_blocked,drop", "truth", ("milk:user",)),
        ("cargo_sorting", "object_moved", "camera", ("object_1:position_12", "object_6:position_32")),
    ],
)
def test_in_two_processes(tmp_path: Path, scene: str, disturb: str, perception: str, pairs: tuple[str, ...]) -> None:
    runs = [story(tmp_path / h, h, scene, disturb, perception, *pairs) for h in ("1", "2")]
    assert runs[0] == runs[1]
    result, files = runs[0]
    assert result["outcome"] == "SUCCESS" and len(result["disturbances"]) == len(disturb.split(","))
    assert {"events.jsonl", "tree.v001.xml"} <= set(files)
