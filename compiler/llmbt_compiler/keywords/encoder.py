"""The model on onnxruntime: int8 matrix products, from the weights file as it is; no torch, no transformers.

``model/encoder.onnx`` is the computation without its weights (`graph` made it, from the shape alone); they are handed
over when it is loaded. Words become embeddings here, in numpy, so that only the rows that a text needs are widened.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.keywords.pieces import Window
from llmbt_compiler.keywords.weights import EMBEDDINGS, Matrix, Weights

__all__ = ["GRAPH", "Encoder", "initializers"]

GRAPH = Path(__file__).parent / "model" / "encoder.onnx"
_POSITIONS = "bert.embeddings.position_embeddings.weight"
_SEGMENTS = "bert.embeddings.token_type_embeddings.weight"


class Encoder:
    """Scores words. Each window is computed by itself, so that it does not depend on its company."""

    def __init__(self, weights: Weights, graph: Path = GRAPH) -> None:
        """Imports onnxruntime (0.1 s). Raises OSError; WeightsError is the reader's."""
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        options.log_severity_level = 3
        self._given = initializers(weights)  # kept: onnxruntime does not copy them
        values = [onnxruntime.OrtValue.ortvalue_from_numpy(v) for v in self._given.values()]
        options.add_external_initializers(list(self._given), values)
        self._session = onnxruntime.InferenceSession(graph.read_bytes(), options, providers=["CPUExecutionProvider"])
        self._words = weights.matrices[EMBEDDINGS]
        around = weights.matrices[_POSITIONS].widened() + weights.matrices[_SEGMENTS].rows(np.array([0]))
        self._around: NDArray[np.float32] = around

    def __call__(self, batch: Sequence[Window]) -> list[NDArray[np.float32]]:
        """The scores of every word's first piece: for each window an array (words x labels)."""
        return [self._scores(window) for window in batch]

    def _scores(self, window: Window) -> NDArray[np.float32]:
        embedded = self._words.rows(np.asarray(window.ids, np.int64))
        embedded += self._around[: len(window.ids)]
        (scores,) = self._session.run(None, {"embedded": embedded[None]})
        found: NDArray[np.float32] = scores[0, list(window.first)]
        return found


def initializers(weights: Weights) -> Mapping[str, NDArray[np.generic]]:
    """What the graph takes from the weights, by its own names, in the shapes that its operators want."""
    out: dict[str, NDArray[np.generic]] = {}
    vectors = weights.vectors

    def norm(name: str, source: str) -> None:
        out[f"{name}.weight"], out[f"{name}.bias"] = vectors[f"{source}.weight"], vectors[f"{source}.bias"]

    def linear(name: str, *sources: str) -> None:
        parts: list[Matrix] = [weights.matrices[f"{s}.weight"] for s in sources]
        out[f"{name}.weight"] = np.ascontiguousarray(np.concatenate([p.values for p in parts]).T)
        out[f"{name}.scale"] = np.concatenate([p.scales for p in parts]).astype(np.float32)
        out[f"{name}.columns"] = parts[0].columns
        out[f"{name}.bias"] = np.concatenate([vectors[f"{s}.bias"] for s in sources])

    norm("embedded", "bert.embeddings.LayerNorm")
    for layer in range(weights.config.layers):
        source = f"bert.encoder.layer.{layer}"
        attention = f"{source}.attention.self"
        linear(f"{layer}.qkv", *(f"{attention}.{n}" for n in ("query", "key", "value")))
        linear(f"{layer}.attended", f"{source}.attention.output.dense")
        norm(f"{layer}.attended.norm", f"{source}.attention.output.LayerNorm")
        linear(f"{layer}.up", f"{source}.intermediate.dense")
        linear(f"{layer}.down", f"{source}.output.dense")
        norm(f"{layer}.down.norm", f"{source}.output.LayerNorm")
    out["scores.weight"] = np.ascontiguousarray(weights.matrices["classifier.weight"].widened().T)
    out["scores.bias"] = vectors["classifier.bias"]
    return out
