"""Taggers on the same weights, timed in this process: wall and CPU time of tagging sixteen steps, once loaded.

`default` is what `llmbt compile` uses (onnxruntime, int8). Beside it: the reference (torch, float32), torch with
dynamically quantised matrices, and onnxruntime in float32, whose graph is made here (needs the package onnx).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.keywords.evaluate import evaluate, read_examples
from llmbt_compiler.keywords.labels import TaggedStep
from llmbt_compiler.keywords.pieces import WordPiece, read_vocabulary
from llmbt_compiler.keywords.tagger import MODEL, load_tagger, tag_with
from llmbt_compiler.keywords.weights import EMBEDDINGS, read_weights

STEPS = [f"Pick up object {i} (green block) and place it on position {i + 10} on shelf level 1." for i in range(1, 17)]
DEV = Path(__file__).resolve().parents[2] / "fixtures" / "keywords" / "dev.jsonl"
RUNS = 15
Tag = Callable[[Sequence[str]], tuple[TaggedStep, ...]]


def taggers() -> dict[str, Tag]:
    """By name; without onnx, one fewer."""
    import torch

    from llmbt_compiler.keywords import torch_model

    torch.set_num_threads(1)
    weights = read_weights(MODEL / "weights.safetensors")
    model = torch_model.build(weights.config, weights.widened())
    small = torch.ao.quantization.quantize_dynamic(model, {torch.nn.Linear}, dtype=torch.qint8)
    cut = WordPiece(read_vocabulary(MODEL / "vocab.txt"))
    found: dict[str, Tag] = {
        "default (onnxruntime int8)": load_tagger("default").tag,
        "torch (the reference)": load_tagger("torch").tag,
        "torch int8, dynamic": lambda texts: tag_with(texts, cut, lambda batch: torch_model.forward(small, batch)),
    }
    try:
        found["onnxruntime float32"] = _precise()
    except ImportError:
        print("onnxruntime float32: not measured, the package onnx is not installed")
    return found


def _precise() -> Tag:
    """The same graph with float32 matrices."""
    import onnxruntime

    from llmbt_compiler.keywords.encoder import initializers
    from llmbt_compiler.keywords.graph import Graph, graph_of

    class Precise(Graph):
        def linear(self, x: str, name: str) -> str:
            product = self.node("MatMul", [x, f"{name}.weight"], f"{name}.product")
            return self.node("Add", [product, f"{name}.bias"], name)

    weights = read_weights(MODEL / "weights.safetensors")
    given = dict(initializers(weights))
    for name in [n.removesuffix(".scale") for n in given if n.endswith(".scale")]:
        whole = given[f"{name}.weight"].astype(np.float32) * given.pop(f"{name}.scale")
        given[f"{name}.weight"] = np.ascontiguousarray(whole * given.pop(f"{name}.columns")[:, None])
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    values = [onnxruntime.OrtValue.ortvalue_from_numpy(v) for v in given.values()]
    options.add_external_initializers(list(given), values)
    graph = graph_of(weights.config, given, Precise())
    session = onnxruntime.InferenceSession(graph, options, providers=["CPUExecutionProvider"])
    widened = weights.widened()
    around = widened["bert.embeddings.position_embeddings.weight"] + widened[
        "bert.embeddings.token_type_embeddings.weight"
    ][0]  # fmt: skip
    cut = WordPiece(read_vocabulary(MODEL / "vocab.txt"))

    def scores(window: object) -> NDArray[np.float32]:
        ids, first = np.asarray(window.ids), list(window.first)  # type: ignore[attr-defined]
        embedded = weights.matrices[EMBEDDINGS].rows(ids) + around[: len(ids)]
        return session.run(None, {"embedded": embedded[None]})[0][0, first]  # type: ignore[no-any-return]

    return lambda texts: tag_with(texts, cut, lambda batch: [scores(w) for w in batch])


def measure() -> None:
    """One line a tagger: milliseconds for the sixteen steps (least and median), and F1 on the development steps."""
    examples = read_examples(DEV)
    print(f"{'':<28}{'wall ms: least, median':>26}{'CPU ms: least':>16}{'F1, development':>18}")
    for name, tag in taggers().items():
        tag(STEPS)
        wall, cpu = [], []
        for _ in range(RUNS):
            start, spent = time.perf_counter(), time.process_time()
            tag(STEPS)
            wall.append(1000 * (time.perf_counter() - start))
            cpu.append(1000 * (time.process_time() - spent))
        f1 = evaluate(examples, [t.spans for t in tag([e.text for e in examples])]).scores.f1
        print(f"{name:<28}{min(wall):>17.1f}{sorted(wall)[RUNS // 2]:>9.1f}{min(cpu):>16.1f}{f1:>18.3f}")
    pieces = sum(len(WordPiece(read_vocabulary(MODEL / "vocab.txt"))(w)) for s in STEPS for w in s.split())
    print(f"16 steps, some {pieces} pieces of words; one thread, least and median of {RUNS} runs")
