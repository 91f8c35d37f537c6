"""How good a tagger is: strict spans (kind, beginning and end all right), and steps right as a whole."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from llmbt_compiler.keywords.labels import KeywordSpan, Kind, encode

if TYPE_CHECKING:
    from llmbt_compiler.keywords.tagger import Tagger

__all__ = ["Evaluation", "Example", "ExampleError", "Scores", "evaluate", "evaluate_file", "read_examples"]


class ExampleError(ValueError):
    """A line of an evaluation file that cannot be read; the message names the file and the line (from 1)."""


@dataclass(frozen=True, slots=True)
class Example:
    """A step with the keywords it has."""

    text: str
    spans: tuple[KeywordSpan, ...]


@dataclass(frozen=True, slots=True)
class Scores:
    """Spans right among those found, and among those there are (0 to 1; 1 where there is nothing to find)."""

    precision: float
    recall: float
    f1: float
    n: int


@dataclass(frozen=True, slots=True)
class Evaluation:
    """The figures over `n` steps. `confusions` counts (is, was taken for) of words whose labels differ."""

    scores: Scores
    by_label: Mapping[Kind, Scores]
    whole_step_accuracy: float
    confusions: Mapping[tuple[str, str], int]
    wrong: tuple[int, ...]
    n: int

    def as_dict(self) -> dict[str, object]:
        """For JSON: `precision`, `recall`, `f1`, `whole_step_accuracy`, `n`, and the details."""
        return {
            "precision": self.scores.precision,
            "recall": self.scores.recall,
            "f1": self.scores.f1,
            "whole_step_accuracy": self.whole_step_accuracy,
            "n": self.n,
            "by_label": {
                str(k): {"precision": s.precision, "recall": s.recall, "f1": s.f1, "n": s.n}
                for k, s in self.by_label.items()
            },
            "confusions": [{"is": a, "taken_for": b, "n": n} for (a, b), n in self.confusions.items()],
        }


_Key = tuple[int, int, int, Kind]


def evaluate(truth: Sequence[Example], found: Sequence[Sequence[KeywordSpan]]) -> Evaluation:
    """Compares found spans with true ones, step by step. Raises ValueError where the numbers of steps differ."""
    right: set[_Key] = set()
    guessed: set[_Key] = set()
    confusions: Counter[tuple[str, str]] = Counter()
    wrong: list[int] = []
    for i, (example, spans) in enumerate(zip(truth, found, strict=True)):
        is_ = {(i, s.start, s.end, s.label) for s in example.spans}
        was = {(i, s.start, s.end, s.label) for s in spans}
        right |= is_
        guessed |= was
        if is_ != was:
            wrong.append(i)
            pairs = zip(encode(example.text, example.spans), encode(example.text, spans), strict=True)
            confusions.update((str(a.label), str(b.label)) for a, b in pairs if a.label is not b.label)
    by_label = {k: _scores({x for x in right if x[3] is k}, {x for x in guessed if x[3] is k}) for k in Kind}
    n = len(truth)
    return Evaluation(
        scores=_scores(right, guessed),
        by_label=by_label,
        whole_step_accuracy=1 - len(wrong) / n if n else 1.0,
        confusions=dict(sorted(confusions.items(), key=lambda item: (-item[1], item[0]))),
        wrong=tuple(wrong),
        n=n,
    )


def _scores(right: set[_Key], guessed: set[_Key]) -> Scores:
    both = len(right & guessed)
    precision = both / len(guessed) if guessed else 1.0
    recall = both / len(right) if right else 1.0
    f1 = 2 * precision * recall / (precision + recall) if both else float(not right and not guessed)
    return Scores(precision, recall, f1, len(right))


def read_examples(path: Path) -> tuple[Example, ...]:
    """JSON lines ``{"text": ..., "spans": [{"start", "end", "label"}]}``. Raises ExampleError, OSError."""
    out: list[Example] = []
    for number, line in enumerate(path.read_text("utf-8").splitlines(), start=1):
        if not line.strip():
            continue
        try:
            out.append(_example(json.loads(line)))
        except (KeyError, TypeError, ValueError) as e:
            raise ExampleError(f"{path}:{number}: {e}") from e
    return tuple(out)


def evaluate_file(path: Path, tagger: Tagger) -> Evaluation:
    """The figures of a tagger on a file of examples. Raises ExampleError, OSError."""
    examples = read_examples(path)
    return evaluate(examples, [step.spans for step in tagger.tag([e.text for e in examples])])


def _example(record: Any) -> Example:
    text = record["text"]
    if not isinstance(text, str):
        raise TypeError("text is no string")
    spans = tuple(
        KeywordSpan(s["start"], s["end"], Kind(s["label"]), text[s["start"] : s["end"]])
        for s in sorted(record["spans"], key=lambda s: int(s["start"]))
    )
    encode(text, spans)
    return Example(text, spans)
