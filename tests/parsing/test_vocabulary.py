"""What verbs, nouns and frames come to by their class: a table of each, and the neighbours that must be refused."""

from __future__ import annotations

import tomllib
from collections import Counter
from importlib.resources import files

import pytest

from llmbt_atl.library import Library
from llmbt_compiler.parsing import parse
from llmbt_compiler.parsing.evaluate import read_scene
from llmbt_compiler.parsing.words import lexicon
from llmbt_ir.semantic_map import SemanticMap
from tests.parsing.conftest import FIXTURES
from tests.parsing.labelled import steps

Place = tuple[SemanticMap, Library]

PUT = "lodge plant file house bung cram stuff wedge nestle seat sit station hang sling park post shelve reposition dock"
CARRY = (
    "lug tote ferry cart shuttle heave tow usher guide ease steer maneuver restore promote consign pull drive rush walk"
)
TAKE = "nab procure rescue hoist unstack pluck snag salvage"
GIVE = "supply grant lend donate gift cede award issue entrust give hand"
GO = "go hurry rush drive visit stroll march scoot"
IDLE = "await log touch confirm notice mention ponder photograph record advise schedule classify resume"
CANNOT = "open wipe pour weld paint cut plug press solder nail glue tape staple throw toss eat fry iron label"


def told(marked: str, scene: Place) -> tuple[list[str], set[str]]:
    result = parse(steps(*marked.split(" | ")), *scene)
    return [str(c) for c in result.conditions], {d.code for d in result.errors()}


@pytest.fixture(scope="module")
def household() -> Place:
    return read_scene(FIXTURES, "household")


@pytest.fixture(scope="module")
def depot() -> Place:
    return read_scene(FIXTURES, "depot")


@pytest.mark.parametrize("verb", [*PUT.split(), *CARRY.split()])
def test_a_thing_is_put_or_carried_somewhere(verb: str, cargo: Place) -> None:
    goal = ["On(object_1, position_12)"]
    assert told(f"A[{verb}] T[object 1] to D[position 12].", cargo) == (goal, set())
    assert told(f"A[{verb}] T[object 1] in D[position 12].", cargo) == (goal, set())


@pytest.mark.parametrize("verb", [*PUT.split(), *CARRY.split()])
def test_without_a_place_or_with_an_unknown_thing_it_is_refused(verb: str, cargo: Place) -> None:
    for step in (
        f"A[{verb}] T[object 1].",
        f"A[{verb}] the T[banana] on D[position 12].",
        f"A[{verb}] T[object 1] in D[box 9].",
    ):
        goals, errors = told(step, cargo)
        assert not goals
        assert errors


@pytest.mark.parametrize("verb", TAKE.split())
def test_a_thing_is_taken(verb: str, cargo: Place) -> None:
    assert told(f"A[{verb}] T[object 1].", cargo) == (["Holding(object_1)"], set())


@pytest.mark.parametrize("verb", GIVE.split())
def test_a_thing_is_given(verb: str, household: Place) -> None:
    assert told(f"A[{verb}] the T[apple] to the D[user].", household) == (["On(apple, user)"], set())
    assert told(f"A[{verb}] the D[user] the T[apple].", household) == (["On(apple, user)"], set())


@pytest.mark.parametrize("verb", GO.split())
def test_the_robot_goes(verb: str, household: Place) -> None:
    assert told(f"A[{verb}] to the D[desk].", household) == (["Near(desk)"], set())


@pytest.mark.parametrize("verb", IDLE.split())
def test_what_changes_nothing_is_left_out(verb: str, cargo: Place) -> None:
    assert told(f"A[{verb}] T[object 1].", cargo) == ([], {"E340"})


@pytest.mark.parametrize("step", ["A[Rest] for two seconds.", "A[Stand] by.", "A[Hold] on a second.", "A[Park]."])
def test_a_verb_of_two_readings_is_the_robots_own_without_a_thing(step: str, cargo: Place) -> None:
    assert told(step, cargo) == ([], {"E340"})
    assert told("A[Pick] up T[object 1]. | " + step, cargo) == (["Holding(object_1)"], set())


@pytest.mark.parametrize("verb", CANNOT.split())
def test_what_an_arm_cannot_do_is_refused_whatever_the_place(verb: str, household: Place) -> None:
    for step in (
        f"A[{verb}] the T[milk].",
        f"A[{verb}] the T[milk] on the D[table].",
        f"A[{verb}] the T[milk] to the D[user].",
    ):
        goals, errors = told(step, household)
        assert not goals
        assert "E303" in errors


