"""English as far as the parser needs it: tokens with their offsets, numbers, singulars, lemmas, slips of the
pen.

The word lists are data (`data/words.toml`); what is here knows no noun and no verb by itself.
"""

from __future__ import annotations

import importlib.resources
import tomllib
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import groupby

from llmbt_compiler.keywords.slips import respelt

__all__ = ["Lexicon", "Size", "Token", "closest", "distance", "lemmas", "lexicon", "singulars", "tokens"]

_LONGEST = 40
"""Longer tokens are never taken for a slip of something else."""


@dataclass(frozen=True, slots=True)
class Token:
    """A run of letters or of digits, or one mark, in lower case; `start` and `end` are offsets into the text.

    `glued`: no space parts it from the token before; `owner`: it ended in 's, which is cut off. Number words carry
    their value in `number` as well.
    """

    text: str
    start: int
    end: int
    glued: bool = False
    number: str | None = None
    owner: bool = False

    @property
    def word(self) -> bool:
        """Made of letters."""
        return self.text[0].isalpha()

    @property
    def digits(self) -> bool:
        """Written in digits."""
        return self.number is not None and not self.word


@dataclass(frozen=True, slots=True)
class Size:
    """A word that orders things: by `measure` ("size", "height"), the most or the least of it; `pair`: of two."""

    measure: str
    most: bool
    pair: bool


@dataclass(frozen=True)
class Lexicon:
    """The word lists of `words.toml`, by section and name."""

    verbs: Mapping[str, frozenset[str]]
    synonyms: Mapping[str, tuple[str, ...]]
    irregular: Mapping[str, str]
    function: Mapping[str, frozenset[str]]
    objects: frozenset[str]
    anything: frozenset[str]
    collectives: frozenset[str]
    places: frozenset[str]
    shapes: Mapping[str, frozenset[str]]
    sorts: Mapping[str, frozenset[str]]
    sizes: Mapping[str, Size]
    groups: tuple[frozenset[str], ...]
    numbers: Mapping[str, int]
    ordinals: Mapping[str, int]

    def is_(self, word: str, *lists: str) -> bool:
        """Whether a word is in one of the named function-word lists."""
        return any(word in self.function[name] for name in lists)

    def alike(self, word: str) -> frozenset[str]:
        """A noun with its synonyms, an adjective of shape with the shapes it fits, a sort of things with the things."""
        more = (self.shapes.get(word, ()), self.sorts.get(word, ()))
        return frozenset({word}).union(*(g for g in self.groups if word in g), *more)

    @property
    def known(self) -> frozenset[str]:
        """Every word that is no noun and no verb: never to be taken for a slip of a name."""
        return frozenset().union(*self.function.values(), self.numbers, self.ordinals)


@cache
def lexicon() -> Lexicon:
    """The lists as shipped."""
    file = importlib.resources.files("llmbt_compiler.parsing") / "data" / "words.toml"
    raw = tomllib.loads(file.read_text("utf-8"))
    verbs = raw["verbs"]
    return Lexicon(
        verbs={k: frozenset(v) for k, v in verbs.items() if isinstance(v, list) and k != "meanings"},
        synonyms={verb: tuple(group["as"]) for group in verbs["meanings"] for verb in group["verbs"]},
        irregular=verbs["irregular"],
        function={k: frozenset(v) for k, v in raw["function"].items()},
        objects=frozenset(raw["nouns"]["objects"]),
        anything=frozenset(raw["nouns"]["anything"]),
        collectives=frozenset(raw["nouns"]["collectives"]),
        shapes={k: frozenset(v) for k, v in raw["nouns"]["shapes"].items()},
        sorts={k: frozenset(v) for k, v in raw["nouns"]["sorts"].items()},
        sizes={k: Size(v[0], v[1] == "most", len(v) > 2) for k, v in raw["nouns"]["sizes"].items()},
        places=frozenset(raw["nouns"]["places"]),
        groups=tuple(frozenset(g) for g in raw["nouns"]["groups"]),
        numbers=raw["numbers"],
        ordinals=raw["ordinals"],
    )


