"""The ledger is whole after a kill, belongs to one plan, and counts nothing twice."""

from __future__ import annotations

import json

import pytest

from llmbt.experiment.ledger import TRIALS, Ledger, read_plan, read_trials
from llmbt_ir.diagnostics import LlmbtError

HEADER = {"kind": "paper", "seed": 1}


def test_lines_are_there_for_another_reader_at_once(tmp_path):
    ledger = Ledger.begin(tmp_path / "e", HEADER)
    for k in range(3):
        ledger.add({"key": f"t{k}", "says": "é"})
        assert [x["key"] for x in read_trials(tmp_path / "e")] == [f"t{i}" for i in range(k + 1)]
    assert read_plan(tmp_path / "e") == HEADER


def test_none_is_counted_twice(tmp_path):
    ledger = Ledger.begin(tmp_path, HEADER)
    ledger.add({"key": "t"})
    with pytest.raises(ValueError, match="there already"):
        ledger.add({"key": "t"})


@pytest.mark.parametrize("cut", range(1, 16))
def test_a_kill_at_any_byte_of_a_line_loses_that_line_only(tmp_path, cut):
    ledger = Ledger.begin(tmp_path, HEADER)
    ledger.add({"key": "one"})
    ledger.add({"key": "two"})
    path = tmp_path / TRIALS
    whole = path.read_bytes()
    path.write_bytes(whole[:-cut])
    again = Ledger.go_on(tmp_path, HEADER)
    assert set(again.lines) == {"one"}
    again.add({"key": "two"})
    assert path.read_bytes() == whole


def test_another_plan_is_refused(tmp_path):
    Ledger.begin(tmp_path, HEADER)
    with pytest.raises(LlmbtError, match=r"E404.*seed"):
        Ledger.go_on(tmp_path, HEADER | {"seed": 2})


def test_no_experiment_and_a_damaged_line_are_told(tmp_path):
    with pytest.raises(LlmbtError, match="E405"):
        read_plan(tmp_path)
    Ledger.begin(tmp_path, HEADER)
    (tmp_path / TRIALS).write_text(json.dumps({"key": "a"}) + "\nrubbish\n" + json.dumps({"key": "b"}) + "\n")
    with pytest.raises(LlmbtError, match="E406") as caught:
        Ledger.go_on(tmp_path, HEADER)
    assert caught.value.diagnostics[0].span.line == 2
