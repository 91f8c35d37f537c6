"""Taggers: steps in, words with their labels out.

`load_tagger("default")` is the fastest that gives the reference's labels; ``"torch"`` is the reference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.keywords.decoding import best_path, best_paths, certain_path, log_softmax, marginals
from llmbt_compiler.keywords.labels import LABELS, Label, Reading, TaggedStep, Word, decode, split
from llmbt_compiler.keywords.pieces import Window, WordPiece, read_vocabulary, windows
from llmbt_compiler.keywords.slips import respelt
from llmbt_compiler.keywords.weights import read_weights

__all__ = [
    "MODEL",
    "OnnxTagger",
    "Tagger",
    "TorchTagger",
    "UnknownTaggerError",
    "load_tagger",
    "tagger_names",
]

MODEL = Path(__file__).parent / "model"
"""The shipped weights and vocabulary."""

_BATCH = 16
_READINGS = 12
_CERTAIN = 0.97
"""A step all of whose words are at least this sure has one reading, and the model's own probabilities."""
_LONG = 400
"""Words; a longer step has one reading."""


class Tagger(Protocol):
    """Gives every step its words, labelled, and its keywords; as many results as texts, in their order."""

    def tag(self, texts: Sequence[str]) -> tuple[TaggedStep, ...]:
        """Never raises for a text, whatever is in it."""
        ...


class UnknownTaggerError(ValueError):
    """No tagger has that name."""


class OnnxTagger:
    """The fast path: the shipped int8 weights on onnxruntime, WordPiece in plain Python."""

    def __init__(self, folder: Path = MODEL) -> None:
        """Reads ``weights.safetensors`` and ``vocab.txt``. Raises OSError, WeightsError."""
        from llmbt_compiler.keywords.encoder import Encoder

        self._encoder = Encoder(read_weights(folder / "weights.safetensors"))
        self._cut = WordPiece(read_vocabulary(folder / "vocab.txt"))

    def tag(self, texts: Sequence[str]) -> tuple[TaggedStep, ...]:
        """See `Tagger`."""
        return tag_with(texts, self._cut, self._encoder)


class TorchTagger:
    """The reference: `transformers.BertForTokenClassification` and `BertTokenizer` on the same weights, in float32."""

    def __init__(self, folder: Path = MODEL) -> None:
        """Imports torch and transformers, which takes seconds. Raises OSError, WeightsError."""
        from llmbt_compiler.keywords import torch_model

        weights = read_weights(folder / "weights.safetensors")
        self._cut = torch_model.word_cutter(folder / "vocab.txt")
        self._model = torch_model.build(weights.config, weights.widened())
        self._forward = torch_model.forward

    def tag(self, texts: Sequence[str]) -> tuple[TaggedStep, ...]:
        """See `Tagger`."""
        return tag_with(texts, self._cut, lambda batch: self._forward(self._model, batch))


_TAGGERS: dict[str, Callable[[Path], Tagger]] = {
    "default": OnnxTagger,
    "torch": TorchTagger,
}


def tagger_names() -> tuple[str, ...]:
    """What `load_tagger` knows."""
    return tuple(_TAGGERS)


def load_tagger(name: str = "default", folder: Path = MODEL) -> Tagger:
    """A tagger by name, on the shipped weights or those of another folder (what `train` writes).

    A path in place of the name is such a folder. The weights are read once in a process, as long as their file stays
    what it was. Raises UnknownTaggerError, WeightsError, OSError.
    """
    if name not in _TAGGERS:
        if not (Path(name) / "weights.safetensors").is_file():
            raise UnknownTaggerError(f"unknown tagger `{name}`; there are {', '.join(_TAGGERS)}, or a trained folder")
        name, folder = "default", Path(name)
    weights = Path(folder) / "weights.safetensors"
    return _loaded(name, Path(folder), weights.stat().st_mtime_ns if weights.exists() else 0)


@lru_cache(maxsize=2)
def _loaded(name: str, folder: Path, _written_ns: int) -> Tagger:
    return _TAGGERS[name](folder)


def tag_with(
    texts: Sequence[str],
    cut: Callable[[str], Sequence[int]],
    score: Callable[[Sequence[Window]], list[NDArray[np.float32]]],
) -> tuple[TaggedStep, ...]:
    """Tags with any model. `score` gives for each window the scores of its words' first pieces (words x 8)."""
    words = [split(text) for text in texts]
    cut_up = [windows([respelt(w.text) for w in ws], cut) for ws in words]
    queue = [window for found in cut_up for window in found]
    scores: dict[int, NDArray[np.float32]] = {}
    by_length = sorted(range(len(queue)), key=lambda i: len(queue[i].ids))
    for at in range(0, len(by_length), _BATCH):
        chosen = by_length[at : at + _BATCH]
        scores.update(zip(chosen, score([queue[i] for i in chosen]), strict=True))
    out: list[TaggedStep] = []
    at = 0
    for text, ws, found in zip(texts, words, cut_up, strict=True):
        rows = [scores[i] for i in range(at, at + len(found))]
        at += len(found)
        out.append(_labelled(text, ws, np.concatenate(rows) if rows else np.zeros((0, len(LABELS)), np.float32)))
    return tuple(out)


def _labelled(text: str, words: tuple[Word, ...], logits: NDArray[np.float32]) -> TaggedStep:
    if not words:
        return TaggedStep(text, (), ())
    log_p = log_softmax(logits)
    plain = certain_path(log_p, _CERTAIN)
    p = np.exp(log_p) if plain is not None else marginals(log_p)

    def with_labels(labels: Sequence[Label]) -> tuple[Word, ...]:
        return tuple(
            Word(w.text, w.start, w.end, label, min(1.0, float(p[i, LABELS.index(label)])))
            for i, (w, label) in enumerate(zip(words, labels, strict=True))
        )

    best = with_labels(plain or best_path(log_p))
    spans = decode(text, best)
    if plain is not None or len(words) > _LONG or min(w.confidence for w in best) >= _CERTAIN:
        return TaggedStep(text, best, spans, (Reading(spans, 1.0),))
    likeliest = best_paths(log_p, _READINGS)
    readings = (Reading(decode(text, with_labels(labels)), round(probability, 4)) for labels, probability in likeliest)
    return TaggedStep(text, best, spans, tuple(readings))
