"""Which reading is taken: by probability, by what readings come to, and by what the map bears out."""

from __future__ import annotations

import pytest

from llmbt_atl.library import Library
from llmbt_compiler.keywords.labels import Reading
from llmbt_compiler.parsing import LabelledStep, parse
from llmbt_compiler.parsing.weigh import Trial, shares, weigh
from llmbt_ir.semantic_map import SemanticMap
from tests.parsing.labelled import labelled, shown


def trials(*told: tuple[str, float, bool]) -> list[Trial[str]]:
    """(what it comes to, probability, clean)."""
    return [Trial(f"{outcome}#{i}", p, clean, outcome) for i, (outcome, p, clean) in enumerate(told)]


@pytest.mark.parametrize(
    ("told", "taken"),
    [
        ([("a", 0.9, True), ("b", 0.1, True)], "a#0"),
        ([("a", 0.4, True), ("b", 0.3, False), ("a", 0.2, True)], "a#0"),  # together 0.6
        ([("a", 0.35, True), ("b", 0.3, True), ("b", 0.3, True)], None),  # the rival is too strong
        ([("a", 0.2, True), ("b", 0.55, True)], "b#1"),
        ([("a", 0.45, True), ("b", 0.4, True)], None),
        ([("a", 0.4, True), ("b", 0.3, False)], "a#0"),  # nothing else makes sense
        ([("a", 0.3, True), ("b", 0.3, False)], None),  # not sure enough
        ([("a", 0.6, False), ("b", 0.35, True)], "b#1"),  # only this one makes sense on the map
        ([("a", 0.6, False), ("b", 0.1, True)], "a#0"),  # too weak: the complaint stands
        ([("a", 0.6, False), ("b", 0.3, True), ("c", 0.1, True)], "a#0"),  # two that make sense
        ([("a", 0.6, False), ("none", 0.35, True)], "a#0"),  # doing nothing is no way out
        ([("a", 0.6, False)], "a#0"),
        ([("a", 0.3, False)], None),
    ],
)
def test_the_reading_that_is_taken(told: list[tuple[str, float, bool]], taken: str | None) -> None:
    found = weigh(trials(*told), "none", 0.5)
    assert (found.value if found is not None else None) == taken


def test_shares_are_summed_by_words() -> None:
    found = shares(trials(("a", 0.3, True), ("b", 0.4, True), ("a", 0.2, True)), lambda v: v[0])
    assert [(words, pytest.approx(p)) for words, p in found] == [("a", 0.5), ("b", 0.4)]


def wavering(*told: tuple[str, float]) -> LabelledStep:
    """One step with its readings, marked as in the golden files."""
    steps = [labelled(marked) for marked, _ in told]
    readings = tuple(Reading(s.spans, p) for s, (_, p) in zip(steps, told, strict=True))
    return LabelledStep(1, steps[0].text, steps[0].spans, min(p for _, p in told), readings=readings)


def test_readings_that_mean_the_same_count_together(cargo: tuple[SemanticMap, Library]) -> None:
    step = wavering(
        ("A[Place] the T[green block] 2 on D[position 12]", 0.3),
        ("A[Place] the T[green block 2] on D[position 12]", 0.3),
        ("A[Place] the T[green block 2] on L[position 12]", 0.3),
    )
    assert (
        shown(parse([step], *cargo))[0]
        == "goal On(object_2, position_12) <- step 1: Place the green block 2 on position 12"
    )


def test_the_map_decides_where_the_likeliest_reading_makes_no_sense(cargo: tuple[SemanticMap, Library]) -> None:
    step = wavering(
        ("A[Put] T[object 5] on D[position 23] and T[object 6] on position 32", 0.6),
        ("A[Put] T[object 5] on D[position 23] and T[object 6] on D[position 32]", 0.35),
    )
    assert [str(c) for c in parse([step], *cargo).conditions] == [
        "On(object_5, position_23)",
        "On(object_6, position_32)",
    ]


def test_alternatives_are_told(cargo: tuple[SemanticMap, Library]) -> None:
    step = wavering(
        ("A[Move] T[object 1] D[position 12] L[sorting area]", 0.48),
        ("A[Move] T[object 1] L[position 12] D[sorting area]", 0.45),
    )
    (fault,) = parse([step], *cargo).errors()
    assert fault.code == "E306"
    assert "On(object_1, position_12) (0.48); On(object_1, sorting_area) (0.45)" in fault.label
