"""What docs/own-scene.md tells a user to do, with the files it names."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "examples"
REQUEST = "The tea belongs in A2, salt in A1, the spice tin in A3."
GOALS = [("On", ["tea_box", "bay_A2"]), ("On", ["salt_cube", "bay_A1"]), ("On", ["spice_tin", "bay_A3"])]


@pytest.mark.parametrize("world", ["symbolic", pytest.param("bullet", marks=pytest.mark.slow)])
def test_the_depot(llmbt, tmp_path, world):
    for name in ("depot.xml", "depot-reply.txt"):
        shutil.copy(EXAMPLES / name, tmp_path)
    scene, tape = tmp_path / "depot.xml", tmp_path / "depot.yaml"
    reply = ["--reply", tmp_path / "depot-reply.txt", "-o", tape]
    assert llmbt("cassette", "author", REQUEST, "--scene", scene, *reply).code == 0
    order = ["--scene", scene, "--cassette", tape, "-o", tmp_path / "out", "--world", world, "--json"]
    answer = llmbt("run", REQUEST, *order)
    assert answer.code == 0, answer.out
    assert [(g["name"], g["args"]) for g in answer.json["goals"]] == GOALS
    first = answer.json["actions"][0]
    assert (first["name"], first["args"][0]) == ("pick", "spice_tin"), "the tin stands where the tea is to go"
    assert len(answer.json["actions"]) == 6, "it goes where it belongs at once"
