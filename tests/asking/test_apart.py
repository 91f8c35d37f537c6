"""What the sentence around a phrase tells of it counts: a place behind things named in a row, a level that goes down,
a choice that is left open; and what it does not tell is asked about all the same."""

from __future__ import annotations

import pytest

from tests.asking.test_dialogue import asked, talk


@pytest.mark.parametrize(
    ("scene", "request_", "reply", "goals"),
    [
        ("cargo_swap", "Let the yellow block and the green block on the shelf change places.",
         "object 3 on position 12 and object 1 on position 22", 2),
        ("cargo_swap", "The yellows belong together: the one from sorting goes right of the other.",
         "object 5 on position 23", 1),
        ("cargo_sizes", "The bigger yellow goes on level 1 next to the green block; either side is fine.",
         "object 3 on position 12", 1),
        ("cargo_sizes", "The middle-sized one of the three greens goes right of the largest green.",
         "object 1 on position 14", 1),
        ("cargo_sizes", "Red one level down, at the left-hand end.", "object 6 on position 21", 1),
        ("cargo_sizes", "Object 4 gets a position on the same level as the red one.", "object 4 on position 32", 1),
        ("cargo_sorting", "One of the yellow blocks, either will do, onto 11.", "object 5 on position 11", 1),
        ("cargo_sorting", "Put a green block on 11, dealer's choice.", "object 2 on position 11", 1),
        ("household", "No coke for me, I'll have the water.", "the water on the user", 1),
        # what "it" is, a pair of which one is told, what stands beside a landmark, what a place holds
        ("cargo_sorting", "See object 6? The green one right next to it should be on 33.",
         "object 4 on position 33", 1),
        ("cargo_sorting", "Put object 2 on 22 and place the red block right next to it, on the left.",
         "object 2 on position 22 and object 6 on position 21", 2),
        ("cargo_sorting", "Object 3 and object 5 are the yellows. Object 3 can stay. The other goes on position 21.",
         "object 5 on position 21", 1),
        ("household", "The milk and the juice: the white one is mine and stays on the bar. The other should be brought"
         " to the desk.", "the juice on the desk", 1),
        ("cargo_sorting", "Next to object 6 there is a green block. Move it to 22, please.",
         "object 4 on position 22", 1),
        ("household", "Put the coke on the desk, and the milk, it should go on the shelf.",
         "the coke on the desk and the milk on the shelf", 2),
        ("cargo_sizes", "Object 5 goes to the level with nothing on it.", "object 5 on position 22", 1),
        ("cargo_sorting", "Position 21 - something red belongs there, so put the red one on it.",
         "object 6 on position 21", 1),
        ("cargo_sorting", "Object 3 isn't it. It's the other yellow I need on position 14.",
         "object 5 on position 14", 1),
        ("cargo_sorting", "Of the greens take the one in the middle of the three to 12.", "object 2 on position 12", 1),
    ],
)  # fmt: skip
def test_it_is_told_apart(scene, request_, reply, goals):
    assert len(talk(request_, [f"1. Place {reply}."], scene=scene)[0]) == goals


@pytest.mark.parametrize(
    ("scene", "request_", "reply", "candidates"),
    [
        ("cargo_swap", "Let the yellow block and the green block change places.",
         "object 3 on position 12 and object 1 on position 22", {"object_3", "object_5"}),
        ("cargo_sizes", "Put object 4 on level 2, at the left-hand end, or in the corner of it.",
         "object 4 on position 21", {"position_21", "position_24"}),
        ("cargo_sorting", "Pick one of the yellow blocks for 11.", "object 5 on position 11", {"object_3", "object_5"}),
        ("cargo_sorting", "Object 2 stays put. The green block standing beside it goes on 12.",
         "object 4 on position 12", {"object_1", "object_4"}),
        ("cargo_sorting", "Object 3 and object 5 are the yellows, and one of them can stay. The other goes on position"
         " 21.", "object 3 on position 21", {"object_3", "object_5"}),
        ("cargo_sorting", "Next to object 6 there's a block I want on 22. Move it, please.", "object 4 on position 22",
         {"object_4", "object_5"}),
        ("household", "There's the coke and the milk, and it has to go on the shelf.", "the coke on the shelf",
         {"coke", "milk"}),
        ("cargo_sizes", "Object 5 goes to the level with just one block on it.", "object 5 on position 32",
         {"shelf_level_1", "shelf_level_3"}),
        ("cargo_sorting", "The red one belongs to position 1-something.", "object 6 on position 11",
         {"position_11", "position_12", "position_13", "position_14"}),
        ("cargo_sizes", "Object 4 is the wrong green, it's the other green one I want over on 24.",
         "object 2 on position 24", {"object_1", "object_2"}),
        ("cargo_sorting", "A green block onto 12, but not the one in the middle.", "object 4 on position 12",
         {"object_1", "object_4"}),
        ("cargo_sorting", "Whatever's furthest back in the sorting area goes to 11.", "object 3 on position 11",
         {"object_1", "object_3"}),
    ],
)  # fmt: skip
def test_what_is_not_is_asked_about(scene, request_, reply, candidates):
    assert set(asked(request_, [f"1. Place {reply}."], scene=scene)[1]) == candidates


@pytest.mark.parametrize(
    "step",
    [
        "Pick up object 6 (red block), the leftmost one, and place it on position 24",
        "Put object 6 in the rightmost position, which is position 24",
        "Place object 6 on the rightmost position (position 24)",
    ],
)
def test_a_name_counts_whatever_is_said_beside_it(step):
    assert talk("Object 6 on position 24.", [f"1. {step}."])[0] == ["On(object_6, position_24)"]
