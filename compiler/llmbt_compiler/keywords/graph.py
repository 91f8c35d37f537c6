"""Makes ``model/encoder.onnx``: ``python -m llmbt_compiler.keywords.graph`` (needs the package onnx).

The graph is made from the model's shape alone. All weights are external, under the names of `encoder.initializers`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper

from llmbt_compiler.keywords.encoder import GRAPH, initializers
from llmbt_compiler.keywords.labels import LABELS
from llmbt_compiler.keywords.weights import ModelConfig, read_weights

__all__ = ["Graph", "graph_of"]

_MICROSOFT = "com.microsoft"
_EPSILON = 1e-12


class Graph:
    """Nodes in order; each method adds some and returns the name of what they give."""

    def __init__(self) -> None:
        self.nodes: list[onnx.NodeProto] = []

    def node(self, kind: str, inputs: Sequence[str], out: str, domain: str = "", **attributes: Any) -> str:
        self.nodes.append(helper.make_node(kind, list(inputs), [out], domain=domain, **attributes))
        return out

    def linear(self, x: str, name: str) -> str:
        """int8: the input scaled by column, rounded by its own range, times the weights."""
        smoothed = self.node("Mul", [x, f"{name}.columns"], f"{name}.smoothed")
        inputs = [smoothed, f"{name}.weight", f"{name}.scale", "", f"{name}.bias"]
        return self.node("DynamicQuantizeMatMul", inputs, name, _MICROSOFT)

    def attention(self, x: str, name: str, heads: int, hidden: int) -> str:
        joined = self.linear(x, f"{name}.qkv")
        sizes = helper.make_tensor(f"{name}.sizes", TensorProto.INT64, [3], [hidden] * 3)
        split = self.node("Constant", [], f"{name}.split", value=sizes)
        parts = [f"{name}.{part}" for part in ("query", "key", "value")]
        self.nodes.append(helper.make_node("Split", [joined, split], parts, axis=2))
        return self.node("MultiHeadAttention", parts, f"{name}.context", _MICROSOFT, num_heads=heads)

    def add_norm(self, x: str, residual: str, name: str) -> str:
        inputs = [x, residual, f"{name}.weight", f"{name}.bias"]
        return self.node("SkipLayerNormalization", inputs, name, _MICROSOFT, epsilon=_EPSILON)


def graph_of(config: ModelConfig, given: Mapping[str, NDArray[np.generic]], graph: Graph | None = None) -> bytes:
    """The graph as a file's bytes. `given` are the initializers, for their types and shapes; no value is written."""
    g = graph or Graph()
    x = g.node("LayerNormalization", ["embedded", "embedded.weight", "embedded.bias"], "x", epsilon=_EPSILON)
    for layer in range(config.layers):
        context = g.attention(x, f"{layer}", config.heads, config.hidden)
        x = g.add_norm(g.linear(context, f"{layer}.attended"), x, f"{layer}.attended.norm")
        up = g.node("Gelu", [g.linear(x, f"{layer}.up")], f"{layer}.up.gelu", _MICROSOFT)
        x = g.add_norm(g.linear(up, f"{layer}.down"), x, f"{layer}.down.norm")
    g.node("Add", [g.node("MatMul", [x, "scores.weight"], "unbiased"), "scores.bias"], "scores")
    made = helper.make_graph(
        g.nodes,
        "keywords",
        [helper.make_tensor_value_info("embedded", TensorProto.FLOAT, ["windows", "pieces", config.hidden])],
        [helper.make_tensor_value_info("scores", TensorProto.FLOAT, ["windows", "pieces", len(LABELS)])],
        [_declared(name, value) for name, value in given.items()],
    )
    opsets = [helper.make_opsetid("", 17), helper.make_opsetid(_MICROSOFT, 1)]
    model = helper.make_model(made, opset_imports=opsets, producer_name="llmbt", ir_version=9)
    return bytes(model.SerializeToString(deterministic=True))


def _declared(name: str, value: NDArray[np.generic]) -> onnx.TensorProto:
    tensor = onnx.TensorProto(name=name, data_type=helper.np_dtype_to_tensor_dtype(value.dtype), dims=value.shape)
    tensor.data_location = TensorProto.EXTERNAL
    tensor.external_data.add(key="location", value="weights.safetensors")
    return tensor


def main() -> None:
    """Write the graph of the shipped weights' shape."""
    read = read_weights(GRAPH.with_name("weights.safetensors"))
    GRAPH.write_bytes(graph_of(read.config, initializers(read)))


if __name__ == "__main__":
    main()
