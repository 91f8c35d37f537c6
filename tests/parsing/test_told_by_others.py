"""Things and places told by others: by a comparison, by a rank, by counting from a place, by what they are not.

What they are told by is never what is meant: where the map does not settle it, the step is refused. The whole way from
the words: the shipped tagger labels the steps.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from llmbt_atl.library import Library, load_library
from llmbt_compiler.parsing import parse
from llmbt_compiler.stages import tagged
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap


@cache
def _scene(name: str) -> tuple[SemanticMap, Library]:
    scene = load_scene(name)
    return to_semantic_map(scene), load_library(scene.library, beside=Path(scene.source).parent)


def read(scene: str, text: str) -> tuple[list[str], set[str]]:
    """The goals and the errors of steps, parted by a bar."""
    found = parse(tagged(text.split(" | "), "default"), *_scene(scene))
    return sorted(str(g.condition) for g in found.goals), {d.code for d in found.errors()}


@pytest.mark.parametrize(
    ("scene", "text", "goals"),
    [
        # comparisons of sizes: object 4 < 5 < 1 < 6 < 2 = 3
        ("cargo_sizes", "Put the green block that is as big as object 3 on 22.", "On(object_2, position_22)"),
        ("cargo_sizes", "The yellow block smaller than object 1 goes to position 33.", "On(object_5, position_33)"),
        ("cargo_sizes", "Put the green block that is bigger than object 6 on 22.", "On(object_2, position_22)"),
        ("cargo_sizes", "Put the smallest block on 21 rather than 22.", "On(object_4, position_21)"),
        ("cargo_sizes", "Object 3 is larger than object 1. | Put object 3 on 21", "On(object_3, position_21)"),
        # ranks
        ("household", "Take whatever is furthest to the right on the bar to the shelf.", "On(tea, shelf)"),
        ("household", "Whichever drink is the tallest goes to the desk.", "On(water, desk)"),
        ("cargo_sizes", "Put object 1 on the bottom level, far right.", "On(object_1, position_14)"),
        ("cargo_sizes", "Stick object 4 at the far left of level 2.", "On(object_4, position_21)"),
        ("cargo_swap", "Put object 2 in the free middle position of level 1.", "On(object_2, position_13)"),
        ("cargo_swap", "The red block can live on level 2, in the middle spot that nobody has yet",
         "On(object_6, position_23)"),
        # counted from a place
        ("cargo_swap", "Lift object 3 up by one level.", "On(object_3, position_31)"),
        ("cargo_swap", "Shift the green block on the shelf by one slot to the left.", "On(object_1, position_11)"),
        ("cargo_swap", "Put the red block one slot to the right of object 1.", "On(object_6, position_13)"),
        ("cargo_swap", "Count along the bottom level to the third slot and pop the red in that.",
         "On(object_6, position_13)"),
        # how many of how many
        ("cargo_sorting", "Two of the three greens ought to be on level 3.",
         "On(object_1, position_31); On(object_2, position_32)"),
        # exceptions
        ("cargo_sorting", "The greens go up on level 2, all but object 4.",
         "On(object_1, position_21); On(object_2, position_22)"),
        # what is pointed out is the head of the phrase
        ("cargo_sorting", "See the yellow block right beside the red one? | That one goes to position 33.",
         "On(object_5, position_33)"),
        # whose the verb is
        ("household", "Fetch me my tea, and the biscuits can go on the desk.", "On(cookies, desk); On(tea, user)"),
        ("cargo_sizes", "Move object 2 to 22, and where it was you put object 5.",
         "On(object_2, position_22); On(object_5, position_13)"),
        # choices that are left
        ("household", "Bring me either the cookies or the chips, you choose!", "On(cookies, user)"),
        ("cargo_sizes", "Clear the shelf, whatever is on it goes to the sorting area.",
         "On(object_2, sorting_area); On(object_6, sorting_area)"),
    ],
)  # fmt: skip
def test_what_is_told_by_another_thing_is_found(scene: str, text: str, goals: str) -> None:
    assert read(scene, text) == (goals.split("; "), set())


@pytest.mark.parametrize(
    ("scene", "text", "code"),
    [
        ("cargo_sizes", "We need a block larger than object 1 at position 14.", "E304"),
        ("cargo_sizes", "Find the green block that is bigger than object 3 and place it on position 22.", "E301"),
        ("cargo_sizes", "One of these blocks is even larger than object 3. | That's the one I need on 23.", "E301"),
        ("cargo_sizes", "Put a yellow block no bigger than object 1 on 21.", "E305"),
        ("cargo_sizes", "Place object 4 to the left of level 2.", "E304"),
        ("cargo_sorting", "The red block goes on the top level, one slot further right than position 34.", "E302"),
        ("cargo_swap", "Count along the bottom level to the fifth slot and pop the red in that.", "E302"),
        ("cargo_swap", "Move object 2 one level up.", "E305"),
        ("cargo_swap", "Put object 2 on the second free slot.", "E304"),
        ("cargo_sorting", "Move two of the four green blocks to level 1.", "E301"),
        ("cargo_sorting", "The greens go up on level 2, all but the one with the chipped corner.", "E304"),
        ("cargo_sorting", "Put the green block that is next to a yellow one on position 14.", "E304"),
        ("cargo_sorting", "Put the red block on position 11 first, and after that it goes to 34.", "E314"),
        ("household", "Put the cookies back where they belong.", "E305"),
        ("household", "Put the milk on the desk or the table, whichever is closer.", "E304"),
    ],
)
def test_what_the_map_does_not_settle_is_refused(scene: str, text: str, code: str) -> None:
    assert code in read(scene, text)[1]


@pytest.mark.parametrize(
    "text",
    [
        "Put object 1 on 11. | No wait, object 2.",
        "Put object 1 on 31. | Correction: 32.",
        "Put object 1 on 31. | Make that 32.",
        "Put object 1 on 31. | Sorry, I meant object 2.",
        "Put object 1 on 31. | Or was it 33?",
        "Put object 1 on 31, I mean the yellow one.",
        "Object 1 goes on 21, or maybe it's 31.",
        "One of the yellows is to go onto 21, but check with me first which one.",
        "Put object 4 on position 11, but it has to stay in the sorting area.",
    ],
)
def test_an_order_that_is_taken_back_or_doubted_is_refused(text: str) -> None:
    assert read("cargo_sorting", text)[1]


@pytest.mark.parametrize(
    ("text", "goal"),
    [
        ("Put object 1 on 31. | No, put it on position 23 instead.", "On(object_1, position_23)"),
        ("Put object 1 on 31. | Wait, put it on 32.", "On(object_1, position_32)"),
        ("Place object 1 on 11, not on 12.", "On(object_1, position_11)"),
    ],
)
def test_the_same_thing_put_elsewhere_is_a_new_order(text: str, goal: str) -> None:
    assert read("cargo_sorting", text) == ([goal], set())
