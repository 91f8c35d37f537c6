"""A request as the checks read it: one line, its sentences, and a part of it to be shown."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from itertools import pairwise

from llmbt_compiler.parsing.words import Token
from llmbt_ir.diagnostics import Span

__all__ = ["ENDS", "one_line", "sentence_at", "sentences", "span_of"]

ENDS = frozenset({".", "!", "?", ";"})
"""Marks that end a sentence."""
_LONGEST = 2_000


def one_line(request: str) -> str:
    """The request in one line, cut where no request may be longer."""
    return " ".join(request.split())[:_LONGEST]


def sentences(words: Sequence[Token], ends: Collection[str] = ENDS) -> Iterator[tuple[int, int]]:
    """Where each sentence begins, and where it and its mark end."""
    begins = [0, *(i + 1 for i, t in enumerate(words) if t.text in ends), len(words)]
    return ((a, b) for a, b in pairwise(begins) if b > a)


def sentence_at(words: Sequence[Token], i: int) -> tuple[int, int]:
    """Where the sentence of words[i] begins, and where its mark stands."""
    begin = max((k + 1 for k in range(i) if words[k].text in ENDS), default=0)
    return begin, next((k for k in range(i, len(words)) if words[k].text in ENDS), len(words))


def span_of(parts: Sequence[Token], line: str) -> Span:
    """Some words of a request, to be shown within it; what cannot be printed is a blank."""
    shown = "".join(c if c.isprintable() else " " for c in line)
    return Span("request", 1, parts[0].start + 1, parts[-1].end + 1, shown)
