"""Names by where things stand, grounded in the cargo scenes (metres as in scenes/*.xml; the robot looks along x)."""

from __future__ import annotations

import pytest

from llmbt_atl.library import load_library
from llmbt_compiler.parsing import parse
from llmbt_ir.scene import load_scene, to_semantic_map
from tests.parsing.labelled import steps

LIBRARY = load_library("cargo_sorting")
MAPS = {name: to_semantic_map(load_scene(name)) for name in ("cargo_sorting", "cargo_swap", "cargo_sizes")}


def read(scene, *marked):
    return parse(steps(*marked), MAPS[scene], LIBRARY)


def goals(scene, *marked):
    found = read(scene, *marked)
    assert found.ok, found.diagnostics
    return [str(c) for c in found.conditions]


def refusal(scene, *marked):
    found = read(scene, *marked)
    assert not found.ok
    assert not found.goals or found.exit_code
    return found.diagnostics[0].code, found.diagnostics[0].candidates


# object_1 stands on position_12 and object_3 on position_22; the others lie in the sorting area:
#     farther   object_5  object_2
#     nearer    object_6  object_4
DESTINATIONS = [
    ("A[Place] T[object 2] to the left of D[object 1].", "position_11"),
    ("A[Place] T[object 2] directly to the right of D[object 1].", "position_13"),
    ("A[Place] T[object 2] on the right-hand side of D[object 1].", "position_13"),
    ("A[Put] T[object 2] behind D[object 1].", "position_32"),
    ("A[Place] T[object 2] on the D[position] left of D[position 14].", "position_13"),
    ("A[Place] T[object 2] on the D[position] to the right of D[object 3].", "position_23"),
    ("A[Place] T[object 2] on the D[position between] D[position 12] and D[position 14].", "position_13"),
    ("A[Place] T[object 2] between D[object 1] and D[position 14].", "position_13"),
    ("A[Place] T[object 2] next to D[object 1].", "position_11"),
    ("A[Place] T[object 2] beside D[object 3] on D[shelf level 2].", "position_21"),
    ("A[Place] T[object 2] on the D[leftmost free position of level 3].", "position_31"),
    ("A[Place] T[object 2] on the D[second position] from the left on shelf level 2.", "position_22"),
    ("A[Place] T[object 2] at the D[right end of shelf level 1].", "position_14"),
    ("A[Place] T[object 2] on the D[free position] closest to D[object 1].", None),
    ("A[Place] T[object 2] on the D[level] above D[level 1].", "position_21"),
    ("A[Place] T[object 2] to the left of D[object 1], on D[position 11].", "position_11"),
    ("A[Place] T[object 2] on D[position 13], to the right of D[object 1].", "position_13"),
    ("A[Place] T[object 2] next to D[object 1] (D[position 13]).", "position_13"),
]


@pytest.mark.parametrize(("step", "place"), [d for d in DESTINATIONS if d[1]])
def test_destinations(step, place):
    assert goals("cargo_swap", step) == [f"On(object_2, {place})"]


REFERENTS = [
    ("A[Put] the T[block] left of L[object 2] on D[position 34].", "object_5"),
    ("A[Put] the T[block] that is to the left of L[object 2] on D[position 34].", "object_5"),
    ("A[Put] the T[block] in front of L[object 2] on D[position 34].", "object_4"),
    ("A[Put] the T[block] between L[position 11] and L[position 13] on D[position 34].", "object_1"),
    ("A[Put] the T[block nearest] to L[position 11] on D[position 34].", "object_1"),
    ("A[Put] the T[leftmost yellow block] on D[position 34].", "object_5"),
    ("A[Put] the T[rightmost red block] on D[position 34].", "object_6"),
    ("A[Put] the T[yellow block] on the left on D[position 34].", "object_5"),
    ("A[Put] the T[green block] next to L[object 5] on D[position 34].", "object_2"),
]


@pytest.mark.parametrize(("step", "thing"), REFERENTS)
def test_referents(step, thing):
    assert goals("cargo_swap", step) == [f"On({thing}, position_34)"]


BY_SIZE = [
    ("A[Put] the T[smallest block] on D[position 34].", "object_4"),
    ("A[Put] the T[second smallest block] on D[position 34].", "object_5"),
    ("A[Put] the T[largest green block] on D[position 34].", "object_2"),
    ("A[Put] the T[bigger yellow block] on D[position 34].", "object_3"),
]


@pytest.mark.parametrize(("step", "thing"), BY_SIZE)
def test_by_size(step, thing):
    assert goals("cargo_sizes", step) == [f"On({thing}, position_34)"]


ORDERS = [
    ("A[Arrange] the T[green blocks] from L[small] to D[large] on D[shelf level 1].", "4 1 2", "11 12 13"),
    ("A[Arrange] the T[green blocks] from the largest to the smallest on D[level 1].", "2 1 4", "11 12 13"),
    ("A[Sort] the T[green blocks] by size on D[level 1], smallest on the right.", "4 1 2", "14 13 12"),
    ("A[Line] up the T[green blocks] on D[level 2].", "1 2 4", "21 22 23"),
    ("A[Place] T[objects 4, 2 and 1] from left to right on D[level 1].", "4 2 1", "11 12 13"),
    ("A[Place] T[objects 4, 2 and 1] on D[positions 21, 22 and 23] from right to left.", "4 2 1", "21 22 23"),
    ("A[Arrange] the T[green blocks] in ascending order of size on D[positions 24, 23 and 22].", "4 1 2", "22 23 24"),
    ("A[Place] the T[yellow blocks] side by side on D[level 3].", "3 5", "32 33"),
]


