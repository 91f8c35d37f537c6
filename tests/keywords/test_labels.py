"""The labels say what the spans say: `encode` and `decode` are each other's inverse."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_compiler.keywords.decoding import best_path
from llmbt_compiler.keywords.labels import (
    LABELS,
    KeywordSpan,
    Kind,
    Label,
    SpanError,
    Word,
    decode,
    encode,
    follows,
    kind_of,
    repair,
    split,
)

words = st.text(alphabet="abcXYZ019éß_", min_size=1, max_size=6)
texts = st.lists(words | st.sampled_from([",", ".", "(", ")", "**", "T-shirt", "A.4", "it's", "–"]), max_size=12).map(
    " ".join
)


@st.composite
def labelled(draw: st.DrawFn) -> tuple[str, tuple[Word, ...]]:
    """A text and grammatical labels for its words."""
    text = draw(texts)
    out: list[Word] = []
    for word in split(text):
        allowed = [x for x in LABELS if follows(out[-1].label if out else None, x)]
        out.append(Word(word.text, word.start, word.end, draw(st.sampled_from(allowed))))
    return text, tuple(out)


@given(labelled())
def test_encode_undoes_decode(case: tuple[str, tuple[Word, ...]]) -> None:
    text, tagged = case
    assert encode(text, decode(text, tagged)) == tagged


@given(labelled())
def test_decode_undoes_encode(case: tuple[str, tuple[Word, ...]]) -> None:
    text, tagged = case
    spans = decode(text, tagged)
    assert decode(text, encode(text, spans)) == spans


@given(labelled())
def test_spans_are_in_order_and_apart(case: tuple[str, tuple[Word, ...]]) -> None:
    text, tagged = case
    spans = decode(text, tagged)
    assert all(a.end <= b.start for a, b in pairwise(spans))
    assert all(s.text == text[s.start : s.end] and s.text.strip() == s.text for s in spans)


@given(st.lists(st.sampled_from(LABELS)))
def test_repair_makes_labels_grammatical_and_keeps_kinds(labels: list[Label]) -> None:
    fixed = repair(labels)
    assert all(follows(a, b) for a, b in zip((None, *fixed), fixed, strict=False))
    assert [kind_of(a) for a in fixed] == [kind_of(a) for a in labels]
    assert repair(fixed) == fixed


@given(st.text())
def test_words_cover_all_that_is_no_space(text: str) -> None:
    found = split(text)
    assert "".join(w.text for w in found) == "".join(text.split())
    assert all(text[w.start : w.end] == w.text for w in found)


@given(st.lists(st.lists(st.floats(-20, 0), min_size=8, max_size=8), max_size=6))
def test_the_best_path_is_grammatical_and_beats_every_other(rows: list[list[float]]) -> None:
    import numpy as np

    scores = np.array(rows).reshape(-1, 8)
    path = best_path(scores)
    assert len(path) == len(rows)
    assert all(follows(a, b) for a, b in zip((None, *path), path, strict=False))
    free = [LABELS[int(k)] for k in scores.argmax(axis=-1)]
    total = sum(scores[i, LABELS.index(x)] for i, x in enumerate(path))
    fixed = sum(scores[i, LABELS.index(x)] for i, x in enumerate(repair(free)))
    assert total >= fixed - 1e-9


def test_an_i_without_its_b_begins_a_span() -> None:
    text = "red cup green table"
    tagged = [
        Word(w.text, w.start, w.end, x)
        for w, x in zip(
            split(text),
            (Label.I_TARGET, Label.I_TARGET, Label.I_DESTINATION, Label.I_DESTINATION),
            strict=True,
        )
    ]
    assert [(s.label, s.text) for s in decode(text, tagged)] == [
        (Kind.TARGET, "red cup"),
        (Kind.DESTINATION, "green table"),
    ]


@pytest.mark.parametrize(
    ("spans", "complaint"),
    [
        ([(0, 2, Kind.ACTION)], "does not begin and end with a word"),
        ([(0, 7, Kind.ACTION)], "has more than one word"),
        ([(5, 7, Kind.TARGET), (5, 11, Kind.TARGET)], "overlaps"),
    ],
)
def test_a_span_that_no_labels_can_say(spans: list[tuple[int, int, Kind]], complaint: str) -> None:
    text = "Pick up the cup"
    with pytest.raises(SpanError, match=complaint):
        encode(text, [KeywordSpan(a, b, kind, text[a:b]) for a, b, kind in spans])


def test_marks_inside_a_word_belong_to_it() -> None:
    assert [w.text for w in split("the T-shirt in A.4, WP_05 and **obj_7**")] == [
        "the", "T-shirt", "in", "A.4", ",", "WP_05", "and", "*", "*", "obj_7", "*", "*",
    ]  # fmt: skip