_APOSTROPHES = str.maketrans("", "", "'’")


def _kind(char: str) -> str:
    if char.isspace() or char == "_":
        return " "
    if char.isdigit():
        return "9"
    return "a" if char.isalpha() or char in "'’" or unicodedata.combining(char) else char


def _runs(text: str) -> Iterator[tuple[str, int, int]]:
    at = 0
    for kind, run in groupby(text, key=_kind):
        length = sum(1 for _ in run)
        if kind in {"9", "a"}:
            yield kind, at, at + length
        elif kind != " ":
            yield from (("-", i, i + 1) for i in range(at, at + length))
        at += length


@lru_cache(maxsize=4096)
def tokens(text: str, start: int = 0, end: int | None = None) -> tuple[Token, ...]:
    """The tokens of ``text[start:end]``, offsets counted in `text`.

    Letters and digits part ("P12" is p, 12), apostrophes vanish, underscores are spaces, and so is the hyphen of a
    compound ("window-side locker"), "1.5" and a minus
    before a lone number stay with it, number words get their value ("twenty-one" is one token with the number
    21), "not only A but also B" has the tokens of "A and B".
    """
    end = len(text) if end is None else end
    out: list[Token] = []
    for kind, a, b in _runs(text[start:end]):
        raw = text[start + a : start + b]
        glued = a > 0 and not text[start + a - 1].isspace() and bool(out) and out[-1].end == start + a
        word = respelt(unicodedata.normalize("NFKC", raw).casefold().translate(_APOSTROPHES))
        if not word or (not word[0].isalnum() and kind != "-"):
            continue
        if kind == "9" and glued and _after_letter(out):
            out.pop()  # "P-11"
        if word == "s" and glued and out[-1].digits and len(raw) > 1:
            out[-1] = replace(out[-1], owner=True)
            continue  # "object 4's"
        number = (word.lstrip("0") or "0") if kind == "9" else None
        if word in {"thats", "whichs"}:  # "the one that's green"
            out.append(Token(word[:-1], start + a, start + b - 2, glued))
            out.append(Token("is", start + b - 2, start + b, True))
            continue
        owner = raw.endswith(("'s", "’s")) and len(word) > 1
        word = word[:-1] if owner else word
        out.append(Token(word, start + a, start + b, glued, number, owner))
    return tuple(_numbered(_decimals(_correlated(_compounds(out)))))


def _compounds(parts: list[Token]) -> list[Token]:
    """Without the hyphens between two words that are no numbers: "set-down table", "right-hand"."""
    numbers = lexicon().numbers
    out: list[Token] = []
    for i, t in enumerate(parts):
        joined = t.text in {"-", "\u2010", "\u2011"} and t.glued and 0 < i < len(parts) - 1 and parts[i + 1].glued
        around = (parts[i - 1], parts[i + 1]) if joined else ()
        if around and all(len(w.text) > 2 and w.text.isalpha() and w.text not in numbers for w in around):
            continue
        after = out[-1].end < t.start if out else False
        out.append(replace(t, glued=False) if t.glued and after else t)
    return out


def _after_letter(out: list[Token]) -> bool:
    """Whether a lone letter and a hyphen are the last tokens."""
    if len(out) < 2 or out[-1].text != "-" or not out[-1].glued:
        return False
    return out[-2].word and len(out[-2].text) == 1 and not out[-2].glued


def _correlated(parts: list[Token]) -> list[Token]:
    """ "Not only A but also B", "A followed by B" is A and B."""
    out: list[Token] = []
    for t in parts:
        said = out[-1].text if out else ""
        if (said, t.text) == ("not", "only"):
            out.pop()
        elif (said, t.text) in {("but", "also"), ("followed", "by")}:
            out[-1] = Token("and", out[-1].start, t.end)
        else:
            out.append(t)
    return out


