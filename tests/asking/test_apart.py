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
    ],
)  # fmt: skip
def test_what_is_not_is_asked_about(scene, request_, reply, candidates):
    assert set(asked(request_, [f"1. Place {reply}."], scene=scene)[1]) == candidates
