"""Decoding, against the definition: every grammatical sequence counted one by one."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llmbt_compiler.keywords.decoding import best_path, best_paths, certain_path, log_softmax, marginals
from llmbt_compiler.keywords.labels import LABELS, Label, follows


def scores(words: int) -> st.SearchStrategy[np.ndarray]:  # type: ignore[type-arg]
    row = st.lists(st.floats(-6, 6, width=32), min_size=len(LABELS), max_size=len(LABELS))
    return st.lists(row, min_size=words, max_size=words).map(lambda rows: log_softmax(np.array(rows, np.float32)))


def everything(log_p: np.ndarray) -> dict[tuple[Label, ...], float]:  # type: ignore[type-arg]
    """All grammatical sequences with their probabilities."""
    weights = {
        labels: float(np.exp(sum(log_p[i, LABELS.index(x)] for i, x in enumerate(labels))))
        for labels in product(LABELS, repeat=len(log_p))
        if all(follows(a, b) for a, b in zip((None, *labels), labels, strict=False))
    }
    total = sum(weights.values())
    return {labels: w / total for labels, w in weights.items()}


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 3).flatmap(scores))
def test_against_the_definition(log_p: np.ndarray) -> None:  # type: ignore[type-arg]
    truth = everything(log_p)
    ranked = sorted(truth.values(), reverse=True)
    assert truth[best_path(log_p)] == pytest.approx(ranked[0])
    found = best_paths(log_p, 5, floor=0.0)
    assert [p for _, p in found] == pytest.approx(ranked[:5])
    assert all(truth[labels] == pytest.approx(p) for labels, p in found)
    plain = certain_path(log_p, 0.5)
    assert plain is None or plain == best_path(log_p)
    p = marginals(log_p)
    for i in range(len(log_p)):
        for k, label in enumerate(LABELS):
            share = sum(w for labels, w in truth.items() if labels[i] is label)
            assert p[i, k] == pytest.approx(share, abs=1e-9)


def test_a_word_that_cannot_go_on_begins_for_certain() -> None:
    """The model wavers between B- and I-, but nothing stands before: the grammar settles it."""
    row = np.full(len(LABELS), -9.0, np.float32)
    row[LABELS.index(Label.I_TARGET)], row[LABELS.index(Label.B_TARGET)] = 5.0, 2.0
    log_p = log_softmax(row[None])
    assert certain_path(log_p, 0.5) is None
    assert best_path(log_p) == (Label.B_TARGET,)
    assert marginals(log_p)[0, LABELS.index(Label.B_TARGET)] > 0.99


def test_no_words() -> None:
    empty = np.zeros((0, len(LABELS)))
    assert best_path(empty) == ()
    assert certain_path(empty, 0.9) is None
    assert best_paths(empty, 3) == (((), 1.0),)
    assert marginals(empty).shape == (0, len(LABELS))
