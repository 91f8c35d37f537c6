"""How people say what the checks look for: the lists of `data/wording.toml`, and where one of them is said."""

from __future__ import annotations

import importlib.resources
import tomllib
from collections.abc import Sequence
from functools import cache
from typing import Any

from llmbt_compiler.parsing.words import Token, lemmas

__all__ = ["base_of", "listed", "phrase_at", "phrases"]


_ASKING = frozenset({"what", "who", "where"})
"""Words whose 's is a verb: "what's there"."""


@cache
def _data() -> dict[str, Any]:
    file = importlib.resources.files("llmbt_compiler.checking") / "data" / "wording.toml"
    return tomllib.loads(file.read_text("utf-8"))


@cache
def listed(section: str, name: str) -> frozenset[str]:
    """The words of a list."""
    return frozenset(_data()[section][name])


@cache
def phrases(section: str, name: str) -> tuple[tuple[str, ...], ...]:
    """The phrases of a list, in words, the longest first."""
    return tuple(sorted((tuple(p.split()) for p in _data()[section][name]), key=len, reverse=True))


def phrase_at(words: Sequence[Token], at: int, section: str, name: str) -> int:
    """Where a phrase of a list ends that begins right here; 0 where none does."""
    said = [f"{t.text}s" if t.owner and t.text in _ASKING else t.text for t in words[at : at + 12]]
    for phrase in phrases(section, name):
        if len(phrase) <= len(said) and all(p in {"_", s} for p, s in zip(phrase, said, strict=False)):
            return at + len(phrase)
    return 0


def base_of(word: str, verbs: frozenset[str]) -> str | None:
    """The one of `verbs` that a word is a form of."""
    irregular = _data()["abilities"]["irregular"].get(word)
    return next((v for v in (word, irregular, *lemmas(word)) if v in verbs), None)
