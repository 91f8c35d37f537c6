"""Where a thing is said to stand, and whether what follows a phrase tells more of it, or where it is to go."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile

from llmbt_compiler.checking.referring.lists import (
    AT,
    CLAUSE,
    DOWN,
    ENDING,
    FETCHING,
    MODAL,
    ONTO,
    OTHERS,
    POINTING,
    PUTTING,
    STANDING,
    TELLING,
)
from llmbt_compiler.checking.referring.nouns import noun
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.checking.telling import along, uncheckable
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.words import Token

__all__ = ["clause", "elsewhere", "from_before", "goes_on", "place_named", "puts", "standing_there", "tells"]


def standing_there(
    words: Sequence[Token], at: int, ids: Sequence[str], scene: Scene, where: dict[str, str | None]
) -> tuple[tuple[str, ...], int]:
    """Those on the place that is named after the phrase, if some of them are there; and where those words end."""
    begin = at
    while begin < len(words) and words[begin].text in STANDING:
        begin += 1
    if begin + 1 < len(words) and words[begin].text in DOWN and words[begin + 1].text in AT:
        begin += 1
    rest = words[begin:]
    if rest and rest[0].text in AT:
        end = next((k for k, t in enumerate(rest[1:]) if t.text in ENDING), len(rest) - 1)
        for length in range(min(6, end), 0, -1):
            if not (rest[length].word or rest[length].number is not None):
                continue
            place = resolve_places(rest[1 : 1 + length], scene, Talk())
            if isinstance(place, Found) and len(place.ids) == 1 and place.ids[0] in {p.id for p in scene.places}:
                there = tuple(o for o in ids if scene.within(where.get(o), place.ids[0]))
                if there:
                    return there, begin + 1 + length
    return tuple(ids), at


def place_named(words: Sequence[Token], at: int, scene: Scene) -> tuple[str | None, int]:
    """The one place that is named right here by words that name nothing else, and where they end."""
    limit = next((k for k in range(at, len(words)) if words[k].text in ENDING), len(words))
    for length in range(min(6, limit - at), 0, -1):
        found = resolve_places(words[at : at + length], scene, Talk())
        if isinstance(found, Found) and len(found.ids) == 1 and found.ids[0] in {p.id for p in scene.places}:
            return found.ids[0], at + length
    return None, at


def clause(words: Sequence[Token], at: int) -> bool:
    """Whether a clause on where a thing stands begins right here: "that's on", "standing on", "from"."""
    return at < len(words) and (words[at].text in CLAUSE or [t.text for t in words[at : at + 2]] == ["what", "is"])


def elsewhere(words: Sequence[Token], end: int, scene: Scene) -> bool:
    """Whether a clause right behind a phrase names a place, where nothing of the kind is: "that is on the shelf"."""
    begin = end
    while begin < len(words) and words[begin].text in STANDING:
        begin += 1
    led = end < begin < len(words) and clause(words, end) and words[begin].text in {"on", "in", "at"}
    return led and place_named(words, begin + 1, scene)[0] is not None


def from_before(
    words: Sequence[Token], start: int, ids: Sequence[str], scene: Scene, where: dict[str, str | None]
) -> tuple[str, ...]:
    """ "From the bar, take the box": of those, what stands there."""
    begin = sentence_at(words, start)[0]
    led = begin < start and words[begin].text in {"from", "off"}
    place = place_named(words, begin + 1, scene)[0] if led else None
    there = tuple(i for i in ids if place is not None and scene.within(where.get(i), place))
    return there or tuple(ids)


def _verbs(words: Sequence[Token]) -> list[str]:
    """The verbs that put or fetch; "position 12" has none."""
    after = [*(t.number for t in words[1:]), None]
    return [t.text for t, n in zip(words, after, strict=False) if n is None and t.text in PUTTING | FETCHING]


def puts(words: Sequence[Token], start: int) -> bool:
    """Whether the last verb before a phrase puts it somewhere, and not something else next to it."""
    if any(start - 2 < r.end <= start for r in relations(words)):
        return False
    said = _verbs(words[:start])
    return bool(said) and said[-1] in PUTTING


def goes_on(words: Sequence[Token], start: int, stop: int) -> bool:
    """Whether another place is named after a relation, or the verb before it puts nothing anywhere."""
    after = list(takewhile(lambda t: t.text not in {".", ";", "!", "?"}, words[stop:]))
    said = _verbs(words[:start])
    others = any(t.text in OTHERS for t in words[sentence_at(words, start)[0] : start])
    aside = any(t.text in {"over", "along", "sideways"} for t in after)
    return aside or any(t.text in ONTO for t in after) or bool(said and said[-1] in FETCHING) or others


def _wanted_at(words: Sequence[Token], at: int) -> bool:
    """ "(The green block) I need over on the shelf": where somebody wants it, which tells nothing of it."""
    k = at + 1
    if words[at].text not in {"i", "we", "id", "wed"}:
        return False
    while k < len(words) and words[k].text in {"would", "now", "also", "really", "only"}:
        k += 1
    if k >= len(words) or words[k].text not in {"need", "want", "like"}:
        return False
    k += 1
    while k < len(words) and words[k].text in {"over", "up", "down", "back", "put", "moved", "to", "go", "brought"}:
        k += 1
    return k < len(words) and words[k].text in ONTO | {"on", "in", "at"}


def tells(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """Whether what stands right after a phrase may tell which one is meant, in words that are not understood here."""
    if along(words, at):
        return True
    if at >= len(words) or words[at].text not in TELLING or uncheckable(words, at, scene):
        return False
    if [t.text for t in words[at : at + 2]] in (["i", "mean"], ["i", "meant"]):
        return False
    if _wanted_at(words, at):
        return False  # "the other green I need on position 14"
    if words[at].text == "with":  # "swap the red block with the white one"
        return not (at + 1 < len(words) and words[at + 1].text in POINTING and noun(words, at + 1, scene))
    if any(r.start == at for r in relations(words)):
        return False  # it says where to
    if words[at].text in {"that", "which"} and at + 1 < len(words) and words[at + 1].text in MODAL:
        # "the green one that must go to level 2" does not tell, "that has a red neighbour" does
        return words[at + 1].text == "has" and [t.text for t in words[at + 2 : at + 3]] != ["to"]
    if words[at].text == "in":  # "in the sorting area", which is a destination; "in front", which tells
        return at + 1 < len(words) and words[at + 1].text in {"front", "between"}
    return words[at].text != "over"
