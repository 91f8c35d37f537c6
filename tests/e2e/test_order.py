"""The paper's first limitation, to the end: blocks put on their level in the order of their sizes, in physics."""

from __future__ import annotations

import itertools
import json

import pytest

from llmbt_ir.scene import load_scene
from tests.e2e.test_stages import DIALOGUES


@pytest.mark.slow
@pytest.mark.parametrize("disturb", ["none", "drop"])
def test_each_level_is_in_order_of_size(llmbt, tmp_path, disturb):
    """Judged by where the physics has the blocks at the end, and by their sizes alone."""
    dialogue = DIALOGUES["in_order_of_size"]
    order = ["--scene", dialogue.scene, "-o", tmp_path / "out", "--disturb", disturb, "--seed", "1"]
    assert llmbt("run", dialogue.request, *order).code == 0
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert result["outcome"] == "SUCCESS"
    scene = load_scene(dialogue.scene)
    for colour, level in (("green", "shelf_level_1"), ("yellow", "shelf_level_2"), ("red", "shelf_level_3")):
        blocks = sorted((o for o in scene.objects if o.colour == colour), key=lambda o: o.size_m[0])
        where = [result["objects"][o.id]["xyz_m"] for o in blocks]
        x, y, z = scene.place(level).surface_m
        for (bx, by, bz), o in zip(where, blocks, strict=True):
            assert abs(bz - o.size_m[2] / 2 - z) < 0.01, "it stands on the level"
            assert abs(bx - x) < 0.1
            assert abs(by - y) < 0.25
        sides = [by for _, by, _ in where]
        assert all(a - b > 0.05 for a, b in itertools.pairwise(sides)), "the robot's left is the world's y"
