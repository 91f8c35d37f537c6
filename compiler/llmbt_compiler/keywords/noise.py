"""What people and chat models do to a sentence: capitals, full stops, bold, bullets, typing errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from random import Random

from llmbt_compiler.keywords.grammar import Segment
from llmbt_compiler.keywords.labels import Kind

__all__ = ["NO_NOISE", "NoiseRates", "apply_noise"]

_NEAR = {
    "a": "sq", "b": "vn", "c": "xv", "d": "sf", "e": "wr", "f": "dg", "g": "fh", "h": "gj", "i": "uo", "j": "hk",
    "k": "jl", "l": "k", "m": "n", "n": "bm", "o": "ip", "p": "o", "q": "w", "r": "et", "s": "ad", "t": "ry",
    "u": "yi", "v": "cb", "w": "qe", "x": "zc", "y": "tu", "z": "x",
}  # fmt: skip
_SWAPS = {"c": "k", "k": "c", "s": "z", "ck": "k", "ph": "f", "ee": "ea", "ea": "ee", "ie": "ei", "ei": "ie"}


@dataclass(frozen=True, slots=True)
class NoiseRates:
    """How often each happens to a sample (0 to 1)."""

    no_capital: float = 0.10
    upper: float = 0.03
    no_stop: float = 0.25
    exclaim: float = 0.03
    typos: float = 0.10
    bold: float = 0.07
    quote: float = 0.05
    capital_names: float = 0.05
    bullet: float = 0.07


NO_NOISE = NoiseRates(0, 0, 0, 0, 0, 0, 0, 0, 0)


def apply_noise(
    segments: tuple[Segment, ...], random: Random, rates: NoiseRates, bullet: str = ""
) -> tuple[Segment, ...]:
    """The same keywords in a sentence as somebody might have typed it. `bullet` is put in front at its rate."""
    out = list(segments)
    if random.random() < rates.typos:
        out = _typos(out, random)
    if random.random() < rates.capital_names:
        out = [replace(s, text=s.text.title()) if s.kind not in (None, Kind.ACTION) else s for s in out]
    if random.random() >= rates.no_capital:
        out = _capitalised(out)
    if not out[-1].text.rstrip().endswith((".", "!", "?", "**", ":")) and random.random() >= rates.no_stop:
        out.append(Segment("!" if random.random() < rates.exclaim else ".", None))
    has_markup = any("*" in s.text for s in out)
    if not has_markup and random.random() < rates.bold:
        out = _bold(out, random)
    if random.random() < rates.quote:
        out = _quoted(out, random)
    if random.random() < rates.upper:
        out = [replace(s, text=s.text.upper()) for s in out]
    if bullet and random.random() < rates.bullet:
        out.insert(0, Segment(bullet, None))
    return tuple(out)


def _capitalised(segments: list[Segment]) -> list[Segment]:
    """With a capital at the start, and after a full stop."""
    out: list[Segment] = []
    fresh = True
    for s in segments:
        chars = list(s.text)
        for i, c in enumerate(chars):
            if fresh and c.isalnum():
                chars[i] = c.upper()
                fresh = False
            elif c in ".!?" and i + 1 < len(chars) and chars[i + 1] == " " and i and chars[i - 1].islower():
                fresh = True
        out.append(replace(s, text="".join(chars)))
    return out


def _bold(segments: list[Segment], random: Random) -> list[Segment]:
    """Stars around each target and place, around the action, or from the first keyword to the last."""
    marked = [i for i, s in enumerate(segments) if s.kind is not None]
    if not marked:
        return segments
    way = random.random()
    if way < 0.3:
        chosen = {i for i in marked if segments[i].kind is not Kind.ACTION}
    elif way < 0.5:
        chosen = {i for i in marked if segments[i].kind is Kind.ACTION}
    elif way < 0.6:
        chosen = {random.choice(marked)}
    elif way < 0.7:
        chosen = set(marked)
    else:
        first, last = marked[0], marked[-1] if way < 0.85 else marked[min(1, len(marked) - 1)]
        return [
            *segments[:first],
            Segment("**", None),
            *segments[first : last + 1],
            Segment("**", None),
            *segments[last + 1 :],
        ]
    out: list[Segment] = []
    for i, s in enumerate(segments):
        out += [Segment("**", None), s, Segment("**", None)] if i in chosen else [s]
    return out


def _quoted(segments: list[Segment], random: Random) -> list[Segment]:
    """Quotes or backticks around a keyword that has a digit, else around one that is no action."""
    named = [i for i, s in enumerate(segments) if s.kind not in (None, Kind.ACTION)]
    coded = [i for i in named if any(c.isdigit() for c in segments[i].text)]
    if not named:
        return segments
    at = random.choice(coded or named)
    mark = random.choice(["`", '"', "'", "_", "*"] if coded else ['"', "'"])
    if mark == "_":  # a word character: it would belong to the name
        mark = "*"
    return [*segments[:at], Segment(mark, None), segments[at], Segment(mark, None), *segments[at + 1 :]]


def _typos(segments: list[Segment], random: Random) -> list[Segment]:
    """Errors in one to four words that have at least three letters."""
    places = [
        (i, j)
        for i, s in enumerate(segments)
        for j, w in enumerate(s.text.split(" "))
        if len(w) >= 3 and w.isascii() and w.isalpha()
    ]
    random.shuffle(places)
    out = list(segments)
    for i, j in places[: random.choice((1, 1, 2, 2, 3, 4))]:
        words = out[i].text.split(" ")
        words[j] = _mistyped(words[j], random)
        out[i] = replace(out[i], text=" ".join(words))
    return out


def _mistyped(word: str, random: Random) -> str:
    way = random.random()
    at = random.randrange(1, len(word)) if len(word) > 3 or random.random() < 0.8 else 0
    if way < 0.35 and at + 1 < len(word):
        return word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    if way < 0.55 and len(word) > 3:
        return word[:at] + word[at + 1 :]
    if way < 0.7:
        return word[:at] + word[at] + word[at:]
    if way < 0.85:
        return word[:at] + random.choice(_NEAR.get(word[at].lower(), "e")) + word[at + 1 :]
    for old, new in _SWAPS.items():
        if old in word[1:]:
            return word[0] + word[1:].replace(old, new, 1)
    return word[: at - 1] + word[at] + word[at - 1] + word[at + 1 :] if at else word
