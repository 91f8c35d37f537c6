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
    smoothing,
    write_weights,
)


@given(st.lists(st.lists(st.floats(-8, 8, width=32), min_size=3, max_size=3), min_size=1, max_size=6))
def test_a_row_comes_back_within_a_step_of_its_scale(rows: list[list[float]]) -> None:
    matrix = np.array(rows, np.float32)
    stored = quantise(matrix)
    step = np.abs(matrix).max(axis=-1, keepdims=True) / 127
    assert stored.values.dtype == np.int8
    assert stored.scales.dtype == np.float16
    assert (np.abs(stored.widened() - matrix) <= step * 0.6 + 1e-5).all()


def test_outliers_of_the_input_go_into_the_weights() -> None:
    """What is rounded to eight bits is the input times the column scales: there the outlier is small."""
    random = np.random.default_rng(0)
    matrix = random.normal(size=(8, 4)).astype(np.float32)
    largest = np.array([1, 1, 1, 100], np.float32)
    columns = smoothing(largest, matrix)
    evened = largest * columns
    assert evened.max() / evened.min() < 5
    assert np.exp(np.mean(np.log(columns))) == pytest.approx(1)
    stored = quantise(matrix, columns)
    step = np.abs(matrix / columns).max(axis=-1, keepdims=True) / 127 * columns
    assert (np.abs(stored.widened() - matrix) <= step * 0.6 + 1e-5).all()


def test_the_file_gives_back_what_was_written(tmp_path: Path) -> None:
    matrix = np.array([[1.0, -0.5], [0.25, 0.125]], np.float32)
    vector = np.array([3.0, 4.0], np.float32)
    tensors = {EMBEDDINGS: matrix, "classifier.weight": matrix, "classifier.bias": vector}
    columns = {"classifier.weight": np.array([0.5, 2.0], np.float32)}
    for name in ("a", "b"):
        write_weights(tmp_path / name, ModelConfig(vocabulary=2), tensors, {"base": "none"}, columns)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    found = read_weights(tmp_path / "a")
    assert found.config == ModelConfig(vocabulary=2)
    assert found.about["base"] == "none"
    rows = np.array([1, 0, 1])
    assert np.array_equal(found.matrices[EMBEDDINGS].rows(rows), found.widened()[EMBEDDINGS][rows])
    assert np.array_equal(found.matrices["classifier.weight"].columns, columns["classifier.weight"])
    assert found.widened()["classifier.weight"] == pytest.approx(matrix, abs=0.02)
    assert np.array_equal(found.vectors["classifier.bias"], vector)


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


def test_the_shipped_graph_is_the_one_of_the_shipped_shape() -> None:
    """Made again from the shape alone it is the same file."""
    from llmbt_compiler.keywords.encoder import GRAPH, initializers
    from llmbt_compiler.keywords.graph import graph_of

    weights = read_weights(MODEL / "weights.safetensors")
    assert graph_of(weights.config, initializers(weights)) == GRAPH.read_bytes()
