"""Agreement of two annotations, on cases that can be counted by hand."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from llmbt_compiler.keywords.agreement import agreement, draw_texts, kappa, read_annotation
from llmbt_compiler.keywords.evaluate import ExampleError


def annotated(folder: Path, name: str, *lines: str) -> Path:
    path = folder / name
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def test_alike(tmp_path: Path) -> None:
    steps = read_annotation(annotated(tmp_path, "a.txt", "[A Put] the [T red cup] on the [D table].", "Well done."))
    found = agreement(steps, steps)
    assert (found.span_f1, found.whole_step, found.kappa, found.n, found.words) == (1, 1, 1, 2, 8 + 3)


def test_one_span_cut_short(tmp_path: Path) -> None:
    first = read_annotation(annotated(tmp_path, "a.txt", "[A Put] the [T red cup] on the [D table].", "[A Stop]."))
    second = read_annotation(annotated(tmp_path, "b.txt", "[A Stop].", "[A Put] the red [T cup] on the [D table]."))
    found = agreement(first, second)
    assert found.span_f1 == pytest.approx(3 / 4)
    assert found.whole_step == 0.5
    assert 0 < found.kappa < 1


def test_kappa_is_what_the_textbook_says() -> None:
    pairs = [("y", "y")] * 20 + [("y", "n")] * 5 + [("n", "y")] * 10 + [("n", "n")] * 15
    assert kappa(pairs) == pytest.approx(0.4)
    assert kappa([("O", "O")] * 3) == kappa([]) == 1


def test_a_step_that_the_first_lacks(tmp_path: Path) -> None:
    first = read_annotation(annotated(tmp_path, "a.txt", "[A Stop]."))
    with pytest.raises(ExampleError, match="not among"):
        agreement(first, read_annotation(annotated(tmp_path, "b.txt", "[A Go].")))
    with pytest.raises(ExampleError, match=r"c\.txt:2"):
        read_annotation(annotated(tmp_path, "c.txt", "[A Stop].", "[A Go"))


def test_texts_are_drawn_without_their_keywords(tmp_path: Path) -> None:
    lines = [json.dumps({"text": f"Step {i}", "spans": [{"start": 0, "end": 4, "label": "Action"}]}) for i in range(9)]
    path = annotated(tmp_path, "a.jsonl", *lines)
    drawn = draw_texts(path, 4, 7)
    assert drawn == draw_texts(path, 4, 7)
    assert len(set(drawn)) == 4
    assert set(drawn) < {f"Step {i}" for i in range(9)}
    assert len(draw_texts(path, 40, 7)) == 9
    with pytest.raises(ExampleError, match=r"b\.jsonl:1"):
        draw_texts(annotated(tmp_path, "b.jsonl", "[]"), 1, 0)
