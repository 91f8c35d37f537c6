"""Weights: int8 rows and back, the file, and what is in the one that is shipped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_compiler.keywords.tagger import MODEL
from llmbt_compiler.keywords.weights import (
    EMBEDDINGS,
    ModelConfig,
    WeightsError,
    quantise,
    read_weights,
    widen,
    write_weights,
)


@given(st.lists(st.lists(st.floats(-8, 8, width=32), min_size=3, max_size=3), min_size=1, max_size=6))
def test_a_row_comes_back_within_a_step_of_its_scale(rows: list[list[float]]) -> None:
    matrix = np.array(rows, np.float32)
    values, scales = quantise(matrix)
    step = np.abs(matrix).max(axis=-1, keepdims=True) / 127
    assert values.dtype == np.int8
    assert scales.dtype == np.float16
    assert (np.abs(widen(values, scales) - matrix) <= step * 0.6 + 1e-5).all()


def test_the_file_gives_back_what_was_written(tmp_path: Path) -> None:
    matrix = np.array([[1.0, -0.5], [0.25, 0.125]], np.float32)
    vector = np.array([3.0, 4.0], np.float32)
    tensors = {EMBEDDINGS: matrix, "classifier.weight": matrix, "classifier.bias": vector}
    for name in ("a", "b"):
        write_weights(tmp_path / name, ModelConfig(vocabulary=2), tensors, {"base": "none"})
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    lazy, whole = (read_weights(tmp_path / "a", widen_embeddings=w) for w in (False, True))
    assert lazy.config == ModelConfig(vocabulary=2)
    assert lazy.about["base"] == "none"
    assert EMBEDDINGS not in lazy.tensors
    rows = np.array([1, 0, 1])
    assert np.array_equal(lazy.rows(EMBEDDINGS, rows), whole.tensors[EMBEDDINGS][rows])
    assert np.array_equal(lazy.tensors["classifier.bias"], vector)


@pytest.mark.parametrize("content", [b"", b"nonsense", b"\x08\0\0\0\0\0\0\0{}      "])
def test_what_is_no_weights_file_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "w").write_bytes(content)
    with pytest.raises(WeightsError, match="holds no keyword tagger"):
        read_weights(tmp_path / "w")


def test_the_shipped_file_is_small_and_says_where_it_is_from() -> None:
    path = MODEL / "weights.safetensors"
    assert path.stat().st_size < 24e6
    assert "Apache-2.0" in read_weights(path).about["base"]
    assert (MODEL / "MODEL_CARD.md").is_file()
