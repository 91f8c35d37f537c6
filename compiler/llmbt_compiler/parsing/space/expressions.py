"""The words of relations and ranks, found in a step's tokens: "to the left of", "the second from the left".

Pure and without a map: what is found says which words they are and what they ask for, not what they mean in a scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["Ranked", "Relation", "rank_of", "relations", "side_of"]

_SIDES = ("to the {} of", "to the {} side of", "on the {} of", "on the {} side of", "at the {} of", "at the {} side of")
_PHRASES: Mapping[str, tuple[str, ...]] = {
    "left": (*(s.format("left") for s in _SIDES), "left of", "to the left hand side of", "on the left hand side of"),
    "right": (*(s.format("right") for s in _SIDES), "right of", "to the right hand side of",
              "on the right hand side of"),
    "front": ("in front of", "to the front of", "on the near side of"),
    "behind": ("behind", "in back of", "on the far side of", "to the rear of"),
    "next": (
        "next to", "beside", "adjacent to", "alongside", "alongside of", "close to", "near", "near to", "right by",
        "by the side of", "neighbouring", "neighboring",
    ),
    "nearest": ("nearest to", "nearest the", "closest to", "closest the", "nearer to", "closer to"),
    "farthest": ("farthest from", "furthest from", "farthest away from", "furthest away from", "most distant from"),
    "between": ("between", "in between", "in the middle of"),
    "top": ("on top of", "atop"),
    "above": ("above", "over"),
    "below": ("below", "under", "underneath", "beneath"),
}  # fmt: skip
_POSSESSIVE: Mapping[str, tuple[str, ...]] = {
    "left": ("to {} left", "on {} left", "on {} left side", "to {} left side"),
    "right": ("to {} right", "on {} right", "on {} right side", "to {} right side"),
    "front": ("in {} front",),
    "behind": ("at {} back",),
    "next": ("at {} side", "by {} side"),
}
_OWNERS = ("its", "their", "his", "her")
_ADVERBS = frozenset({"directly", "immediately", "immediate", "direct", "exactly"})
_LOOSE_ADVERBS = frozenset({"just", "closely", "somewhere", "anywhere", "right"})
_AFTER_RIGHT = frozenset({"next", "beside", "behind", "in", "between", "above", "adjacent", "on", "by"})


def _table() -> dict[tuple[str, ...], tuple[str, str]]:
    table = {tuple(p.split()): (name, "") for name, phrases in _PHRASES.items() for p in phrases}
    for name, phrases in _POSSESSIVE.items():
        table |= {tuple(p.format(o).split()): (name, o) for p in phrases for o in _OWNERS}
    return table


_TABLE = _table()
_LONGEST = max(map(len, _TABLE))


@dataclass(frozen=True, slots=True)
class Relation:
    """Words of a relation: tokens[start:end]. `direct`: nothing may stand between ("directly", "immediately").

    `owner`: the landmark is the pronoun within them ("to its left"), else it follows.
    """

    name: str
    start: int
    end: int
    direct: bool = False
    owner: str = ""


def relations(tokens: Sequence[Token]) -> tuple[Relation, ...]:
    """The relation words in a step, in order, longest first; adverbs before or within them belong to them."""
    return tuple(_scan(tokens))


def _scan(tokens: Sequence[Token]) -> Iterator[Relation]:
    at = 0
    while at < len(tokens):
        found = None if at and _of_verb(tokens[at - 1].text, tokens[at].text) else _match(tokens, at)
        if found is None:
            at += 1
            continue
        yield found
        at = found.end


def _of_verb(before: str, word: str) -> bool:
    """ "Hand over": a word that belongs to the verb before it says nothing of where a thing is."""
    return f"{before}_{word}" in lexicon().synonyms


def _match(tokens: Sequence[Token], at: int) -> Relation | None:
    words: list[str] = []
    ends: list[int] = []
    direct = False
    i = at
    while i < len(tokens) and len(words) < _LONGEST:
        text = tokens[i].text
        if text in _ADVERBS or text == "-":
            direct = direct or text in _ADVERBS
        elif not (text in _LOOSE_ADVERBS and _is_adverb(tokens, i)):
            words.append(text)
            ends.append(i + 1)
        if not words and i == at and text == "-":
            return None
        i += 1
    for size in range(len(words), 0, -1):
        hit = _TABLE.get(tuple(words[:size]))
        if hit is not None:
            name, owner = hit
            said = [t.text for t in tokens[at : ends[size - 1]]]
            return Relation(name, at, ends[size - 1], bool(_ADVERBS & set(said)) or _right_next(said), owner)
    return None


def _is_adverb(tokens: Sequence[Token], i: int) -> bool:
    nxt = tokens[i + 1].text if i + 1 < len(tokens) else ""
    return tokens[i].text != "right" or nxt in _AFTER_RIGHT


def _right_next(said: Sequence[str]) -> bool:
    return said[0] == "right" and len(said) > 1 and said[1] in _AFTER_RIGHT


# -- ranks ---------------------------------------------------------------------------------------------------------

_SUPERLATIVES: Mapping[str, str] = {
    "leftmost": "left", "rightmost": "right", "frontmost": "front", "foremost": "front", "rearmost": "back",
    "backmost": "back", "hindmost": "back", "largest": "large", "biggest": "large", "greatest": "large",
    "larger": "large", "bigger": "large", "smallest": "small", "tiniest": "small", "littlest": "small",
    "smaller": "small", "tallest": "tall", "taller": "tall", "shortest": "short", "shorter": "short",
    "nearest": "near", "closest": "near", "farthest": "far", "furthest": "far",
}  # fmt: skip
_SIDES_OF: Mapping[str, str] = {"left": "left", "right": "right", "front": "front", "rear": "back", "back": "back"}
_END_NOUNS = frozenset({"end", "side", "edge", "corner", "part", "half", "hand", "-"})
_MIDDLE = frozenset({"middle", "central", "centre", "center"})
_COUNTED_FROM = frozenset({"from", "counting", "counted", "starting"})
_BEING = frozenset({"that", "which", "is", "thats", "stands", "lies", "sits", "standing", "lying", "sitting"})
_AT_AN_END = frozenset({"on", "at", "to", "in"})


@dataclass(frozen=True, slots=True)
class Ranked:
    """A noun phrase with its rank taken out: the `rank`-th (0: the middle one) from an end of `relations.DIRECTIONS`,
    or from what is `near` or `far`.

    `core` are the other tokens and `stop` is where the phrase ends with its rank. `plain`: it was said by a mere
    adjective ("the left block"), which may be none.
    """

    core: tuple[Token, ...]
    end: str
    rank: int
    stop: int
    plain: bool = False


def rank_of(tokens: Sequence[Token], start: int, end: int) -> Ranked | None:
    """The rank in the phrase tokens[start:end] ("the second largest block") or right after it ("from the left", "on the
    right"); None without one."""
    parts = list(tokens[start:end])
    number, said = _ordinal(parts)
    best = next((t for t in parts if t.text in _SUPERLATIVES), None)
    if best is not None and any(t.text in lexicon().numbers for t in parts):
        return None  # "the two smallest": a number of things, and not the one of a rank
    if best is not None:
        return Ranked(_without(parts, (*said, best)), _SUPERLATIVES[best.text], number or 1, end)
    for k in range(start + 1, min(end, len(tokens) - 1) + 1):
        side, stop = _end_at(tokens, k) if k < end else _outermost(tokens, k) or _end_at(tokens, k)
        if side:
            return Ranked(_without(tokens[start:k], said), side, number or 1, max(stop, end))
    if number is not None:
        return None
    over = {a.start for a, b in pairwise(parts) if a.text == "left" and lexicon().is_(b.text, "inner", "there")}
    word = next((t for t in parts if (t.text in _MIDDLE or t.text in _SIDES_OF) and t.start not in over), None)
    if word is None:
        return None
    middle = word.text in _MIDDLE
    return Ranked(
        _without(parts, (word,)), "left" if middle else _SIDES_OF[word.text], 0 if middle else 1, end, plain=True
    )


def side_of(tokens: Sequence[Token], start: int, end: int) -> Ranked | None:
    """The rank in "the block at the very back of X": where X is a place that things stand on, its last one there.
    `stop` is where the words for X begin."""
    k = end
    while k < len(tokens) and tokens[k].text in _BEING:
        k += 1
    if k >= len(tokens) or tokens[k].text not in _AT_AN_END | {"from"}:
        return None
    k += 1
    while k < len(tokens) and tokens[k].text in {"the", "very", "far"}:
        k += 1
    if k + 2 >= len(tokens) or tokens[k].text not in _SIDES_OF:
        return None
    side = _SIDES_OF[tokens[k].text]
    while k + 1 < len(tokens) and tokens[k + 1].text in _END_NOUNS:
        k += 1
    if k + 2 >= len(tokens) or tokens[k + 1].text not in {"of", "in"}:
        return None
    return Ranked(_without(tokens[start:end], ()), side, 1, k + 2)


def _end_at(tokens: Sequence[Token], k: int) -> tuple[str, int]:
    """The side that "from the left", "on the right" names from tokens[k] on, and where the words end. "On the left of
    X" is a relation and no end."""
    if tokens[k].text not in _COUNTED_FROM | _AT_AN_END:
        return "", k
    j = k + 1
    while j < len(tokens) and tokens[j].text in {"from", "the", "on", "at", "far", "very"}:
        j += 1
    if j >= len(tokens) or tokens[j].text not in _SIDES_OF:
        return "", k
    side = _SIDES_OF[tokens[j].text]
    while j + 1 < len(tokens) and tokens[j + 1].text in _END_NOUNS:
        j += 1
    of = j + 1 < len(tokens) and tokens[j + 1].text == "of"
    return ("", k) if of and tokens[k].text not in _COUNTED_FROM else (side, j + 1)


def _outermost(tokens: Sequence[Token], k: int) -> tuple[str, int] | None:
    """ "Furthest to the left", "that is furthest left", right behind a noun."""
    while k < len(tokens) and tokens[k].text in _BEING:
        k += 1
    if k + 1 >= len(tokens) or tokens[k].text not in {"furthest", "farthest", "nearest", "closest"}:
        return None
    far = tokens[k].text in {"furthest", "farthest"}
    k += 1
    while k + 1 < len(tokens) and tokens[k].text in {"to", "the", "at", "towards", "toward"}:
        k += 1
    if tokens[k].text not in _SIDES_OF:
        return None
    side, ends = _SIDES_OF[tokens[k].text], k
    while k + 1 < len(tokens) and tokens[k + 1].text in _END_NOUNS:
        k += 1
    of = k + 1 < len(tokens) and tokens[k + 1].text == "of"
    return (side, k + 1) if not of and (far or k > ends or side in {"front", "back"}) else None


def _ordinal(parts: Sequence[Token]) -> tuple[int | None, tuple[Token, ...]]:
    """ "second" or "2nd", and the tokens that say it."""
    ordinals = lexicon().ordinals
    for t, after in zip(parts, [*parts[1:], None], strict=False):
        if t.text in ordinals:
            return ordinals[t.text], (t,)
        if (
            t.digits
            and len(t.text) < 4
            and after is not None
            and after.glued
            and after.text in {"st", "nd", "rd", "th"}
        ):
            return int(t.text), (t, after)
    return None, ()


def _without(parts: Sequence[Token], gone: Sequence[Token]) -> tuple[Token, ...]:
    kept = [t for t in parts if t not in gone and t.text not in {"far", "very", "most", "hand", "-"}]
    while kept and kept[-1].text == ",":
        kept.pop()
    return tuple(kept)
