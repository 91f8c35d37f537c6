"""What says or asks how things are orders nothing, and a place that is named outdoes no relation to something else.

The whole way from the words: the shipped tagger labels the steps.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_atl.library import Library, load_library
from llmbt_compiler.parsing import parse
from llmbt_compiler.stages import tagged
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap


@pytest.fixture(scope="module")
def swap() -> tuple[SemanticMap, Library]:
    """Object 1 stands on position 12, object 3 on position 22, the others in the sorting area."""
    scene = load_scene("cargo_swap")
    return to_semantic_map(scene), load_library(scene.library, beside=Path(scene.source).parent)


def read(text: str, scene: tuple[SemanticMap, Library]) -> tuple[set[str], set[str]]:
    found = parse(tagged([text], "default"), *scene)
    return {str(g.condition) for g in found.goals}, {d.code for d in found.errors()}


@pytest.mark.parametrize(
    "text",
    [
        "Is object 2 on position 34?",
        "Did you put object 2 on position 34?",
        "Have you moved object 2 to position 34?",
        "Should I put object 2 on position 34?",
        "Object 2 stands on position 34.",
        "Object 2 fits on position 34.",
        "Object 2 would fit on position 34.",
        "Object 2 could stand on position 34.",
        "Object 2 might be better on position 34.",
        "Object 2 would look nice on position 34.",
        "Object 2 was meant to be on position 34.",
        "Object 2 should fit on position 34.",
        "Position 34 is where object 2 stands.",
        "Position 34 suits object 2.",
        "Position 34 holds object 2.",
        "Position 34 is large enough for object 2.",
        "I see object 2 on position 34.",
        "I have object 2 on position 34.",
        "I love object 2 on position 34.",
        "You can find object 2 on position 34.",
        "On position 34 there is object 2.",
    ],
)
def test_how_things_are_is_no_goal(swap, text):
    goals, codes = read(text, swap)
    assert not goals
    assert codes


@pytest.mark.parametrize(
    "text",
    [
        "Could you put object 2 on position 34?",
        "Is it possible to put object 2 on position 34?",
        "Are you able to put object 2 on position 34?",
        "Do you mind putting object 2 on position 34?",
        "Object 2 should stand on position 34.",
        "Object 2 belongs on position 34.",
        "Object 2 goes to position 34.",
        "Object 2 has to sleep on position 34.",
        "I'd like object 2 on position 34.",
        "I would love to see object 2 on position 34.",
        "There is to be object 2 on position 34.",
        "Position 34 is the place for object 2.",
    ],
)
def test_orders_in_another_form_are(swap, text):
    assert read(text, swap) == ({"On(object_2, position_34)"}, set())


@pytest.mark.parametrize(
    "text",
    [
        "Put object 2 where it fits.",
        "Make sure position 34 holds object 2.",
        "Move the block that fits on position 34 there.",
        "Place the block which is large enough for level 2 on position 34.",
        "I have a red block that needs to be on position 34.",
        "There is a red block which must go to position 34.",
    ],
)
def test_an_order_that_tells_how_things_are_is_not_passed_over(swap, text):
    found = parse(tagged([text], "default"), *swap)
    assert not any("how things are" in n.text for n in found.notes)
    assert found.goals or found.errors()


def test_what_is_said_to_be_there_is_what_it_means(swap):
    steps = ["There is object 1 on position 12.", "Put it on position 34."]
    assert {str(g.condition) for g in parse(tagged(steps, "default"), *swap).goals} == {"On(object_1, position_34)"}


@pytest.mark.parametrize(
    ("text", "goal"),
    [
        ("Place object 6 on position 13, next to object 1.", "On(object_6, position_13)"),
        ("Place object 6 on position 21, to the left of object 3.", "On(object_6, position_21)"),
        ("Put object 6 on a position next to object 1.", "On(object_6, position_11)"),
    ],
)
def test_a_place_that_is_named_is_meant(swap, text, goal):
    assert read(text, swap) == ({goal}, set())


@pytest.mark.parametrize(
    "text",
    [
        "Place object 6 on position 34, next to object 1.",
        "Place object 6 on position 12, next to object 1.",
        "Place object 6 on position 23, to the left of object 3.",
        "Place object 6 at position 23 left of object 3.",
    ],
)
def test_and_contradicted_by_no_relation(swap, text):
    goals, codes = read(text, swap)
    assert not goals
    assert "E307" in codes
