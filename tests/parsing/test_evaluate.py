"""How cases are judged, on results that can be judged by hand; and the cases that the repository ships."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from llmbt_atl.library import Library
from llmbt_compiler.keywords.tagger import load_tagger
from llmbt_compiler.parsing import parse
from llmbt_compiler.parsing.evaluate import (
    Case,
    CaseError,
    Intent,
    Verdict,
    evaluate_conditions,
    judge,
    read_cases,
    wilson,
)
from llmbt_ir.condition import Condition
from llmbt_ir.semantic_map import SemanticMap
from tests.parsing.labelled import steps

FIXTURES = Path(__file__).parents[2] / "fixtures" / "parsing"
ON_12 = frozenset({Condition("On", ("object_1", "position_12"))})
ON_13 = frozenset({Condition("On", ("object_1", "position_13"))})


def case(*goals: frozenset[Condition], ask: bool = False) -> Case:
    return Case("cargo", ("",), goals or (frozenset(),), ask)


@pytest.mark.parametrize(
    ("marked", "meant", "verdict"),
    [
        ("A[Place] T[object 1] on D[position 12].", case(ON_12), Verdict.RIGHT),
        ("A[Place] T[object 1] on D[position 12].", case(ON_13, ON_12), Verdict.RIGHT),
        ("A[Place] T[object 1] on D[position 12].", case(ON_13), Verdict.WRONG),
        ("A[Place] T[object 1] on D[position 12].", case(ON_12 | ON_13), Verdict.WRONG),
        ("A[Place] T[object 1].", case(ON_12), Verdict.REFUSED),
        ("A[Wait].", case(ON_12), Verdict.REFUSED),
        ("A[Wait].", case(), Verdict.RIGHT),
        ("A[Unscrew] T[object 1].", case(), Verdict.REFUSED),
        ("A[Place] T[object 1] on D[position 12].", case(), Verdict.WRONG),
        ("A[Place] T[object 1].", case(ask=True), Verdict.RIGHT),
        ("A[Wait].", case(ask=True), Verdict.RIGHT),
        ("A[Place] T[object 1] on D[position 12].", case(ask=True), Verdict.WRONG),
    ],
)
def test_a_result_is_judged(marked: str, meant: Case, verdict: Verdict, cargo: tuple[SemanticMap, Library]) -> None:
    assert judge(meant, parse(steps(marked), *cargo), cargo[0]) is verdict


def test_a_place_may_stand_for_those_in_it(cargo: tuple[SemanticMap, Library]) -> None:
    result = parse(steps("A[Place] T[object 1] on D[position 12]."), *cargo)
    level, other = (frozenset({Condition("On", ("object_1", f"shelf_level_{n}"))}) for n in (1, 2))
    assert judge(Case("cargo", ("x",), (level,), within=True), result, cargo[0]) is Verdict.RIGHT
    assert judge(Case("cargo", ("x",), (level,)), result, cargo[0]) is Verdict.WRONG
    assert judge(Case("cargo", ("x",), (other,), within=True), result, cargo[0]) is Verdict.WRONG


def test_the_interval_is_wilsons() -> None:
    assert wilson(0, 0) == (0, 1)
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)
    assert wilson(0, 100)[0] == 0
    assert wilson(100, 100)[1] == pytest.approx(1)


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("{", "JSONDecodeError"),
        ('{"map": "cargo", "steps": "Put it", "goals": [3]}', "Error"),
        ('{"map": "cargo", "steps": ["Put it"], "goals": ["On(a"]}', "no condition"),
        ('{"map": "cargo", "steps": ["Put it"], "goals": ["On(a, b)"], "ask": true}', "has no goals"),
        ('{"steps": ["Put it"], "goals": []}', "map"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, line: str, complaint: str) -> None:
    path = tmp_path / "mine.jsonl"
    path.write_text('{"map": "cargo", "steps": ["Stop."], "goals": []}\n' + line)
    with pytest.raises(CaseError, match=rf"mine\.jsonl:2: .*{complaint}"):
        read_cases(path)


def test_a_goal_that_the_map_has_not(tmp_path: Path) -> None:
    (tmp_path / "maps").symlink_to(FIXTURES / "maps")
    path = tmp_path / "mine.jsonl"
    path.write_text(json.dumps({"map": "cargo", "steps": ["Stop."], "goals": ["On(object_9, position_12)"]}))
    with pytest.raises(CaseError, match=r"case 1: On\(object_9"):
        evaluate_conditions(path, load_tagger())


def test_the_development_cases() -> None:
    """Looked at while the parser grew, the last 187 of them written to break it: a floor."""
    scores = evaluate_conditions(FIXTURES / "dev.jsonl", load_tagger())
    assert scores.wrong == 0
    assert scores.rate(Verdict.RIGHT) >= 0.96
    assert scores.rate(Verdict.RIGHT, Intent.ASK) == 1
