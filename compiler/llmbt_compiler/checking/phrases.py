"""Definite noun phrases of a request, and the objects that each may mean on the map as it is at the start."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile

from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import rank_of, relations
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["Meant", "definite"]

_POINTING = frozenset({"the", "that", "this", "my", "your"})
_TELLING = frozenset({
    "left", "right", "next", "beside", "behind", "front", "between", "nearest", "closest", "near", "above", "below",
    "nearer", "closer", "farthest", "furthest", "under", "underneath", "beneath", "top", "first", "second", "third",
    "last", "other", "same", "remaining", "rest", "that", "which", "whose", "who", "with", "in", "standing", "lying",
    "sitting", "by", "over", "whichever", "nobody", "you", "i", "we",
})  # fmt: skip
_STANDING = frozenset({
    "that", "which", "is", "stands", "standing", "lies", "lying", "sits", "sitting", "currently", "now", "still",
    "located", "stored", "placed", "already",
})  # fmt: skip
_AT = frozenset({"on", "in", "at", "from", "of", "off"})
_ENDING = frozenset({"on", "onto", "in", "into", "at", "from", "to", "and", ",", ".", "then", "over"})
_ONTO = frozenset({"on", "onto", "in", "into", "to", "next", "beside", "between", "above", "below"})
_MASS = frozenset({"cargo", "good", "everything"})
_PUTTING = frozenset({"put", "place", "set", "move", "lay", "position", "stand", "shift", "drop", "stow", "store"})
_FETCHING = frozenset({"pick", "take", "bring", "get", "fetch", "grab", "give", "hand", "want", "need", "collect"})
_LONGEST = 5


@dataclass(frozen=True, slots=True)
class Meant:
    """A phrase, words[start:end], and all the objects that it fits."""

    start: int
    end: int
    ids: tuple[str, ...]


def definite(words: Sequence[Token], line: str, scene: Scene) -> Iterator[Meant]:
    """Every phrase like "the green block", "the yellow one", "the largest block", "the block in the sorting area" with
    the objects that it fits; none where what stands after it may tell more than is understood here."""
    where = {o.id: o.place for o in scene.map.objects}
    named = False
    for i, t in enumerate(words):
        back = named and t.text in {"that", "this"}  # "position 12 ... that block": it points back
        named = named or (t.number is not None and t.digits) or t.text in scene.colours
        end = _noun(words, i, scene) if t.text in _POINTING and not back else 0
        if not end and _bare(words, i, scene):
            end = _noun(words, i - 1, scene)
            found = _plain(words, i, end, scene, where) if end else None
            if found is not None and found.ids:
                yield Meant(i, found.end, found.ids)
            continue
        if end:
            found = (
                _ranked(words, i + 1, end, line, scene, where)
                or _related(words, i + 1, end, line, scene, where)
                or _plain(words, i + 1, end, scene, where)
            )
            if found is not None and found.ids:
                yield Meant(i, found.end, found.ids)


def _bare(words: Sequence[Token], i: int, scene: Scene) -> bool:
    """Whether a phrase in a telegram's style begins: a colour with no article before it ("red block to level 2")."""
    before = words[i - 1].text if i else "."
    opens = before in {".", ",", ";", ":", "!", "?", "and", "then"} or before in _PUTTING | _FETCHING
    return opens and words[i].text in scene.colours


def _noun(words: Sequence[Token], i: int, scene: Scene) -> int:
    """Where the noun phrase that begins with an article at i ends; 0 where it is none about a single object."""
    for j in range(i + 1, min(len(words), i + 1 + _LONGEST)):
        t = words[j]
        after = words[j + 1] if j + 1 < len(words) else None
        if t.text == "one" and j > i + 1:
            return j + 1
        if not t.word or lexicon().is_(t.text, "all", "both", "rest", "same") or (t.number and t.text != "one"):
            return 0
        if t.text in lexicon().ordinals or t.text in lexicon().sizes or rank_of(words, j, j + 1) is not None:
            continue
        word = scene.word(t, True)
        if not word.text or word.corrected or word.text in _MASS:
            return 0
        if word.text not in scene.colours:
            return 0 if word.plural or (after is not None and after.number is not None) else j + 1
    return 0


