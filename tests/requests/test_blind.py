"""Requests as JSON lines are read and judged as those of open.xml are; and nothing of them is shown unasked."""

from __future__ import annotations

import json
import sys

import pytest

from llmbt_ir.condition import parse_condition
from llmbt_ir.scene import load_scene, to_semantic_map
from tests.requests.__main__ import main
from tests.requests.blind import read_blind
from tests.requests.decide import same_goals

ROWS = (
    {"id": "x1", "kind": "complete", "request": "Put the red block on position 32.",
     "reply": "1. Place object 6 on position 32.", "goals": ["On(object_6, position_32)"]},
    {"id": "x2", "kind": "unclear", "request": "Put the yellow block on position 21.", "answer": "object 5",
     "reply": "1. Place object 3 on position 21.", "reply_after_answer": "1. Place object 5 on position 21.",
     "candidates": ["object_3", "object_5"], "goals": [["On(object_5, position_21)"]]},
    {"id": "x3", "kind": "impossible", "request": "Put the blue block on position 21.",
     "reply": "1. Place the blue block on position 21."},
    {"id": "x4", "kind": "impossible", "request": "Put the secret block on position 21.",
     "reply": "QUESTION: Which one?"},
)  # fmt: skip


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "blind.jsonl"
    path.write_text("".join(json.dumps({"scene": "cargo_sorting", **row}) + "\n" for row in ROWS))
    return path


def run(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["requests", *map(str, arguments)])
    return main()


def test_totals_alone_are_shown(file, monkeypatch, capsys):
    assert run(monkeypatch, "--blind", file) == 1
    out, err = capsys.readouterr()
    assert "| blind | all | 4 | 3 (75 %) | 1 a question that does not say what is lacking |" in out
    assert not err
    assert "secret" not in out


def test_ids_and_reasons_are_shown_where_they_are_wanted(file, monkeypatch, capsys):
    run(monkeypatch, "--blind", file, "--ids")
    assert capsys.readouterr().err == "x4 (impossible): a question that does not say what is lacking\n"


def test_a_line_that_is_none_is_told_by_its_number(tmp_path):
    path = tmp_path / "blind.jsonl"
    path.write_text(json.dumps({"scene": "s", **ROWS[0]}) + "\n" + '{"secret": 1}\n')
    with pytest.raises(ValueError, match=r"^line 2: KeyError$"):
        read_blind(path)


@pytest.mark.parametrize(
    ("goals", "alternatives"),
    [
        (["On(a, b)", "On(c, d)"], {"On(a, b); On(c, d)"}),
        ([["On(a, b)"], ["On(c, d)", "On(e, f)"]], {"On(a, b)", "On(c, d); On(e, f)"}),
        ({"any": [["On(a, b)"], "On(c, d)"]}, {"On(a, b)", "On(c, d)"}),
        (["On(a, b)", ["On(c, d)", "On(c, e)"]], {"On(a, b); On(c, d)", "On(a, b); On(c, e)"}),
        ([], set()),
    ],
)
def test_alternatives(goals, alternatives, tmp_path):
    path = tmp_path / "blind.jsonl"
    path.write_text(json.dumps({"scene": "s", **ROWS[0], "goals": goals}))
    assert {"; ".join(sorted(map(str, g))) for g in read_blind(path)[0].goals} == alternatives


@pytest.mark.parametrize(
    ("decided", "wanted", "same"),
    [
        ("On(object_2, position_11)", "On(object_2, shelf_level_1)", True),
        ("On(object_2, position_21)", "On(object_2, shelf_level_1)", False),
        ("On(object_2, position_11); On(object_1, position_12)", "On(object_2, position_11)", True),
        ("On(object_2, position_11)", "On(object_2, position_11); On(object_1, position_12)", True),
        ("On(object_1, position_11)", "On(object_1, position_11); On(object_1, position_12)", False),
        ("On(object_2, position_11)", "On(object_2, position_11); On(object_4, position_14)", False),
        ("On(object_2, position_11); On(object_4, position_14)", "On(object_2, position_11)", False),
    ],
)
def test_goals_in_other_words(decided, wanted, same):
    """In cargo_swap object 1 stands on position 12."""
    semantic_map = to_semantic_map(load_scene("cargo_swap"))
    both = (frozenset(map(parse_condition, text.split("; "))) for text in (decided, wanted))
    assert same_goals(*both, semantic_map) is same