DUE = [
    "T[Object 1] is meant for D[position 12].", "T[Object 1] is destined for D[position 12].",
    "T[Object 1] deserves D[position 12].", "T[Object 1] wants to A[live] in D[position 12], so please put it there.",
    "T[Object 1] is supposed to A[go] on D[position 12].", "T[Object 1] has its place on D[position 12].",
    "T[Object 1] ought to be on D[position 12].", "See that T[object 1] gets to D[position 12].",
    "D[Position 12] is to A[receive] T[object 1].", "D[Position 12] shall A[hold] T[object 1].",
    "D[Position 12] should be A[occupied] by T[object 1].", "D[Position 12] is intended for T[object 1].",
    "A[Use] D[position 12] for T[object 1].", "A[Assign] T[position 12] to D[object 1].",
    "T[Object 1]: D[destination position 12].", "T[Object 1], destination = D[position 12]",
    "A[Fill] T[position 12] with object 1.", "A[Fill] the T[second position] on D[level 1] with object 1.",
]  # fmt: skip


@pytest.mark.parametrize("step", DUE)
def test_what_is_due_at_a_place_comes_there(step: str, cargo: Place) -> None:
    assert told(step, cargo) == (["On(object_1, position_12)"], set())


@pytest.mark.parametrize(
    "step",
    [
        "T[Object 1] must never A[go] on D[position 12].", "T[Object 1] does not belong on D[position 12].",
        "D[Position 12] should not A[receive] T[object 1].", "T[Object 9] is meant for D[position 12].",
        "T[Object 1] is on D[position 12].", "A[Use] D[position 12] for a moment.", "A[Fill] T[position 12].",
    ],
)  # fmt: skip
def test_what_is_not_due_there_does_not(step: str, cargo: Place) -> None:
    goals, errors = told(step, cargo)
    assert not goals
    assert errors


def test_only_places_are_filled_with_things(household: Place) -> None:
    assert told("A[Fill] the T[cup] with milk.", household) == ([], {"E303"})
    assert told("A[Fill] the T[glass] with the milk.", household) == ([], {"E303"})


@pytest.mark.parametrize(
    ("noun", "thing"),
    [
        ("loaf", "bread"), ("loaf of bread", "bread"), ("chocolate bar", "chocolate"), ("crisps", "potato_chips"),
        ("packet of biscuits", "cookies"), ("cola", "coke"), ("fruit", "apple"), ("bottle of water", "water"),
    ],
)  # fmt: skip
def test_nouns_of_a_household(noun: str, thing: str, household: Place) -> None:
    assert told(f"A[Put] the T[{noun}] on the D[desk].", household) == ([f"On({thing}, desk)"], set())


@pytest.mark.parametrize("noun", ["glass of water", "soup", "plate", "tin", "carton"])
def test_what_is_none_of_them_or_several_is_refused(noun: str, household: Place) -> None:
    goals, errors = told(f"A[Put] the T[{noun}] on the D[desk].", household)
    assert not goals
    assert errors


@pytest.mark.parametrize(
    ("noun", "thing"),
    [
        ("drum", "drum_x"), ("keg", "drum_x"), ("oil barrel", "drum_x"), ("metal case", "crate_c"),
        ("metal box", "crate_c"), ("flat silver part", "torque_plate"), ("packet 17", "parcel_17"),
    ],
)  # fmt: skip
def test_nouns_of_a_store(noun: str, thing: str, depot: Place) -> None:
    for place in ("slot B4", "bay B4", "compartment B4", "space B4"):
        assert told(f"A[Put] the T[{noun}] in D[{place}].", depot) == ([f"On({thing}, B4)"], set())


@pytest.mark.parametrize(
    "step", ["D[Let me] know when you are done.", "A[Confirm] by A[camera] that T[object 1] is there."]
)
def test_sayings_ask_for_nothing(step: str, cargo: Place) -> None:
    assert told(step, cargo) == ([], {"E340"})


def test_a_saying_ends_where_an_order_begins(cargo: Place) -> None:
    step = "Let D[me] know when you are done and A[put] T[object 1] on D[position 12]."
    assert told(step, cargo) == (["On(object_1, position_12)"], set())


def test_a_telegram_stops(cargo: Place) -> None:
    step = "A[PUT] T[OBJECT 1] ON D[POSITION 12 STOP] A[PUT] T[OBJECT 2] ON D[POSITION 13 STOP]"
    assert told(step, cargo) == (["On(object_1, position_12)", "On(object_2, position_13)"], set())


def test_each_verb_has_one_meaning_and_none_that_moves_is_beyond_an_arm() -> None:
    raw = tomllib.loads((files("llmbt_compiler.parsing") / "data" / "words.toml").read_text("utf-8"))
    count = Counter(v for group in raw["verbs"]["meanings"] for v in group["verbs"])
    assert not [v for v, n in count.items() if n > 1]
    lists = lexicon().verbs
    assert lists["other"].isdisjoint(count)
    assert lists["other"].isdisjoint(lists["idle"] | lists["motion"])
