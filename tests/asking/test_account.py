"""For each thing that a reply moves, some words of the request stand for it alone; else it is asked about."""

from __future__ import annotations

from dataclasses import replace

import pytest

from llmbt_compiler.checking import unable
from llmbt_ir.diagnostics import LlmbtError
from tests.asking.test_dialogue import SCENES, asked, talk

BLOCKS = tuple(f"object_{n}" for n in range(1, 7))


@pytest.mark.parametrize(
    ("scene", "request_", "reply", "candidates"),
    [
        ("cargo_swap", "Yellow to the left end of level 3.", "object 5 on position 31", ("object_3", "object_5")),
        ("cargo_sizes", "Smallest green and the yellow onto level 2.", "object 4 and object 3 on level 2",
         ("object_3", "object_5")),
        ("cargo_sorting", "The block furthest to the left goes on 32.", "object 6 on position 32",
         ("object_3", "object_5", "object_6")),
        ("cargo_sizes", "Place the green we talked about on 21.", "object 4 on position 21",
         ("object_1", "object_2", "object_4")),
        ("cargo_sorting", "The scratched block goes on 24.", "object 3 on position 24", BLOCKS),
        ("cargo_sorting", "Whatever Tom ordered goes on position 11.", "object 2 on position 11", BLOCKS),
        ("cargo_sorting", "A few of these blocks go on the middle level.", "object 1 and object 2 on level 2", BLOCKS),
        ("cargo_swap", "One of the shelf blocks has to come down to the sorting area.", "object 1 on the sorting area",
         ("object_1", "object_3")),
        ("cargo_sizes", "Something bigger than object 1 should stand on 34.", "object 3 on position 34",
         ("object_2", "object_3", "object_6")),
        ("cargo_swap", "Stand the red one next to the one on level 1.", "object 6 on position 13",
         ("position_11", "position_13")),
        ("cargo_sorting", "Red goes to 13. Or does that say 31?", "object 6 on position 13",
         ("position_13", "position_31")),
        ("cargo_sizes", "Object 6 goes to the bottom or middle level, it slipped my mind which.", "object 6 on level 1",
         ("shelf_level_1", "shelf_level_2")),
    ],
)  # fmt: skip
def test_what_no_words_stand_for_alone_is_asked_about(scene, request_, reply, candidates):
    assert set(asked(request_, [f"1. Place {reply}."], scene=scene)[1]) == set(candidates)


@pytest.mark.parametrize(
    ("scene", "request_", "reply"),
    [
        ("cargo_sorting", "The red block, which Anna brought yesterday, is for 31.", "object 6 on position 31"),
        ("cargo_swap", "The yellow that isn't on the shelf yet goes on 34.", "object 5 on position 34"),
        ("cargo_swap", "Either of the greens in the sorting area will do for 13.", "object 2 on position 13"),
        ("cargo_swap", "Red directly left of the green that's on the shelf.", "object 6 on position 11"),
        ("cargo_sorting", "One green block on level 2. I don't care which one, or where.", "object 4 on position 23"),
        ("cargo_sorting", "Three greens in a row, and the middle one goes on 33.", "object 2 on position 33"),
        ("cargo_swap", "Object 4 to level 3 - no, sorry, I meant object 5, and to level 1.", "object 5 on position 14"),
        ("cargo_swap", "Object 1 goes down to the sorting area.",
         "object 1 (green block, on position 12) on the sorting area"),
    ],
)  # fmt: skip
def test_what_is_said_in_full_is_not(scene, request_, reply):
    goals, *_ = talk(request_, [f"1. Place {reply}."], scene=scene)
    assert len(goals) == 1


@pytest.mark.parametrize(
    ("scene", "request_", "reply", "lacking"),
    [
        ("cargo_swap", "The green block on the shelf: two slots to the left.", "object 1 on position 11", "two slots"),
        ("household", "The bread goes stale, it should be in the fridge.", "the bread on the shelf", "fridge"),
    ],
)
def test_what_the_map_lacks_is_named(scene, request_, reply, lacking):
    with pytest.raises(LlmbtError, match=lacking) as caught:
        talk(request_, [f"1. Put {reply}."], scene=scene)
    assert caught.value.diagnostics[0].code == "E142"


def test_a_question_of_the_models_says_what_the_request_gets_wrong():
    reply = "QUESTION: Level 2 is empty. Do you mean object 2 or object 6?"
    request_ = "Get the block that's on level 2 down to the sorting area."
    with pytest.raises(LlmbtError, match="names what is not there") as caught:
        talk(request_, [reply], scene="cargo_sizes")
    assert set(caught.value.diagnostics[0].candidates) == {"object_2", "object_6"}


def test_an_answer_and_the_one_place_of_the_request_are_a_goal():
    reply = "QUESTION: Do you mean object 3 or object 5?"
    goals, *_ = talk(
        "Why isn't the yellow block on 33? That's where I need it.", [reply], ["object 3"], scene="cargo_swap"
    )
    assert goals == ["On(object_3, position_33)"]


def test_turning_a_thing_is_no_carrying():
    semantic_map, library = SCENES["cargo_sizes"]
    assert list(unable("Turn the red one round on its spot.", semantic_map, library))
    assert not list(unable("Turn to the shelf.", semantic_map, library))


def test_a_noun_of_the_map_is_no_verb():
    """ "Screws on L" are the screw tin, where the map has one."""
    semantic_map, library = SCENES["cargo_sizes"]
    tin = replace(semantic_map.objects[0], name="screw tin")
    named = replace(semantic_map, objects=(tin, *semantic_map.objects[1:]))
    said = "Line the tins up for the stocktake: crowns on 11, screws on 12."
    assert list(unable(said, semantic_map, library)) and not list(unable(said, named, library))
    assert list(unable("Clean the lid.", named, library))
