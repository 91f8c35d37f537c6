"""Steps over maps whose names are not ours: articles and hyphens in names, nouns told once, words that are verbs
elsewhere. The scenes were written by others (fixtures/requests/README.md)."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_atl.library import Library, load_library
from llmbt_compiler.parsing import ParseResult, parse
from llmbt_compiler.parsing.words import tokens
from llmbt_compiler.stages import tagged
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap

SCENES = Path(__file__).parents[2] / "fixtures" / "requests" / "scenes"


def opened(name: str) -> tuple[SemanticMap, Library]:
    scene = load_scene(str(SCENES / f"{name}.xml"))
    return to_semantic_map(scene), load_library(scene.library)


MAPS = {name: opened(name) for name in ("ward", "watchmaker", "larder", "studio", "counter", "rooms")}


def read(name: str, *steps: str) -> ParseResult:
    return parse(tagged(list(steps), "default"), *MAPS[name])


@pytest.mark.parametrize(
    ("scene", "steps", "goals"),
    [
        ("ward", ["Move everything on the window-side locker except the glasses case to the set-down table."],
         {"On(water_bottle, set_down_table)"}),
        ("ward", ["Put the small and the large dressing pack on the wash stand."],
         {"On(dressing_pack_small, wash_stand)", "On(dressing_pack_large, wash_stand)"}),
        ("ward", ["Swap the small and the large saline bottle."],
         {"On(saline_small, saline_right)", "On(saline_large, saline_left)"}),
        ("ward", ["Put the large saline bottle and the small one on the wash stand."],
         {"On(saline_large, wash_stand)", "On(saline_small, wash_stand)"}),
        ("ward", ["Put the red mug and the white one on the wash stand."],
         {"On(red_mug, wash_stand)", "On(white_mug, wash_stand)"}),
        ("ward", ["Put the morning pill cup in the evening slot and the noon one in the morning slot."],
         {"On(pill_cup_morning, tray_evening)", "On(pill_cup_noon, tray_morning)"}),
        ("ward", ["Take the evening pill cup out of the noon slot and set it in the evening one."],
         {"On(pill_cup_evening, tray_evening)"}),
        ("ward", ["Move the red mug from the door-side locker to the window-side one."],
         {"On(red_mug, window_locker)"}),
        ("ward", ["Collect all the pill cups at the nurses' station."],
         {f"On(pill_cup_{c}, nurses_station)" for c in ("morning", "noon", "evening")}),
        ("ward", ["Put the evening pill cup in the slot to the right of the noon slot."],
         {"On(pill_cup_evening, tray_evening)"}),
        ("ward", ["Put the blue bottle of hand gel on the door-side locker."], {"On(hand_gel, door_locker)"}),
        ("ward", ["Take the bottle of water to Mr Brandt."], {"On(water_bottle, patient_brandt)"}),
        ("watchmaker", ["Lift the benzine bottle.", "Put it in the well to the left of the rinse bottle."],
         {"On(benzine, well_middle)"}),
        ("watchmaker", ["Take the white bottle to the left of the screw tin and put it in the middle well."],
         {"On(shellac, well_middle)"}),
        ("watchmaker", ["Proceed to relocate the going barrel so that it comes to rest upon the timing stand."],
         {"On(going_barrel, timing_stand)"}),
        ("watchmaker", ["Put the strike barrel into berth K so that a new mainspring can be fitted later."],
         {"On(strike_barrel, berth_K)"}),
        ("watchmaker", ["Grasp the putty block and lift it clear of the parts tray."], {"Holding(putty)"}),
        ("watchmaker", ["Leave the alarm clock movement where it is."], set()),
        ("larder", ["Put the butter in a free niche."], {"On(butter, niche_K3)"}),
        ("larder", ["Put the butter in the rightmost well."], {"On(butter, well_right)"}),
        ("larder", ["Put the butter into the well next to the left well."], {"On(butter, well_middle)"}),
        ("larder", ["Move the paprika tin to niche K3.", "Put the cumin tin in the niche where the paprika tin stood."],
         {"On(paprika_tin, niche_K3)", "On(cumin_tin, niche_K1)"}),
        ("studio", ["Place the shino pot, the cone tin and the paddle in the test bay, the tool caddy and the "
                    "damp box, in that order."],
         {"On(shino_pot, test_bay)", "On(cone_tin, tool_caddy)", "On(paddle, damp_box)"}),
        ("studio", ["Put the tenmoku jar in the empty bay of the glaze rack."], {"On(tenmoku_jar, test_bay)"}),
        ("counter", ["8-dram vial -> bin G-M"], {"On(vial_8dr, bin_GM)"}),
        ("counter", ["Reach for the amoxicillin in the suspension nest.", "Close the gripper around it and lift it."],
         {"Holding(amoxicillin)"}),
        ("counter", ["Move the ibuprofen to the last bin on the will-call shelf."], {"On(ibuprofen, bin_TZ)"}),
        ("rooms", ["Put the fan in the third bay of the running rack."], {"On(fan, act_three)"}),
        ("rooms", ["Bring me the ledger."], {"On(ledger, user)"}),
    ],
)  # fmt: skip
def test_what_a_step_means_there(scene: str, steps: list[str], goals: set[str]) -> None:
    assert {str(g.condition) for g in read(scene, *steps).goals} == goals


@pytest.mark.parametrize(
    ("scene", "step"),
    [
        ("ward", "Put the evening pill cup in the slot next to the morning slot."),  # beside it is not on it
        ("larder", "Put the butter to the right."),  # no right well
        ("larder", "Put the butter back in its place."),  # no back ring
        ("watchmaker", "Move the pots one cup to the right."),
    ],
)
def test_what_names_no_place(scene: str, step: str) -> None:
    assert not read(scene, step).goals


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("the window-side locker", ["the", "window", "side", "locker"]),
        ("objects 1-3", ["objects", "1", "-", "3"]),
        ("B-2", ["b", "2"]),
        ("the milk - the cold one", ["the", "milk", "-", "the", "cold", "one"]),
    ],
)
def test_a_compound_is_two_words(text: str, words: list[str]) -> None:
    assert [t.text for t in tokens(text)] == words
