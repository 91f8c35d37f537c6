"""The same lack in other words: ties told by a clause, neighbours, what is to stay, an ability told by a participle,
places beyond the end. Beside them stands what lacks nothing."""

from __future__ import annotations

import pytest

from llmbt_ir.diagnostics import LlmbtError
from tests.asking.test_dialogue import asked, talk

BIGGEST = {"object_2", "object_3"}
YELLOW = {"object_3", "object_5"}


@pytest.mark.parametrize(
    ("scene", "request_", "reply", "candidates"),
    [
        # a tie
        ("cargo_sizes", "Whatever block is the largest, I'd like it on 24.", "object 2 on position 24", BIGGEST),
        ("cargo_sizes", "Of all the blocks the largest goes on 22.", "object 2 on position 22", BIGGEST),
        ("cargo_sizes", "Position 32 needs the bulkiest block.", "object 2 on position 32", BIGGEST),
        ("cargo_sorting", "Take whichever of the yellow blocks is further left to 12.", "object 5 on position 12",
         YELLOW),
        ("cargo_sorting", "The block right at the very back of the sorting area goes on 11.", "object 3 on position 11",
         {"object_1", "object_3"}),
        # a neighbour
        ("cargo_sorting", "Would you put red's neighbour on 11?", "object 4 on position 11", {"object_4", "object_5"}),
        ("cargo_sorting", "Whatever stands next to the red cube goes to 12.", "object 4 on position 12",
         {"object_4", "object_5"}),
        # which of two, by what only the user knows
        ("household", "Hand me the red thing that I left lying about.", "the apple on the user", {"apple", "coke"}),
        ("cargo_sorting", "Object 2 or object 4, I can't quite recall which, on 31.", "object 2 on position 31",
         {"object_2", "object_4"}),
        ("cargo_sorting", "Position 22 or 32? My notes are gone. Object 3 goes there.", "object 3 on position 22",
         {"position_22", "position_32"}),
        # a place
        ("cargo_sizes", "Red is on the wrong level, put it on the other one!", "object 6 on position 21",
         {"shelf_level_1", "shelf_level_2"}),
        ("cargo_sorting", "Shelve the red one all the way to the left.", "object 6 on position 31",
         {"position_11", "position_21", "position_31"}),
    ],
)  # fmt: skip
def test_what_is_open_in_other_words_is_asked_about(scene, request_, reply, candidates):
    assert set(asked(request_, [f"1. Place {reply}."], scene=scene)[1]) == candidates


@pytest.mark.parametrize(
    ("scene", "request_", "reply"),
    [
        ("cargo_sizes", "Whatever block is the smallest, I'd like it on 24.", "object 4 on position 24"),
        ("cargo_sorting", "Take whichever of the yellow blocks is further back to 12.", "object 3 on position 12"),
        ("cargo_sorting", "The green neighbour of the red block goes to 13.", "object 4 on position 13"),
        ("household", "Hand me the apple that I left lying about.", "the apple on the user"),
        ("cargo_sorting", "Object 2 or object 4 on position 31, either is fine.", "object 2 on position 31"),
        ("cargo_sizes", "Put the red block one level lower.", "object 6 on position 21"),
        ("cargo_swap", "The red block goes on 24. Don't lay a finger on the yellow one on level 2.",
         "object 6 on position 24"),
        ("cargo_swap", "The red block should stay close to me, so put it on position 11.", "object 6 on position 11"),
        ("cargo_sorting", "Position 12 has to stay empty. Object 4 goes to 11.", "object 4 on position 11"),
        ("household", "The cookies my sister baked go on the desk.", "the cookies on the desk"),
        ("cargo_swap", "Move object 1 to position 11, but don't lift it too high.", "object 1 on position 11"),
        ("cargo_swap", "Object 6 on 11, but don't touch anything on the shelf.", "object 6 on position 11"),
        ("cargo_swap", "Object 3 goes to 24; hands off everything else on the shelf.", "object 3 on position 24"),
        ("cargo_swap", "Object 2 on 24. Everything that stands on level 2 stays where it is.",
         "object 2 on position 24"),
        ("cargo_swap", "Object 5 is still in the sorting area and I want it on position 13.",
         "object 5 on position 13"),
        ("household", "Take the tea over to him in the armchair.", "the tea on the user"),
        ("household", "I'm going to slice the bread, so put it on the desk.", "the bread on the desk"),
    ],
)  # fmt: skip
def test_what_lacks_nothing_is_not(scene, request_, reply):
    assert talk(request_, [f"1. Place {reply}."], scene=scene)[0]