@pytest.mark.parametrize(("step", "things", "places"), ORDERS)
def test_orders(step, things, places):
    expected = [f"On(object_{t}, position_{p})" for t, p in zip(things.split(), places.split(), strict=True)]
    assert goals("cargo_sizes", step) == expected


def test_the_papers_limitation_sorted_by_colour_and_in_order_on_each_level():
    """Section V.C: objects go to their layer "without arranging them in a specific order"; here they are arranged."""
    found = goals(
        "cargo_sizes",
        "A[Place] the T[green blocks] on D[shelf level 1].",
        "A[Arrange] T[them] there from L[small] to D[large].",
        "A[Arrange] the T[yellow blocks] on D[shelf level 2], the smallest on the left.",
        "A[Put] the T[red block] to the right of D[position 31].",
    )
    assert set(found) == {
        "On(object_4, position_11)",
        "On(object_1, position_12)",
        "On(object_2, position_13)",
        "On(object_5, position_21)",
        "On(object_3, position_22)",
        "On(object_6, position_32)",
    }


def test_what_the_steps_before_have_done_counts():
    assert goals(
        "cargo_swap",
        "A[Place] T[object 2] on D[position 33].",
        "A[Place] T[object 5] to its left and T[object 4] to the right of D[object 2].",
    ) == ["On(object_2, position_33)", "On(object_5, position_32)", "On(object_4, position_34)"]
    assert goals("cargo_swap", "A[Place] T[object 2] on D[position 33].", "A[Place] T[object 5] next to D[it].") == [
        "On(object_2, position_33)",
        "On(object_5, position_32)",
    ]


REFUSED = [
    ("the position is taken", "A[Put] T[object 2] in front of D[object 3].", "E308", ()),
    ("two positions are next to it", "A[Place] T[object 2] on the D[empty position] next to D[object 3].", "E304",
     ("position_21", "position_23")),
    ("two stand on the left", "A[Put] the T[leftmost green block] on D[position 34].", "E304",
     ("object_2", "object_4")),
    ("they are equally large", "A[Put] the T[largest green block] on D[position 34].", "E304",
     ("object_1", "object_2", "object_4")),
    ("none stands there", "A[Put] the T[yellow block] left of L[object 5] on D[position 34].", "E301",
     ("object_3", "object_5")),
    ("nothing stands on it", "A[Put] the T[block] on top of L[object 1] on D[position 34].", "E301", None),
    ("the sorting area has no positions", "A[Place] T[object 1] to the left of D[object 2].", "E309",
     ("sorting_area",)),
    ("words and map differ", "A[Place] T[object 2] to the left of D[object 1], on D[position 13].", "E307",
     ("position_13", "position_11")),
    ("the landmark is ambiguous", "A[Place] T[object 2] next to the D[green block].", "E304", None),
    ("the landmark is unknown", "A[Place] T[object 2] next to the D[blue block].", "E301", None),
    ("too many for one level", "A[Arrange] the T[blocks] in a D[row] on D[level 2].", "E308", None),
    ("no such order", "A[Arrange] the T[blocks] in a D[row] by colour on D[level 2].", "E309", None),
    ("where to", "A[Arrange] the T[blocks] from left to right.", "E305", None),
    ("between one thing and nothing", "A[Place] T[object 2] between D[object 1].", "E305", None),
    ("it points to nothing", "A[Place] T[object 2] next to D[it].", "E305", None),
]  # fmt: skip


@pytest.mark.parametrize(("step", "code", "candidates"), [r[1:] for r in REFUSED], ids=[r[0] for r in REFUSED])
def test_nothing_is_guessed(step, code, candidates):
    found = refusal("cargo_swap", step)
    assert found[0] == code
    assert candidates is None or found[1] == candidates


def test_a_viewer_turns_left_and_right_round():
    from dataclasses import replace
    from math import pi

    from llmbt_ir.geometry import Viewpoint

    guest = replace(MAPS["cargo_swap"], viewpoint=Viewpoint("guest", (2.0, 0.0, 0.0), pi))
    found = parse(steps("A[Place] T[object 2] to the left of D[object 1]."), guest, LIBRARY)
    assert [str(c) for c in found.conditions] == ["On(object_2, position_13)"]


def test_a_map_without_coordinates_is_told():
    from dataclasses import replace

    bare = replace(MAPS["cargo_swap"], places=tuple(replace(p, surface_m=None) for p in MAPS["cargo_swap"].places))
    found = parse(steps("A[Place] T[object 2] to the left of D[position 12]."), bare, LIBRARY)
    assert found.diagnostics[0].code == "E309"


def test_notes_say_what_was_understood():
    found = read("cargo_swap", "A[Put] the T[block] left of L[object 2] next to D[object 1].")
    assert [n.text for n in found.notes] == [
        "`next to object 1`: position_11 of position_11, position_13",
        "`block left of object 2`: object_5",
    ]
