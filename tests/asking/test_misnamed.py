"""What a request names in words of the map that nothing there bears, or several do, and the reply takes one for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_atl.library import load_library
from llmbt_compiler.checking import ungrounded
from llmbt_compiler.checking.misnamed import misnamed
from llmbt_compiler.checking.unclear import unclear_names
from llmbt_compiler.parsing import Goal
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import tokens
from llmbt_ir.condition import parse_condition
from llmbt_ir.scene import load_scene, to_semantic_map

FOLDER = Path(__file__).parents[2] / "fixtures" / "requests" / "scenes"


def opened(name: str) -> Scene:
    scene = load_scene(str(FOLDER / f"{name}.xml"))
    return Scene(to_semantic_map(scene), load_library(scene.library))


SCENES = {name: opened(name) for name in ("ward", "larder", "studio", "rooms")}


@pytest.fixture(scope="module")
def ward() -> Scene:
    return SCENES["ward"]


@pytest.mark.parametrize(
    ("request_", "lacks"),
    [
        ("The night pill cup has to be in the night slot.", True),
        ("Hand gel goes in the top drawer of the nurses' station.", True),
        ("The noon pill cup has to be in the noon slot.", False),
        ("The evening cup goes to Mr Brandt.", False),
        ("Bring the locker mug to the wash stand.", False),  # a mug that stands on a locker
        ("Put the noon cup back into the pill tray.", False),
    ],
)
def test_a_name_that_nothing_bears(ward: Scene, request_: str, lacks: bool) -> None:
    assert [d.code for d in misnamed(tokens(request_), request_, ward)] == ["E142"] * lacks


@pytest.mark.parametrize(
    ("request_", "goal", "candidates"),
    [
        ("Leave the thermometer on the bedside locker.", "On(thermometer, window_locker)",
         ("door_locker", "window_locker")),
        ("Bring me the water bottle.", "On(water_bottle, patient_brandt)", ("patient_brandt", "nurse_adeyemi")),
        ("Leave the thermometer on the door-side locker.", "On(thermometer, door_locker)", None),
        ("This is Sister Adeyemi, bring me the water bottle.", "On(water_bottle, nurse_adeyemi)", None),
    ],
)  # fmt: skip
def test_a_name_that_several_bear(ward: Scene, request_: str, goal: str, candidates: tuple[str, ...] | None) -> None:
    goals = [Goal(parse_condition(goal), 1, "", Extent(0, 0))]
    found = list(unclear_names(tokens(request_), request_, goals, ward))
    assert [p.diagnostic.candidates for p in found] == ([candidates] if candidates else [])


@pytest.mark.parametrize(
    ("name", "request_", "lacks"),
    [
        ("larder", "Run the butter out to table four.", True),
        ("larder", "Run the butter out to niche K3.", False),
        ("larder", "Bring what's in the middle well out to the pass.", True),
        ("larder", "Bring what's on the pass to the landing.", False),
        ("studio", "Load the espresso cup into the kiln.", True),
        ("studio", "Load the espresso cup into the damp box.", False),
        ("studio", "Load the espresso cup into the damp boxx.", False),  # a slip of the pen
        ("rooms", "Fetch me the third dagger off the weapons chest.", True),
        ("rooms", "Fetch me the second dagger off the weapons chest.", False),
    ],
)
def test_a_place_or_a_thing_that_is_not_there(name: str, request_: str, lacks: bool) -> None:
    assert [d.code for d in misnamed(tokens(request_), request_, SCENES[name])] == ["E142"] * lacks


def test_a_noun_of_two_places() -> None:
    said = "Set the cone tin on the board, it gets fired tonight."
    goals = [Goal(parse_condition("On(cone_tin, bisque_board)"), 1, "", Extent(0, 0))]
    (point,) = unclear_names(tokens(said), said, goals, SCENES["studio"])
    assert point.diagnostic.candidates == ("bisque_board", "glost_board")


@pytest.mark.parametrize(
    ("request_", "asks"),
    [
        ("Everything green goes back to the wash stand.", True),
        ("Pick up the red mug and bring it to Mr Brandt.", True),
        ("Fetch the red mug, Sister Adeyemi needs it.", True),
        ("Pick up the red mug.", False),
        ("Pick up the red mug and wait for me.", False),
        ("Take the red mug and don't let go of it.", False),
    ],
)
def test_what_is_only_picked_up(ward: Scene, request_: str, asks: bool) -> None:
    """A reply cut off behind "Pick up the red mug" leaves it in the hand."""
    goals = [Goal(parse_condition("Holding(red_mug)"), 1, "", Extent(0, 0))]
    found = [p.diagnostic.code for p in ungrounded(request_, goals, ward.map, ward.library)]
    assert found == ["E305"] * asks
