"""Of what somebody says that it stays: "the green one", "whatever is on it", "the block that's there"."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_compiler.checking.referring import landmark, meant_objects, place_named
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.checking.wording import phrase_at
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["Span", "here_named", "object_at", "places_before", "pointed_back", "subject_before"]

Span = tuple[int, int, tuple[str, ...]]
"""Where words begin and end, and what they stand for."""
_OTHERS = frozenset({"other", "others", "rest", "remaining", "else", "everything", "nothing", "they", "everybody"})
_WHAT = frozenset({"whats", "what", "whatever", "anything", "everything", "thing"})
_BEING = frozenset(
    {"is", "stands", "sits", "lies", "standing", "sitting", "already", "currently", "now", "that", "right"}
)
_IN = frozenset({"on", "in", "at", "inside"})
_NOUNS = frozenset({"one", "block", "cube", "box", "thing", "object", "item"})
_EXCEPTING = frozenset({"but", "except", "apart", "besides", "else", "other", "than", "save", "unless"})
_NEAR = 6


def object_at(words: Sequence[Token], at: int, scene: Scene, where: dict[str, str | None]) -> Span | None:
    """What is named right here: an occupant of a position, a thing, or the one of several that stands on the position
    that was named last."""
    occupant = _occupant(words, at, scene, where) or _all_standing(words, at, scene, where)
    if occupant is not None:
        return occupant
    found = landmark(words, at, scene)
    if found is None or not found.ids or not scene[found.ids[0]].movable:
        return None
    ids = _pointed(words, at, found.end, found.ids, scene, where)
    return (at, found.end, ids) if ids else None


def pointed_back(words: Sequence[Token], at: int, scene: Scene, where: dict[str, str | None]) -> Span | None:
    """ "(Bring the milk to me and leave) it": the one thing that was named before."""
    if words[at].text != "it":
        return None
    named = {i for s in _things(words, at, "", scene, where) for i in s[2]}
    return (at, at + 1, tuple(named)) if len(named) == 1 else None


def subject_before(
    words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None], *, pointed: bool
) -> tuple[tuple[str, ...], int]:
    """What a verb of staying is said of: the last thing named before it in its clause, or what "it" stands for."""
    begin, _ = sentence_at(words, i)
    spans = _things(words, i, line, scene, where)
    pronoun = next((k for k in range(i - 1, begin - 1, -1) if lexicon().is_(words[k].text, "pronouns")), None)
    inside = [s for s in spans if s[0] >= begin]
    last = inside[-1] if inside else None
    if last is not None and pronoun is not None and last[0] <= pronoun < last[1]:
        pronoun = None  # "whatever is on it"
    between = {t.text for t in words[last[1] : i]} if last is not None else set[str]()
    if between & _OTHERS or (pronoun is None and between & {"and", ","}):
        return (), i
    clause = max((k for k in range(begin, i) if words[k].text in {",", "and", "but", "-"}), default=begin)
    if last is not None and (last[0] >= clause or pronoun is None):
        return _pointed(words, last[0], last[1], last[2], scene, where), last[0]
    near = [s for s in spans if pronoun is not None and s[1] <= pronoun]
    if pronoun is not None and not pointed and near:
        return _pointed(words, near[-1][0], near[-1][1], near[-1][2], scene, where), pronoun
    return (), i


def _things(words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]) -> tuple[Span, ...]:
    """The phrases for things before words[i], in order, none within another."""
    spans = [(m.start, m.end, m.ids) for m in meant_objects(words[:i], line, scene)]
    spans += [(m.start, m.end, (m.id,)) for m in mentions_in(words[:i], scene) if scene[m.id].movable]
    for k in range(i):
        found = _occupant(words, k, scene, where) or _all_standing(words, k, scene, where)
        if found is None and lexicon().is_(words[k].text, "definite"):
            mark = landmark(words[:i], k, scene)
            found = (k, mark.end, mark.ids) if mark is not None and mark.ids and scene[mark.ids[0]].movable else None
        if words[k].text in scene.colours and (k + 1 == i or words[k + 1].text not in _NOUNS):
            spans.append((k, k + 1, tuple(e.id for e in scene.objects if words[k].text in e.colour)))
        if found is not None and found[1] <= i:
            spans.append(found)
    kept: list[Span] = []
    for start, end, ids in sorted(spans, key=lambda s: (s[0], -s[1])):
        if not kept or start >= kept[-1][1]:
            kept.append((start, end, ids))
    return tuple(kept)


def _occupant(words: Sequence[Token], at: int, scene: Scene, where: dict[str, str | None]) -> Span | None:
    """ "What's there", "whatever is on it", "what's on 12": the one thing on the position that is meant."""
    end = phrase_at(words, at, "staying", "occupant") or _what_is_there(words, at)
    place = next(iter(places_before(words, at, scene)), None) if end else None
    if not end and words[at].text in _WHAT:
        end = at + 1
        while end < len(words) and words[end].text in _BEING:
            end += 1
        if end + 1 >= len(words) or words[end].text not in _IN:
            return None
        place, stop = place_named(words, end + 1, scene)
        here = here_named(words, end + 1, scene) if place is None else ()
        place, end = (place, stop) if place is not None else (here[0], end + 2) if here else (None, end)
    there = tuple(o for o, p in where.items() if place is not None and scene.single(place) and p == place)
    return (at, end, there) if len(there) == 1 else None


def _what_is_there(words: Sequence[Token], at: int) -> int:
    """ "What's standing in there now", "whatever is sitting on it": where these words end; 0 where they are none."""
    end = at + 1
    while end < len(words) and words[end].text in _BEING:
        end += 1
    if words[at].text not in _WHAT or end == at + 1 - int(words[at].text == "whats" or words[at].owner):
        return 0
    end += int(end < len(words) and words[end].text in _IN)
    return end + 1 if end < len(words) and words[end].text in {"there", "it"} else 0


def _all_standing(words: Sequence[Token], at: int, scene: Scene, where: dict[str, str | None]) -> Span | None:
    """ "Whatever stands on the shelf", "anything that's on level 2": all that is on a place with others in it, where
    nothing is taken out of it."""
    end = at + 1
    while end < len(words) and words[end].text in _BEING | {"thats", "already", "there"}:
        end += 1
    if words[at].text not in _WHAT | {"all"} or end + 1 >= len(words) or words[end].text not in _IN:
        return None
    place, stop = place_named(words, end + 1, scene)
    _, close = sentence_at(words, at)
    if place is None or scene.single(place) or {t.text for t in words[stop:close]} & _EXCEPTING:
        return None
    there = tuple(o for o, p in where.items() if scene.within(p, place))
    return (at, stop, there) if there else None


def _pointed(
    words: Sequence[Token], start: int, end: int, ids: Sequence[str], scene: Scene, where: dict[str, str | None]
) -> tuple[str, ...]:
    """Of several things that a phrase fits the one that is on the position named before it, or the last place."""
    if len(ids) <= 1:
        return tuple(ids)
    said = {t.text for t in words[start:end]}
    if said & _OTHERS or any(t.text in lexicon().numbers for t in words[start : end - 1]):
        return ()
    told = any(t.text in {"there", "thats", "already", "it"} for t in words[end : end + _NEAR])
    places = [p for p in places_before(words, start, scene) if told or scene.single(p)]
    there = tuple(i for i in ids if places and scene.within(where.get(i), places[0]))
    return there if len(there) == 1 else ()


def places_before(words: Sequence[Token], at: int, scene: Scene) -> Iterator[str]:
    """The places named before words[at], the last one first."""
    named = {m.start: m.id for m in mentions_in(words[:at], scene) if not scene[m.id].movable}
    for k in range(at - 1, -1, -1):
        yield from here_named(words, k, scene) if k not in named else (named[k],)


def here_named(words: Sequence[Token], k: int, scene: Scene) -> tuple[str, ...]:
    """ "On 12", "number 12": the one place with this number, where no thing has it."""
    if not words[k].digits or any(e.number == words[k].number for e in scene.objects):
        return ()
    found = tuple(p.id for p in scene.places if p.number == words[k].number)
    return found if len(found) == 1 else ()
