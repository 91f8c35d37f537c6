"""Sentences that the tagger does not know the frame of: who is left out, what refers back, passives, reasons, tables.

The labels are those that the tagger gives such steps; a step without any is written plain.
"""

from __future__ import annotations

import pytest

from llmbt_atl.library import Library
from llmbt_compiler.parsing import parse
from llmbt_ir.semantic_map import SemanticMap
from tests.parsing.labelled import steps

Place = tuple[SemanticMap, Library]


def goals(scene: Place, *texts: str) -> set[str]:
    result = parse(steps(*texts), *scene)
    assert result.ok, [d.title for d in result.errors()]
    return {str(c) for c in result.conditions}


def on(**places: str) -> set[str]:
    return {f"On({k}, {v})" for k, v in places.items()}


@pytest.mark.parametrize(
    ("texts", "wanted"),
    [
        (
            ("T[Everything] but the T[green blocks] shall be A[transferred] to D[level 2].",),
            on(object_3="position_21", object_5="position_22", object_6="position_23"),
        ),
        (
            ("With the exception of the green blocks, A[bring] T[everything] to D[level 2].",),
            on(object_3="position_21", object_5="position_22", object_6="position_23"),
        ),
        (
            ("My D[lord] desires that both T[yellow blocks] be placed on level 1.",),
            on(object_3="position_11", object_5="position_12"),
        ),
        (
            ("T[Object 3] has to A[sleep] at D[position 31] tonight, so A[put] T[it] there.",),
            on(object_3="position_31"),
        ),
        (
            ("A[Place] according to this D[table]: object_3 | position_14; object_5 | position_24.",),
            on(object_3="position_14", object_5="position_24"),
        ),
        (
            ("A[Put] T[object 1] and T[object 2] on D[level 1], T[one] in each D[free position].",),
            on(object_1="position_11", object_2="position_12"),
        ),
        (("A[Set] the T[red one], i.e. object 6, on D[position 12].",), on(object_6="position_12")),
        (
            (
                "A[Distribute] T[object 3] and T[object 5]: the T[first one] to D[position 33], "
                "the T[second one] to D[position 34].",
            ),
            on(object_3="position_33", object_5="position_34"),
        ),
        (
            (
                "A[Put] the T[red block] on D[position 11].",
                "A[take] that T[block] off again and A[set] T[it] on D[12].",
            ),
            on(object_6="position_12"),
        ),
        (
            (
                "A[Put] T[object 1] on D[position 21].",
                "A[Take] T[object 1] off L[position 21] and A[put] T[it] aside.",
                "A[Set] T[object 4] D[there] instead.",
            ),
            on(object_1="sorting_area", object_4="position_21"),
        ),
    ],
)
def test_cargo(cargo: Place, texts: tuple[str, ...], wanted: set[str]) -> None:
    assert goals(cargo, *texts) == wanted


@pytest.mark.parametrize(
    ("texts", "wanted"),
    [
        (
            ("A[Put] T[everything] that's on the L[table], apart from the potato chips, on the bar.",),
            on(milk="bar"),
        ),
        (("A[Transfer] the T[whole contents of the table] to the D[bar].",), on(milk="bar", potato_chips="bar")),
        (("A[Take] the T[milk] to the D[desk].", "That goes for the coke as well."), on(milk="desk", coke="desk")),
        (
            ("A[Bring] the T[coke] to the D[desk], but the chips to the D[bar].",),
            on(coke="desk", potato_chips="bar"),
        ),
        (
            ("A[Leave] the T[milk] where it is, but A[take] the T[other things] on the L[table] to the D[bar].",),
            on(potato_chips="bar"),
        ),
    ],
)
def test_household(home: Place, texts: tuple[str, ...], wanted: set[str]) -> None:
    assert goals(home, *texts) == wanted


@pytest.mark.parametrize(
    "text",
    [
        "The coke should join it.",
        "The T[milk] must not be A[placed] on the D[table].",
        "A[Set] the T[green one], i.e. object 6, on D[position 12].",
    ],
)
def test_no_goal_is_made_of_what_is_not_understood_or_forbidden(home: Place, cargo: Place, text: str) -> None:
    scene = cargo if "object" in text else home
    result = parse(steps(text), *scene)
    assert not result.ok or not result.conditions