@pytest.mark.parametrize(
    ("scene", "request_", "reply", "code"),
    [
        # an ability, by a participle, a gerund, a clause of time, a noun
        ("household", "As soon as you have heated the tea, serve it on the desk.", "the tea on the desk", "E144"),
        ("household", "I'd like the bread sliced and then put on the desk.", "the bread on the desk", "E144"),
        ("household", "After peeling the apple, put it on the desk.", "the apple on the desk", "E144"),
        ("household", "The apple, peeled and cut, on the desk.", "the apple on the desk", "E144"),
        ("household", "Let the tea cool and put it on the desk.", "the tea on the desk", "E144"),
        ("cargo_sorting", "Give object 6 a good clean and put it on 22.", "object 6 on position 22", "E144"),
        # what is to stay
        ("cargo_swap", "Red on 12, and hands off the green one that's in there.", "object 6 on position 12", "E343"),
        ("cargo_swap", "Red on 22, but don't you dare touch what's already there.", "object 6 on position 22", "E343"),
        ("cargo_swap", "Slide object 1 into position 11 without lifting it.", "object 1 on position 11", "E343"),
        ("household", "Put the tea on the desk, but never take it off the bar.", "the tea on the desk", "E343"),
        ("cargo_swap", "Red in 12, though whatever is sitting in there right now must not be moved.",
         "object 1 in the sorting area and object 6 on position 12", "E343"),
        ("cargo_swap", "Place object 6 in position 12, but don't touch anything on the shelf.",
         "object 1 in the sorting area and object 6 on position 12", "E343"),
        ("cargo_swap", "Red on 12, and what's in there stays exactly there or else!",
         "object 1 in the sorting area and object 6 on position 12", "E343"),
        # in two places at once
        ("cargo_sorting", "Object 1 should be on position 11, and I want it on position 12 too, at the same time.",
         "object 1 on position 12", "E343"),
        # a place filled with too few, somebody who is elsewhere
        ("cargo_sorting", "A yellow block on every position of level 1, please.",
         "object 3 on position 11 and object 5 on position 12", "E142"),
        ("household", "Take the tea out to him in the yard.", "the tea on the user", "E142"),
        ("cargo_swap", "Red on 22, but let the yellow one there be.", "object 6 on position 22", "E343"),
        ("cargo_swap", "Squeeze red in at position 12, the green one stays put.", "object 6 on position 12", "E343"),
        ("cargo_sorting", "Position 11 has to stay empty. Object 4 goes to 11.", "object 4 on position 11", "E343"),
        # more on one position than it takes, or one thing in two
        ("cargo_sorting", "Squeeze both of them onto 14, then we save a spot: objects 3 and 5.",
         "object 3 on position 14", "E308"),
        ("cargo_sorting", "Object 6 should be on 12 and 34 at once.", "object 6 on position 12", "E343"),
        # beyond the end
        ("cargo_sorting", "Bottom level, fifth place: there goes the red cube.", "object 6 on position 14", "E142"),
        ("cargo_sizes", "Raise the red block to the level above.", "object 6 on position 34", "E142"),
        ("cargo_sizes", "Could the red block go left by a slot?", "object 6 on position 32", "E142"),
        ("household", "Leave the cookies on the second desk.", "the cookies on the desk", "E142"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_in_other_words_is_refused(scene, request_, reply, code):
    with pytest.raises(LlmbtError) as caught:
        talk(request_, [f"1. Place {reply}."], scene=scene)
    assert caught.value.diagnostics[0].code == code


def test_a_models_question_says_that_there_is_no_level_above():
    question = "QUESTION: Object 6 is on level 3 already. Where should it go?"
    with pytest.raises(LlmbtError) as caught:
        talk("Raise the red block to the level above the one it's on.", [question], scene="cargo_sizes")
    assert "is no level" in caught.value.diagnostics[0].title


def test_an_answer_that_names_the_thing_takes_it_instead():
    said = "1. Pick up object 3 and put it down in the sorting area."
    goals, _, _ = talk(
        "No. Put it back where it came from.", [said], ["object 1, back to the sorting area"], scene="cargo_swap"
    )
    assert goals == ["On(object_1, sorting_area)"]