def _ranked(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The second largest block", "the yellow block at the back": what has the rank, all of a tie."""
    of = rank_of(words, start, end)
    if of is None:
        return None
    if of.stop > end and not any(t.text in _ONTO for t in words[of.stop :]):
        return None  # "put the red block on the right": it says where to
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    pool = world.every(of.core, True)
    if isinstance(pool, Fault):
        return Meant(start, of.stop, ())
    ids, stop = _there(words, of.stop, pool[0], scene, where)
    if not ids or _tells(words, stop, scene):
        return Meant(start, stop, ())
    found = world.ranked(of, True, ids, words[start : of.stop], False)
    hit = found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())
    return Meant(start, of.stop, hit)


def _related(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The block next to object 5", where the relation tells which one; None where it says where it is to go."""
    begin = end
    while begin < len(words) and words[begin].text in _STANDING:
        begin += 1
    of = next((r for r in relations(words) if r.start == begin), None)
    stop = name_end(words, of) if of is not None else begin
    if of is None or not (begin > end or _goes_on(words, start, stop)):
        return None
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    phrase = [t for t in words[start:end] if t.text != "one"]
    pool = world.every(phrase, True)
    marks = world.landmark(words[of.end : stop]) if stop > of.end else None
    if isinstance(pool, Fault) or not isinstance(marks, Found):
        return Meant(start, stop, ())
    found = world.related(of, pool[0], marks.ids, words[start:stop], False)
    return Meant(
        start, stop, found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())
    )


def _goes_on(words: Sequence[Token], start: int, stop: int) -> bool:
    """Whether another place is named after a relation, or the verb before it puts nothing anywhere."""
    after = list(takewhile(lambda t: t.text not in {".", ";", "!", "?"}, words[stop:]))
    said = [t.text for t in words[:start] if t.text in _PUTTING or t.text in _FETCHING]
    return any(t.text in _ONTO for t in after) or bool(said and said[-1] in _FETCHING)


def _plain(words: Sequence[Token], start: int, end: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    phrase = [t for t in words[start:end] if t.text != "one"]
    told = any(t.text in lexicon().ordinals or t.text in lexicon().sizes or t.text in _TELLING for t in phrase)
    if told or not phrase or _parenthesis(words, end):
        return None
    every = (Token("all", phrase[0].start, phrase[0].start), *phrase)
    found = resolve_objects(every, scene, Talk())
    if not isinstance(found, Found):
        return None
    ids, stop = _there(words, end, found.ids, scene, where)
    return None if _tells(words, stop, scene) else Meant(start, end, ids)


def _parenthesis(words: Sequence[Token], at: int) -> bool:
    return at < len(words) and words[at].text == "("


def _there(
    words: Sequence[Token], at: int, ids: Sequence[str], scene: Scene, where: dict[str, str | None]
) -> tuple[tuple[str, ...], int]:
    """Those on the place that is named after the phrase, if some of them are there; and where those words end."""
    begin = at
    while begin < len(words) and words[begin].text in _STANDING:
        begin += 1
    rest = words[begin:]
    if rest and rest[0].text in _AT:
        end = next((k for k, t in enumerate(rest[1:]) if t.text in _ENDING), len(rest) - 1)
        for length in range(min(6, end), 0, -1):
            place = resolve_places(rest[1 : 1 + length], scene, Talk())
            if isinstance(place, Found) and len(place.ids) == 1 and place.ids[0] in {p.id for p in scene.places}:
                there = tuple(o for o in ids if scene.within(where.get(o), place.ids[0]))
                if there:
                    return there, begin + 1 + length
                return tuple(ids), at
    return tuple(ids), at


def _tells(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """Whether what stands right after a phrase may tell which one is meant, in words that are not understood here."""
    if at >= len(words) or words[at].text not in _TELLING:
        return False
    if words[at].text == "with":  # "swap the red block with the white one"
        return not (at + 1 < len(words) and words[at + 1].text in _POINTING and _noun(words, at + 1, scene))
    if any(r.start == at for r in relations(words)):
        return False  # it says where to
    if words[at].text == "in":  # "in the sorting area", which is a destination; "in front", which tells
        return at + 1 < len(words) and words[at + 1].text in {"front", "between"}
    return words[at].text != "over"
