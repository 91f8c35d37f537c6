"""A thing told by a comparison is every thing that compares so, and no thing where none does."""

import pytest

from llmbt_atl.library import load_library
from llmbt_compiler.checking import moved_all_the_same
from llmbt_compiler.checking.referring import meant_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import tokens
from llmbt_ir.scene import load_scene, to_semantic_map


def of(name):
    scene = load_scene(name)
    return Scene(to_semantic_map(scene), load_library(scene.library))


def fits(scene, text):
    return [set(m.ids) for m in meant_objects(tokens(text), text, of(scene))]


@pytest.mark.parametrize(
    ("scene", "text", "ids"),
    [
        ("cargo_sizes", "Put the block that is smaller than object 1 on position 14.", {"object_4", "object_5"}),
        ("cargo_sizes", "Put the yellow block bigger than object 1 on position 14.", {"object_3"}),
        ("cargo_sizes", "I want the block that's larger than object 3 on level 2.", set()),
        ("cargo_sizes", "Put the block as big as object 2 on level 2.", {"object_3"}),
        ("cargo_swap", "The block that's on the shelf can go back.", {"object_1", "object_3"}),
        ("cargo_sorting", "Object 6 to position 11, then that yellow block to 12.", {"object_3", "object_5"}),
    ],
)
def test_what_a_phrase_fits(scene, text, ids):
    assert fits(scene, text) == [ids]


def test_that_block_points_back_to_what_is_named_before():
    assert fits("cargo_sorting", "Object 3 to position 11, then object 6 beside that yellow block.") == []


@pytest.mark.parametrize(
    "text",
    [
        "Put object 5 into position 12. Object 1 has to stay exactly where it is, though.",
        "Object 1 needs to stay on position 12, and put object 5 on position 12 as well.",
        "Without moving object 1, set object 6 on position 12.",
    ],
)
def test_nothing_is_wanted_where_something_stays_whatever_the_reply_makes_of_it(text):
    scene = of("cargo_swap")
    assert [d.code for d in moved_all_the_same(text, (), scene.map, scene.library)] == ["E343"]
