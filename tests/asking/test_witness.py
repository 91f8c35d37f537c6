"""The request as a second witness: what it fits, counts and has words for, whatever the reply made of it."""

from __future__ import annotations

import pytest

from tests.asking.test_dialogue import asked, talk


@pytest.mark.parametrize(
    ("request_", "reply", "scene", "code", "candidates"),
    [
        ("Position 11 is waiting for the yellow block.", "1. Place object 3 on position 11.", "cargo_sorting", "E141",
         ("object_3", "object_5")),
        ("I'd like the red block in the fifth position from the left on level 2.", "1. Place object 6 on position 24.",
         "cargo_sorting", "E142", None),
        ("Can you put that on the desk for me?", "1. Put the apple on the desk.", "household", "E142", None),
        ("I'd love my coffee at the desk today.", "1. Put the tea on the desk.", "household", "E142", None),
        ("Get object 3 out of there, would you?", "1. Place object 3 on position 11.", "cargo_sorting", "E305", None),
        ("Put the cookies back where they belong.", "1. Put the cookies on the shelf.", "household", "E305", None),
        ("Bring object 6 up to 31. Or was it 33?", "1. Place object 6 on position 33.", "cargo_sorting", "E141",
         ("position_31", "position_33")),
    ],
)  # fmt: skip
def test_what_the_reply_decided_alone_is_asked_about(request_, reply, scene, code, candidates):
    found = asked(request_, [reply], scene=scene)
    assert found[0] == code
    assert candidates is None or found[1] == candidates


@pytest.mark.parametrize(
    ("request_", "reply", "scene"),
    [
        ("Hand me the red thing, I mean the one you can bite into.", "1. Bring the apple to the user.", "household"),
        ("Any two of the three green blocks will do: put them on level 1.",
         "1. Place object 1 on position 11.\n2. Place object 2 on position 12.", "cargo_sorting"),
        ("Give object 5 a level that nobody uses.", "1. Place object 5 on position 21.", "cargo_sorting"),
        ("The two on the shelf should trade places.", "1. Swap object 1 and object 3.", "cargo_swap"),
        ("I mixed up the two blocks on the shelf. Swap them, so the green one is where the yellow one is.",
         "1. Swap object 1 and object 3.", "cargo_swap"),
    ],
)  # fmt: skip
def test_what_has_a_word_in_the_request_is_not(request_, reply, scene):
    assert talk(request_, [reply], scene=scene)[0]


def test_things_told_by_their_places_are_what_a_question_offers():
    question = "QUESTION: Should the green one on position 12 or the yellow one on position 22 go back?"
    assert asked("The block on the shelf goes back.", [question], scene="cargo_swap") == (
        "E140",
        ("object_1", "object_3"),
    )
