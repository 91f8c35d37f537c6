"""Function words whose neighbouring letters have changed places: "teh", "adn", "wiht". They are read as what they were
to be, by the tagger and by the parser, with as many letters, so that every offset stays."""

from __future__ import annotations

from collections.abc import Iterator

__all__ = ["respelt"]

_WORDS = ("the", "and", "with", "from", "onto", "into", "then", "that", "this", "them", "please", "object", "position")
_OWN = frozenset({"form", "whit"})
"""Swaps that are words themselves."""


def _swaps(word: str) -> Iterator[str]:
    for i in range(len(word) - 1):
        yield word[:i] + word[i + 1] + word[i] + word[i + 2 :]


_MEANT = {slip: word for word in _WORDS for slip in _swaps(word) if slip not in _OWN and slip != word}


def respelt(word: str) -> str:
    """The word as it was to be spelt; most are as they stand. Capitals stay at the front."""
    meant = _MEANT.get(word.casefold())
    if meant is None or len(meant) != len(word):
        return word
    return meant.capitalize() if word[0].isupper() else meant