def _decimals(parts: list[Token]) -> list[Token]:
    """ "1.5" and "-1" as one token each: no id has them, and half of one would be another number."""
    out: list[Token] = []
    for t in parts:
        if t.digits and t.glued and len(out) > 1 and out[-1].text == "." and out[-1].glued and out[-2].digits:
            whole = out[-2]
            out[-2:] = [Token(f"{whole.text}.{t.text}", whole.start, t.end, whole.glued, f"{whole.number}.{t.number}")]
        elif t.digits and t.glued and out and out[-1].text in {"-", "−"} and not out[-1].glued:
            out[-1:] = [Token(f"-{t.text}", out[-1].start, t.end, False, f"-{t.number}")]
        else:
            out.append(t)
    return out


def _numbered(parts: list[Token]) -> Iterator[Token]:
    numbers = lexicon().numbers
    i = 0
    while i < len(parts):
        t = parts[i]
        value = numbers.get(t.text)
        if value is None or not t.word:
            yield t
            i += 1
            continue
        j = i + 1
        if value >= 20:
            k = j + 1 if j < len(parts) and parts[j].text == "-" else j
            unit = numbers.get(parts[k].text, 0) if k < len(parts) else 0
            if 0 < unit < 10:
                value, j = value + unit, k + 1
        yield Token(t.text, t.start, parts[j - 1].end, t.glued, str(value))
        i = j


def singulars(word: str) -> Iterator[str]:
    """A noun and what it may be the plural of, likeliest first."""
    yield word
    if len(word) < 3 or not word.endswith("s") or word.endswith("ss"):
        return
    yield word[:-1]
    if word.endswith("ies"):
        yield word[:-3] + "y"
    if word.endswith("ves"):
        yield word[:-3] + "f"
        yield word[:-3] + "fe"
    if word.endswith("es"):
        yield word[:-2]


def lemmas(verb: str) -> Iterator[str]:
    """A verb form and what it may be a form of: the word itself first."""
    yield verb
    irregular = lexicon().irregular.get(verb)
    if irregular is not None:
        yield irregular
    for ending in ("ing", "ed", "es", "s"):
        stem = verb.removesuffix(ending)
        if stem == verb or len(stem) < 2:
            continue
        yield stem
        if ending in {"ing", "ed"}:
            yield stem + "e"
            if len(stem) > 2 and stem[-1] == stem[-2]:
                yield stem[:-1]
    if verb.endswith("ied"):
        yield verb[:-3] + "y"
    if verb.endswith("ies"):
        yield verb[:-3] + "y"


def distance(a: str, b: str) -> int:
    """Optimal string alignment: insertions, deletions, substitutions and swaps of neighbours."""
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        older, before, row = before, row, [i]
        for j, y in enumerate(b, 1):
            cost = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, older[j - 2] + 1)
            row.append(cost)
    return row[-1]


def closest(word: str, vocabulary: Iterable[str]) -> tuple[str, ...]:
    """What a mistyped word may be: the vocabulary's words at the least distance, if that is small; all at a
    tie.

    Words of three letters or fewer are taken as they are. One slip is allowed, two from eight letters on; the
    first letter stands; in words of four letters no letter is exchanged for another (coke is no cake).
    """
    if not 3 < len(word) <= _LONGEST:
        return ()
    allowed = 1 if len(word) < 8 else 2
    found: dict[str, int] = {}
    for other in set(vocabulary):
        if len(other) < 3 or abs(len(other) - len(word)) > allowed or other[0] != word[0]:
            continue
        d = distance(word, other)
        exchanged = d == 1 and len(other) == len(word) and sorted(other) != sorted(word)
        if d <= allowed and not (exchanged and len(word) < 5):
            found[other] = d
    least = min(found.values(), default=0)
    return tuple(sorted(w for w, d in found.items() if d == least))
