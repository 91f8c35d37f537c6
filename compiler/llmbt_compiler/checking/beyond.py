"""Places that a request counts to, or points to, and that are not there: beyond the end of a row, above the highest
level, the fifth of four, a second sorting area."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_compiler.checking.levels import levels_from
from llmbt_compiler.checking.referring import landmark, meant_objects, place_named
from llmbt_compiler.checking.sentences import sentence_at, span_of
from llmbt_compiler.checking.sides import nothing_beyond, shifts
from llmbt_compiler.parsing import Goal
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.rows import row_of
from llmbt_compiler.parsing.words import Token, lexicon, singulars
from llmbt_ir.diagnostics import Diagnostic

__all__ = ["beyond"]

_SLOTS = frozenset({"slot", "place", "position", "spot", "space", "berth", "bay", "seat", "compartment"})
_LEVELS = frozenset({"level", "tier", "storey", "row", "floor"})
_UP = frozenset({"up", "higher", "above", "upwards"})
_DOWN = frozenset({"down", "lower", "below", "beneath", "downwards"})
_BY = frozenset({"a", "an", "one", "two", "three", "by", "next", "another", "the", "single"})
_ADJECTIVES = frozenset({"free", "empty", "vacant", "available", "shelf", "of"})
_OTHERWISE = frozenset({"if", "unless", "not", "dont", "cannot", "cant", "until"})


def beyond(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[Diagnostic]:
    """E142 for each place that the words lead to where the map has none."""
    phrases = tuple(meant_objects(words, request, scene))
    moved = [o for g in goals if g.condition.name == "On" and (o := g.condition.args[0])]
    about = _about(words, request, moved, scene)
    where = {o.id: o.place for o in scene.map.objects}
    here = where.get(about) if about is not None else None
    for start, end, last in nothing_beyond(words, phrases, moved, scene):
        yield _told(words, start, end, request, f"is no position, {last} is the last one")
    for shift in shifts(words) if here is not None else ():
        if here is not None and shift.beyond(here, scene):
            yield _told(words, shift.start, shift.end, request, f"of {here} is no position")
    if here is not None:
        for start, end in _levels(words, here, scene):
            yield _told(words, start, end, request, f"of {here} is no level")
    for start, end in _over(words, scene):
        yield _told(words, start, end, request, "is no position")
    for start, end in _than(words, scene):
        yield _told(words, start, end, request, "is no level")
    for start, end, count in _counted(words, scene):
        yield _told(words, start, end, request, f"is no place, there are only {count}")


def _told(words: Sequence[Token], start: int, end: int, request: str, what: str) -> Diagnostic:
    said = request[words[start].start : words[end - 1].end]
    title = f"the request names what is not there: `{said}` {what}"
    return Diagnostic("E142", title, span_of(words[start:end], request), "beyond the end", "say another place")


def _about(words: Sequence[Token], request: str, moved: Sequence[str], scene: Scene) -> str | None:
    """The one thing that is moved, or that the request speaks of alone."""
    mentions = [m for m in mentions_in(words, scene) if scene[m.id].movable]
    named = {
        m.id for m in mentions if not (words[m.start].word and words[m.start].number)
    }  # "the red block one level up"
    named |= {m.ids[0] for m in meant_objects(words, request, scene) if len(m.ids) == 1}
    for k, t in enumerate(words):  # "red goes up one level"
        ids = [e.id for e in scene.objects if t.text in e.colour]
        if len(ids) == 1 and (k == 0 or not words[k - 1].word):
            named.add(ids[0])
    about = set(moved) or named
    return next(iter(about)) if len(about) == 1 else None


def _levels(words: Sequence[Token], here: str, scene: Scene) -> Iterator[tuple[int, int]]:
    """ "One level higher", "up by a level", "the level above": where there is none that far."""
    if not scene.single(here):
        return
    for i, t in enumerate(words):
        begin, end = sentence_at(words, i)
        if not set(singulars(t.text)) & _LEVELS or {w.text for w in words[begin:end]} & _OTHERWISE:
            continue
        stop = next((k + 1 for k in range(i + 1, min(end, i + 4)) if words[k].text in _UP | _DOWN), 0)
        first = i
        while first > begin and words[first - 1].text in _BY | _UP | _DOWN | {"shelf"}:
            first -= 1
        led = {w.text for w in words[first:i]}
        turned = led & {"raise", "lift"} or (begin < first and words[begin].text in {"raise", "lift"} and led & _BY)
        if not (stop and led & _BY) and not (led & (_UP | _DOWN) and led & _BY) and not (turned and led & _BY):
            continue
        if any(m.start <= i + 1 < m.end or m.start == i for m in mentions_in(words, scene)):
            continue
        said = (*words[first : max(stop, i + 1)], *([Token("up", t.start, t.end)] if turned and not stop else ()))
        ways = {w.text for w in said}
        if bool(ways & _UP) != bool(ways & _DOWN) and not levels_from(said, here, scene):
            yield first, max(stop, i + 1)


def _than(words: Sequence[Token], scene: Scene) -> Iterator[tuple[int, int]]:
    """ "One level higher than (where) the red block (is)", where that stands on the highest one."""
    where = {o.id: o.place for o in scene.map.objects}
    for i, t in enumerate(words[:-2]):
        if t.text not in _UP | _DOWN or words[i + 1].text != "than":
            continue
        mark = landmark(words, i + 2 + int(words[i + 2].text == "where"), scene)
        place = where.get(mark.ids[0]) if mark is not None and len(mark.ids) == 1 else None
        if mark is not None and place is not None and scene.single(place) and not levels_from((t,), place, scene):
            yield i, mark.end


def _over(words: Sequence[Token], scene: Scene) -> Iterator[tuple[int, int]]:
    """ "Above the red block", where that stands on the highest level."""
    where = {o.id: o.place for o in scene.map.objects}
    for relation in relations(words):
        if relation.name not in {"above", "below"} or relation.owner or words[relation.start].text == "over":
            continue
        mark = landmark(words, relation.end, scene)
        level = place_named(words, relation.end, scene)
        way = Token("up" if relation.name == "above" else "down", 0, 0)
        slot = next((p.id for p in scene.map.inside(level[0]) if scene.single(p.id)), None) if level[0] else None
        if slot is not None and level[0] in list(scene.map.containers(slot)) and not levels_from((way,), slot, scene):
            flat = not any(scene.map.inside(p.id) for p in scene.map.inside(level[0] or ""))
            if flat and len(list(scene.map.containers(slot))) > 1:
                yield relation.start, level[1]
            continue
        place = where.get(mark.ids[0]) if mark is not None and len(mark.ids) == 1 else None
        if mark is not None and place is not None and scene.single(place) and not levels_from((way,), place, scene):
            yield relation.start, mark.end


def _counted(words: Sequence[Token], scene: Scene) -> Iterator[tuple[int, int, int]]:
    """ "The fifth place", of four; "count six slots from the left"; "the second desk"."""
    slots = [p.id for p in scene.places if scene.single(p.id) and not p.person]
    longest = max((len(row_of(p, scene)) for p in slots), default=0)
    levels = {c for p in slots for c in list(scene.map.containers(p))[:1]}
    for i, t in enumerate(words):
        number = lexicon().ordinals.get(t.text)
        k = i + 1
        if (
            number is None
            and t.digits
            and k < len(words)
            and words[k].glued
            and words[k].text in {"st", "nd", "rd", "th"}
        ):
            number, k = int(t.text), k + 1
        while number is not None and k < len(words) and words[k].text in _ADJECTIVES:
            k += 1
        if number is not None and k < len(words):
            forms = set(singulars(words[k].text))
            known = _places(words, k, scene)
            if slots and forms & _SLOTS and number > longest:
                yield i, k + 1, longest
            elif slots and forms & _LEVELS and number > len(levels) > 0:
                yield i, k + 1, len(levels)
            elif known is not None and number > 1 and known[1] < number:
                yield i, known[0], known[1]
        counted = number is None and t.number is not None and t.number.isdecimal() and i + 1 < len(words)
        if counted and slots and set(singulars(words[i + 1].text)) & _SLOTS and int(t.number or 0) > longest:
            after = [w.text for w in words[i + 2 : i + 6]]
            if after[:1] == ["from"] and {"left", "right", "end"} & set(after) and int(t.number or 0) < 30:
                yield i, i + 2, longest


def _places(words: Sequence[Token], k: int, scene: Scene) -> tuple[int, int] | None:
    """Where a name of a place ends that begins right here, and how many there are of it."""
    for length in (3, 2, 1):
        parts = [t.text for t in words[k : k + length]]
        if len(parts) < length or not all(t.word and t.number is None for t in words[k : k + length]):
            continue
        name = " ".join(parts)
        hits = [p.id for p in sorted(scene.places, key=lambda p: natural(p.id)) if p.id.replace("_", " ") == name]
        if hits and not scene[hits[0]].person and (length > 1 or not scene.map.inside(hits[0])):
            return k + length, sum(scene.fits(p, parts[-1]) for p in scene.places) if length == 1 else len(hits)
    return None
