"""A description that fits several things, followed by the name of what is meant: the name counts, unless it is another
thing's, or one of a list."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_atl.library import load_library
from llmbt_compiler.parsing import parse
from llmbt_compiler.stages import tagged
from llmbt_ir.scene import load_scene, to_semantic_map


def read(scene_name: str, *steps: str) -> tuple[set[str], set[str]]:
    scene = load_scene(scene_name)
    library = load_library(scene.library, beside=Path(scene.source).parent)
    found = parse(tagged(list(steps), "default"), to_semantic_map(scene), library)
    return {str(g.condition) for g in found.goals}, {d.code for d in found.errors()}


@pytest.mark.parametrize(
    "steps",
    [
        ("Pick up the block next to object 6, which is object 5.", "Place object 5 on position 12."),
        ("Pick up the block next to object 6 (object 5).", "Place it on position 12."),
        ("Pick up the block next to object 6, object 5, and place it on position 12.",),
        ("Place the yellow block - object 5 - on position 12.",),
        ("Take the block beside the red one, namely object 5, to position 12.",),
        ("Put a yellow block, say object 5, on position 12.",),
    ],
)
def test_the_name_counts(steps):
    assert read("cargo_sorting", *steps) == ({"On(object_5, position_12)"}, set())


@pytest.mark.parametrize(
    ("scene", "step", "code"),
    [
        ("cargo_sorting", "Take the green block, object 5, to position 31.", "E304"),
        ("household", "Take the snack, the chocolate and the bread to the user.", "E304"),
    ],
)
def test_not_of_another_thing_nor_in_a_list(scene, step, code):
    assert read(scene, step) == (set(), {code})


def test_the_same_again_where_the_first_went_to_any_place():
    goals, errors = read("cargo_sorting", "Place object 1 on any free position.", "Likewise place object 2.")
    assert {g.partition(",")[0] for g in goals} == {"On(object_1", "On(object_2"}
    assert not errors


@pytest.mark.parametrize("more", ["likewise object 2", "object 2 too", "object 2 as well"])
def test_likewise_means_the_place_too(more):
    goals, errors = read("cargo_sorting", f"Take object 1 to level 2; {more}.")
    assert (goals, errors) == ({"On(object_1, position_21)", "On(object_2, position_22)"}, set())
