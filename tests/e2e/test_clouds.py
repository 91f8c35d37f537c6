"""`scene capture`, `scene map` and `compile --recognise`, as a user meets them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from llmbt_ir.semantic_map import read_map
from tests.e2e.conftest import CANONICAL, Answer

Run = Callable[..., Answer]


def test_from_cameras_to_the_same_tree(llmbt: Run, tmp_path: Path) -> None:
    own, seen = tmp_path / "own", tmp_path / "seen"
    assert llmbt("compile", CANONICAL, "--scene", "cargo_sorting", "-o", own, "-q").code == 0
    assert llmbt("compile", CANONICAL, "--scene", "cargo_sorting", "-o", seen, "-q", "--recognise").code == 0
    for name in ("prompt.json", "reply.json", "steps.json", "conditions.json", "tree.v000.xml"):
        assert (own / name).read_bytes() == (seen / name).read_bytes()
    assert (own / "map.xml").read_bytes() != (seen / "map.xml").read_bytes(), "the one is measured"


def test_capture_and_map(llmbt: Run, tmp_path: Path) -> None:
    folder, out = tmp_path / "clouds", tmp_path / "map.xml"
    told = llmbt("scene", "capture", "cargo_sorting", "-o", folder, "--json")
    assert told.code == 0
    assert {Path(c["file"]).name for c in told.json["clouds"]} == {"front.ply", "left.ply"}
    assert llmbt("scene", "capture", "cargo_sorting", "-o", folder).code == 2, "it is not empty"
    found = llmbt("scene", "map", "cargo_sorting", folder, "-o", out, "--json")
    assert found.code == 0 and len(found.json["objects"]) == 6
    assert len(read_map(out).objects) == 6
    again = llmbt("scene", "map", "cargo_sorting", folder / "left.ply", "--previous", out, "-q")
    assert again.code == 0 and again.out.count("<Object ") == 6
    compiled = tmp_path / "compiled"
    assert llmbt("compile", CANONICAL, "--scene", "cargo_sorting", "--map", out, "-o", compiled, "-q").code == 0


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (("scene", "map", "cargo_sorting", "nowhere.ply"), 1, "E001"),
        (("scene", "map", "cargo_sorting", "pyproject.toml"), 1, "E451"),
        (("scene", "map", "cargo_sorted"), 1, "E040"),
        (("compile", "x", "--scene", "cargo_sorting", "-o", "o", "--map", "m.xml", "--recognise"), 2, "E012"),
    ],
)
def test_mistakes(llmbt: Run, tmp_path: Path, arguments: tuple[str, ...], code: int, says: str) -> None:
    answer = llmbt(*(tmp_path / a if a == "o" else a for a in arguments))
    assert answer.code == code and says in answer.err


@pytest.mark.parametrize(
    ("of", "by", "code"),
    [
        pytest.param(1, 1000.0, "W453", id="millimetres"),
        pytest.param(200_000, 1.0, "W454", id="a few points"),
        pytest.param(100, 1.0, "W454", id="sparse"),
        pytest.param(2, 1.0, None, id="as it should be"),
    ],
)
def test_a_cloud_that_can_hardly_be_of_the_scene_is_doubted(
    llmbt: Run, tmp_path: Path, of: int, by: float, code: str | None
) -> None:
    """Every so many-th point, scaled."""
    import numpy as np

    from llmbt.vision import capture_start
    from llmbt_ir.scene import load_scene

    xyz = by * capture_start(load_scene("cargo_sorting"))[1].cloud.xyz_m[::of]
    head = f"ply\nformat ascii 1.0\nelement vertex {len(xyz)}\n"
    head += "".join(f"property double {a}\n" for a in "xyz") + "end_header"
    np.savetxt(tmp_path / "own.ply", xyz, "%.5f", header=head, comments="")
    told = llmbt("scene", "map", "cargo_sorting", tmp_path / "own.ply", "--json")
    assert told.code == 0 and [d["code"] for d in told.json["diagnostics"]] == ([code] if code else [])
    assert bool(told.json["objects"]) == (code is None)
