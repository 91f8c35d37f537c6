"""The figures, on cases that can be counted by hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_compiler.keywords.evaluate import Example, ExampleError, evaluate, read_examples
from llmbt_compiler.keywords.labels import KeywordSpan, Kind

TEXT = "Put the red cup on the table"
PUT = KeywordSpan(0, 3, Kind.ACTION, "Put")
RED_CUP = KeywordSpan(8, 15, Kind.TARGET, "red cup")
CUP = KeywordSpan(12, 15, Kind.TARGET, "cup")
TABLE = KeywordSpan(23, 28, Kind.DESTINATION, "table")


def test_all_right() -> None:
    figures = evaluate([Example(TEXT, (PUT, RED_CUP, TABLE))], [(PUT, RED_CUP, TABLE)])
    assert (figures.scores.f1, figures.whole_step_accuracy, figures.n, figures.wrong) == (1, 1, 1, ())
    assert figures.confusions == {}


def test_a_span_cut_short_is_wrong() -> None:
    figures = evaluate([Example(TEXT, (PUT, RED_CUP, TABLE)), Example(TEXT, (PUT,))], [(PUT, CUP, TABLE), (PUT,)])
    assert figures.scores.precision == figures.scores.recall == pytest.approx(3 / 4)
    assert figures.whole_step_accuracy == 0.5
    assert figures.wrong == (0,)
    assert figures.by_label[Kind.TARGET].f1 == 0
    assert figures.by_label[Kind.ACTION].f1 == 1
    assert figures.confusions == {("B-Target", "O"): 1, ("I-Target", "B-Target"): 1}


def test_nothing_to_find() -> None:
    assert evaluate([Example("Done", ())], [()]).scores.f1 == 1
    assert evaluate([Example(TEXT, ())], [(PUT,)]).scores.f1 == 0
    assert evaluate([], []).whole_step_accuracy == 1


def test_json_has_what_the_command_promises() -> None:
    record = evaluate([Example(TEXT, (PUT,))], [(PUT,)]).as_dict()
    assert {"precision", "recall", "f1", "whole_step_accuracy", "n"} <= set(record)


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("{", "Expecting"),
        ('{"text": 3, "spans": []}', "no string"),
        ('{"text": "Put it", "spans": [{"start": 0, "end": 2, "label": "Action"}]}', "begin and end with a word"),
        ('{"text": "Put it", "spans": [{"start": 0, "end": 3, "label": "Verb"}]}', "Verb"),
        ('{"text": "Put it"}', "spans"),
        ("[]", "list indices"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, line: str, complaint: str) -> None:
    path = tmp_path / "mine.jsonl"
    path.write_text('{"text": "Stop", "spans": []}\n' + line)
    with pytest.raises(ExampleError, match=rf"mine\.jsonl:2: .*{complaint}"):
        read_examples(path)
