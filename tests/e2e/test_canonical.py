"""The main job: one sentence sorts the cargo, in physics, whatever goes wrong meanwhile."""

from __future__ import annotations

import itertools
import json
from math import hypot

import pytest

from llmbt.execution import load_tree, read_state
from llmbt_ir.scene import load_scene
from llmbt_ir.versions import VersionStore
from llmbt_runtime.update.rollout import Certificate, rollout
from tests.e2e.conftest import CANONICAL

SORTED = {
    "object_1": "position_12",
    "object_2": "position_13",
    "object_4": "position_14",
    "object_3": "position_22",
    "object_5": "position_23",
    "object_6": "position_32",
}
DISTURBANCES = ("drop", "obstacle_at_place", "obstacle_at_pick", "placed_object_moved")
CASES = [("none", s) for s in range(5)] + list(itertools.product(DISTURBANCES, range(5)))


def assert_sorted(result):
    """By the physics: every object horizontally within 2 cm of its place's centre."""
    assert result["outcome"] == "SUCCESS", result.get("reason")
    assert all(g["holds"] for g in result["goals"])
    for thing, place in SORTED.items():
        x, y, _ = result["objects"][thing]["xyz_m"]
        px, py, _ = result["places"][place]["xyz_m"]
        assert hypot(x - px, y - py) < 0.02, thing


def assert_versions_restart(folder, scene_name):
    """Every version, restarted in the symbolic world from the state it was made for, reaches the goals."""
    versions = VersionStore(folder).versions()
    assert [v.number for v in versions] == list(range(len(versions)))
    scene = load_scene(scene_name)
    for version in versions[1:]:
        file, _, domain, goals = load_tree(version.path.read_bytes(), str(version.path), scene)
        facts = read_state(version.path.with_suffix(".json"))
        found = rollout(file.tree, domain.for_state(facts), facts, goals)
        assert isinstance(found, Certificate), (version.name, found)
        assert [str(a) for a in found.actions] == version.record["certificate"]["actions"]


@pytest.mark.slow
@pytest.mark.parametrize(("disturb", "seed"), CASES)
def test_the_sentence_sorts_the_cargo(llmbt, tmp_path, disturb, seed):
    answer = llmbt(
        "run",
        CANONICAL,
        "--scene",
        "cargo_sorting",
        "-o",
        tmp_path / "out",
        "--disturb",
        disturb,
        "--seed",
        seed,
        "--json",
    )
    assert answer.code == 0
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert_sorted(result)
    assert result["sim_time_s"] < 120
    assert result["reply"] == "authored"
    if disturb == "none":
        assert result["disturbances"] == []
        assert result["updates"] == 1, "an undisturbed run needs no other tree than its first"
        assert all(a["result"] == "SUCCESS" for a in result["actions"])
    else:
        (fired,) = result["disturbances"]
        assert fired["name"] == disturb
        assert fired["broke"], "it counts only if it made a fact false"
        first_grasp = next(a["ended_s"] for a in result["actions"] if a["name"] == "pick")
        assert first_grasp <= fired["fired_at_s"] < result["sim_time_s"]
    assert_versions_restart(tmp_path / "out", "cargo_sorting")


def test_the_same_seed_gives_the_same_files(llmbt, tmp_path):
    """Byte for byte but for the wall time, trees and records alike."""
    order = ["--scene", "cargo_sorting", "--disturb", "drop", "--seed", "3", "--json"]
    for name in ("a", "b"):
        assert llmbt("run", CANONICAL, *order, "-o", tmp_path / name).code == 0
    files = sorted(p.name for p in (tmp_path / "a").iterdir())
    assert files == sorted(p.name for p in (tmp_path / "b").iterdir())
    for name in files:
        a, b = ((tmp_path / side / name).read_bytes() for side in ("a", "b"))
        if name == "result.json":
            a, b = (json.dumps({**json.loads(x), "wall_time_s": 0}).encode() for x in (a, b))
        assert a == b, name


def test_two_compiles_are_identical(llmbt, tmp_path):
    for name in ("a", "b"):
        assert llmbt("compile", CANONICAL, "--scene", "cargo_sorting", "-o", tmp_path / name).code == 0
    files = sorted(p.name for p in (tmp_path / "a").iterdir())
    assert "tree.v000.xml" in files
    for name in files:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name


def test_a_version_executes_elsewhere(llmbt, tmp_path):
    """Copied byte for byte as v000, it keeps its parent's hash, and works from the state it was made for."""
    run = tmp_path / "run"
    order = ["--scene", "cargo_sorting", "--world", "symbolic"]
    assert llmbt("run", CANONICAL, *order, "--disturb", "drop", "-o", run).code == 0
    newest = VersionStore(run).versions()[-1]
    state = ["--state", newest.path.with_suffix(".json")]
    assert llmbt("execute", newest.path, *order, *state, "-o", tmp_path / "again").code == 0
    (copied,) = VersionStore(tmp_path / "again").versions()
    assert copied.path.read_bytes() == newest.path.read_bytes()
    assert copied.record["parent_sha256"] == newest.record["parent_sha256"]
