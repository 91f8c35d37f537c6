"""The labels of a step's words, and how they become spans and come back.

The scheme is IOB2 over four kinds. An action is one word (its head verb), so there is no ``I-Action``. Offsets are
half-open and count characters of the step from 0.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

__all__ = [
    "LABELS",
    "KeywordSpan",
    "Kind",
    "Label",
    "Reading",
    "SpanError",
    "TaggedStep",
    "Word",
    "decode",
    "encode",
    "follows",
    "kind_of",
    "repair",
    "split",
]


class Kind(StrEnum):
    """What a span of words is for."""

    ACTION = "Action"
    TARGET = "Target"
    DESTINATION = "Destination"
    LOCATION = "Location"


class Label(StrEnum):
    """What a word is: outside, or at the beginning of or inside a span of a kind."""

    O = "O"  # noqa: E741 - the scheme's own name
    B_ACTION = "B-Action"
    B_TARGET = "B-Target"
    I_TARGET = "I-Target"
    B_DESTINATION = "B-Destination"
    I_DESTINATION = "I-Destination"
    B_LOCATION = "B-Location"
    I_LOCATION = "I-Location"


LABELS: tuple[Label, ...] = tuple(Label)
"""All eight, in the order of the model's outputs."""

_WORD = re.compile(r"\w+(?:[-'’]\w+|\.\d+)*|[^\w\s]")


@dataclass(frozen=True, slots=True)
class Word:
    """A word of a step, or a single punctuation mark, with its label and the probability given to it (0 to 1)."""

    text: str
    start: int
    end: int
    label: Label = Label.O
    confidence: float = 1.0


@dataclass(frozen=True, slots=True)
class KeywordSpan:
    """A keyword: characters `start` to `end` (exclusive) of the step. Its confidence is that of its worst word."""

    start: int
    end: int
    label: Kind
    text: str
    confidence: float = 1.0


@dataclass(frozen=True, slots=True)
class Reading:
    """One way to label a whole step: the keywords it makes, and its probability (0 to 1)."""

    spans: tuple[KeywordSpan, ...]
    probability: float


@dataclass(frozen=True, slots=True)
class TaggedStep:
    """A step, its words with their labels, and the keywords these make.

    `readings` are the likeliest ways to label it, best first, where the model wavers; its own alone where it does not.
    """

    text: str
    words: tuple[Word, ...]
    spans: tuple[KeywordSpan, ...]
    readings: tuple[Reading, ...] = ()

    @property
    def confidence(self) -> float:
        """That of the least certain word, O words included; 1 for a step without words."""
        return min((w.confidence for w in self.words), default=1.0)


class SpanError(ValueError):
    """A span that cannot be written as labels: it cuts a word, overlaps another, or is an action of many words."""


def kind_of(label: Label) -> Kind | None:
    """The kind that a label begins or goes on; None for O."""
    return None if label is Label.O else Kind(label[2:])


def follows(before: Label | None, label: Label) -> bool:
    """Whether the grammar lets `label` come right after `before` (None: at the start of the step)."""
    if not label.startswith("I-"):
        return True
    return before is not None and kind_of(before) is kind_of(label)


def split(text: str) -> tuple[Word, ...]:
    """The words of a step, all labelled O.

    A hyphen, an apostrophe or a decimal point inside a word belongs to it ("T-shirt", "A.4"); any other mark is a
    word by itself.
    """
    return tuple(Word(m.group(), m.start(), m.end()) for m in _WORD.finditer(text))


def repair(labels: Iterable[Label]) -> tuple[Label, ...]:
    """The nearest grammatical labels: an I- without its B- becomes that B-."""
    out: list[Label] = []
    for label in labels:
        ok = follows(out[-1] if out else None, label)
        out.append(label if ok else Label("B-" + label[2:]))
    return tuple(out)


def decode(text: str, words: Sequence[Word]) -> tuple[KeywordSpan, ...]:
    """The spans that the words' labels make, in the order of the text. Ungrammatical labels are repaired first."""
    groups: list[list[Word]] = []
    kinds: list[Kind] = []
    for word, label in zip(words, repair(w.label for w in words), strict=True):
        kind = kind_of(label)
        if kind is None:
            continue
        if label.startswith("B-"):
            groups.append([])
            kinds.append(kind)
        groups[-1].append(word)
    return tuple(
        KeywordSpan(
            start=group[0].start,
            end=group[-1].end,
            label=kind,
            text=text[group[0].start : group[-1].end],
            confidence=min(w.confidence for w in group),
        )
        for group, kind in zip(groups, kinds, strict=True)
    )


def encode(text: str, spans: Iterable[KeywordSpan]) -> tuple[Word, ...]:
    """The words of a step with the labels that say its spans; the inverse of `decode`.

    Raises SpanError where a span does not begin and end with a word, two overlap, or an action has several words.
    """
    words = list(split(text))
    starts = {w.start: i for i, w in enumerate(words)}
    ends = {w.end: i for i, w in enumerate(words)}
    taken: set[int] = set()
    for span in spans:
        if span.start not in starts or span.end not in ends or span.start >= span.end:
            raise SpanError(f"{span.label} {span.start}-{span.end} does not begin and end with a word of {text!r}")
        covered = range(starts[span.start], ends[span.end] + 1)
        if not taken.isdisjoint(covered):
            raise SpanError(f"{span.label} {span.start}-{span.end} overlaps another span of {text!r}")
        if span.label is Kind.ACTION and len(covered) > 1:
            raise SpanError(f"the action {text[span.start : span.end]!r} of {text!r} has more than one word")
        taken.update(covered)
        for i in covered:
            label = Label(("B-" if i == covered[0] else "I-") + span.label)
            words[i] = Word(words[i].text, words[i].start, words[i].end, label, span.confidence)
    return tuple(words)
