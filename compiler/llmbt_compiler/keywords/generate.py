"""Labelled steps from the grammar: as many as one wants, the same ones for the same seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from random import Random

from llmbt_compiler.keywords.grammar import Grammar, Segment, parse_markup
from llmbt_compiler.keywords.labels import KeywordSpan
from llmbt_compiler.keywords.noise import NoiseRates, apply_noise

__all__ = ["CONTEXT", "MIXTURE", "Sample", "generate", "vocabulary_words"]

MIXTURE: Mapping[str, float] = {
    "plain": 26,
    "coordination": 22,
    "relative": 12,
    "adverbial": 14,
    "trailing": 14,
    "polite": 8,
    "markup": 7,
    "pronouns": 6,
    "pairs": 12,
    "verbless": 6,
    "repeats": 4,
    "calls": 3,
    "navigation": 14,
}
"""How often each structure is drawn; one that is not named has weight 5."""


CONTEXT = ("relative", "trailing", "adverbial")
"""The structures whose sentences say more than the order."""


@dataclass(frozen=True, slots=True)
class Sample:
    """A generated step: its text, its keywords, and the structure it was drawn from."""

    text: str
    spans: tuple[KeywordSpan, ...]
    structure: str = field(default="", compare=False)


def vocabulary_words(pieces: list[str]) -> tuple[str, ...]:
    """The words of a WordPiece vocabulary to draw unknown nouns from: lower-case letters, 4 to 12 of them, sorted.

    The most frequent pieces are left out: they are function words.
    """
    return tuple(sorted({p for p in pieces[3000:] if 4 <= len(p) <= 12 and p.isascii() and p.isalpha()}))


def generate(
    grammar: Grammar,
    n: int,
    seed: int,
    rates: NoiseRates | None = None,
    mixture: Mapping[str, float] = MIXTURE,
) -> Iterator[Sample]:
    """`n` samples. The i-th depends on the seed and i only, so that more of them begin with the same ones."""
    names = grammar.structures
    weights = [mixture.get(name, 5.0) for name in names]
    for i in range(n):
        random = Random(f"{seed}:{i}")
        (structure,) = random.choices(names, weights)
        segments = parse_markup(grammar.draw(structure, random))
        bullet = grammar.bullet(random)
        yield _sample(apply_noise(segments, random, rates or NoiseRates(), bullet), structure)


def _sample(segments: tuple[Segment, ...], structure: str) -> Sample:
    text = "".join(s.text for s in segments)
    spans: list[KeywordSpan] = []
    at = 0
    for s in segments:
        end = at + len(s.text)
        if s.kind is not None:
            spans.append(KeywordSpan(at, end, s.kind, s.text))
        at = end
    return Sample(text, tuple(spans), structure)
