"""How far two annotations of the same steps agree: strict spans, whole steps, and Cohen's kappa over words."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

from llmbt_compiler.keywords.evaluate import Example, ExampleError, evaluate, read_examples
from llmbt_compiler.keywords.grammar import GrammarError, parse_markup
from llmbt_compiler.keywords.labels import KeywordSpan, SpanError, encode

__all__ = ["Agreement", "agreement", "draw_texts", "kappa", "read_annotation"]


@dataclass(frozen=True, slots=True)
class Agreement:
    """Over `n` steps annotated twice: F1 of strict spans, share of steps alike, kappa of the words' labels."""

    span_f1: float
    whole_step: float
    kappa: float
    words: int
    n: int

    def as_dict(self) -> dict[str, float | int]:
        """For JSON."""
        return {
            "span_f1": self.span_f1,
            "whole_step": self.whole_step,
            "kappa": self.kappa,
            "words": self.words,
            "n": self.n,
        }


def read_annotation(path: Path) -> tuple[Example, ...]:
    """Annotated steps: JSON lines as for evaluation, or in a .txt file one step a line with its keywords marked.

    ``[A Put] the [T cup] on the [D table]`` has an action, a target and a destination. Raises ExampleError, OSError.
    """
    if path.suffix == ".jsonl":
        return read_examples(path)
    out: list[Example] = []
    for number, line in enumerate(path.read_text("utf-8").splitlines(), start=1):
        if not line.strip():
            continue
        try:
            out.append(_marked(line))
        except (GrammarError, SpanError) as e:
            raise ExampleError(f"{path}:{number}: {e}") from e
    return tuple(out)


def _marked(line: str) -> Example:
    text, spans = "", []
    for segment in parse_markup(line):
        if segment.kind is not None:
            spans.append(KeywordSpan(len(text), len(text) + len(segment.text), segment.kind, segment.text))
        text += segment.text
    encode(text, spans)
    return Example(text, tuple(spans))


def agreement(first: Sequence[Example], second: Sequence[Example]) -> Agreement:
    """Compares by text: every step of `second` has to be in `first`. Raises ExampleError."""
    known = {e.text: e for e in first}
    missing = [e.text for e in second if e.text not in known]
    if missing or not second:
        what = f"{missing[0]!r} is not among the first annotation's steps" if missing else "no step is annotated"
        raise ExampleError(what)
    pairs = [(known[e.text], e) for e in second]
    figures = evaluate([a for a, _ in pairs], [b.spans for _, b in pairs])
    labels = [
        (str(x.label), str(y.label))
        for a, b in pairs
        for x, y in zip(encode(a.text, a.spans), encode(b.text, b.spans), strict=True)
    ]
    return Agreement(figures.scores.f1, figures.whole_step_accuracy, kappa(labels), len(labels), len(pairs))


def kappa(pairs: Sequence[tuple[str, str]]) -> float:
    """Cohen's kappa of two raters; 1 where chance alone would have them agree on everything."""
    n = len(pairs)
    if n == 0:
        return 1.0
    seen = sum(a == b for a, b in pairs) / n
    left, right = Counter(a for a, _ in pairs), Counter(b for _, b in pairs)
    chance = sum(left[k] * right[k] for k in left) / (n * n)
    return (seen - chance) / (1 - chance) if chance < 1 else 1.0


def draw_texts(path: Path, n: int, seed: int) -> tuple[str, ...]:
    """The texts of `n` steps of a file, without their keywords, drawn by `seed`. Raises ExampleError, OSError."""
    texts: list[str] = []
    for number, line in enumerate(path.read_text("utf-8").splitlines(), start=1):
        if line.strip():
            texts.append(_text(line, path, number))
    return tuple(Random(seed).sample(texts, min(n, len(texts))))


def _text(line: str, path: Path, number: int) -> str:
    try:
        record: Any = json.loads(line)
        return str(record["text"])
    except (ValueError, KeyError, TypeError) as e:
        raise ExampleError(f"{path}:{number}: {e}") from e
