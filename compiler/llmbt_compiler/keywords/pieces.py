"""WordPiece in plain Python: the sub-words of an uncased BERT, with no import that costs anything.

Gives what `transformers.BertTokenizer` gives for single words (the tests compare the two).
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

__all__ = ["CLS", "PAD", "SEP", "UNK", "Window", "WordPiece", "read_vocabulary", "windows"]

PAD, UNK, CLS, SEP = 0, 100, 101, 102
"""Ids of the special pieces in BERT's vocabulary."""

_LONGEST_WORD = 100
_PIECES_A_WORD = 24
_WINDOW = 254


@dataclass(frozen=True, slots=True)
class Window:
    """What the model sees at once: piece ids with CLS and SEP, and where each word's first piece is."""

    ids: tuple[int, ...]
    first: tuple[int, ...]


class WordPiece:
    """Cuts words into pieces. The vocabulary maps pieces to ids."""

    def __init__(self, vocabulary: Mapping[str, int]) -> None:
        self._vocabulary = vocabulary
        self._seen: dict[str, tuple[int, ...]] = {}

    def __call__(self, word: str) -> tuple[int, ...]:
        """The ids of a word's pieces: at least one, UNK where nothing is left of it."""
        ids = self._seen.get(word)
        if ids is None:
            ids = tuple(i for part in _parts(word) for i in self._greedy(part)) or (UNK,)
            if len(self._seen) < 10_000 and len(word) < 64:
                self._seen[word] = ids
        return ids

    def _greedy(self, part: str) -> list[int]:
        if len(part) > _LONGEST_WORD:
            return [UNK]
        out: list[int] = []
        start = 0
        while start < len(part):
            for end in range(len(part), start, -1):
                piece = ("##" if start else "") + part[start:end]
                if piece in self._vocabulary:
                    out.append(self._vocabulary[piece])
                    start = end
                    break
            else:
                return [UNK]
        return out


def read_vocabulary(path: Path) -> dict[str, int]:
    """A ``vocab.txt``: one piece a line, its id the line's number from 0. Raises OSError."""
    return {piece: i for i, piece in enumerate(path.read_text("utf-8").rstrip("\n").split("\n"))}


def windows(words: Sequence[str], cut: Callable[[str], Sequence[int]]) -> tuple[Window, ...]:
    """The words in as few windows as they fit, in order; a very long word counts with its first pieces only."""
    out: list[Window] = []
    ids: list[int] = [CLS]
    first: list[int] = []
    for word in words:
        pieces = list(cut(word))[:_PIECES_A_WORD]
        if len(ids) + len(pieces) > _WINDOW and first:
            out.append(Window((*ids, SEP), tuple(first)))
            ids, first = [CLS], []
        first.append(len(ids))
        ids += pieces
    if first:
        out.append(Window((*ids, SEP), tuple(first)))
    return tuple(out)


def _parts(word: str) -> list[str]:
    """Lower case, no accents, cut at punctuation and around CJK characters, as BERT's basic tokenizer does."""
    parts: list[str] = []
    fresh = True
    for c in unicodedata.normalize("NFD", word).lower():
        kind = unicodedata.category(c)
        if c in "\x00\ufffd" or kind == "Mn" or (kind.startswith("C") and c not in "\t\n\r"):
            continue
        if c.isspace():
            fresh = True
        elif _splits(c, kind):
            parts.append(c)
            fresh = True
        elif fresh:
            parts.append(c)
            fresh = False
        else:
            parts[-1] += c
    return parts


def _splits(c: str, kind: str) -> bool:
    n = ord(c)
    ascii_mark = 33 <= n <= 47 or 58 <= n <= 64 or 91 <= n <= 96 or 123 <= n <= 126
    cjk = (
        0x4E00 <= n <= 0x9FFF
        or 0x3400 <= n <= 0x4DBF
        or 0x20000 <= n <= 0x2CEAF
        or 0xF900 <= n <= 0xFAFF
        or 0x2F800 <= n <= 0x2FA1F
    )
    return ascii_mark or kind.startswith("P") or cjk
