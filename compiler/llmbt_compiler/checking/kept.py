"""What a request wants left where it is, and the goals move all the same, or put something else in its place."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from llmbt_atl.library import Library
from llmbt_compiler.checking.referring import landmark, meant_objects
from llmbt_compiler.checking.sentences import one_line, sentence_at, span_of
from llmbt_compiler.parsing import Goal
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["moved_all_the_same"]

_STAYING = frozenset({"stay", "stays", "remain", "remains", "staying", "remaining"})
_KEEPING = frozenset({"keep", "keeps", "leave", "leaves", "leaving", "keeping"})
_TOUCHING = frozenset({"touch", "move", "moving", "touching", "moved", "touched", "moves", "budge", "shift", "disturb"})
_TOUCHED = frozenset({"moved", "touched", "disturbed", "shifted", "budge", "move"})
_REMOVED = frozenset(
    {"taken", "removed", "lifted", "displaced", "relocated", "moved", "touched", "disturbed", "shifted"}
)
_NEVER = frozenset(
    {("under", "no", "circumstances"), ("on", "no", "account"), ("in", "no", "case"), ("at", "no", "time")}
)
_OUT = frozenset({"out", "from", "off", "away", "down"})
_NOT = frozenset(
    {"not", "dont", "doesnt", "never", "without", "cannot", "cant", "mustnt", "longer", "shouldnt", "wont", "isnt"}
)
_LATER = frozenset({"until", "till", "if", "unless", "or", "then", "after", "afterwards", "once", "first", "when"})
_OTHERS = frozenset({"other", "others", "rest", "remaining", "else", "everything", "nothing", "they", "everybody"})
_IN = frozenset({"in", "on", "at", "inside"})
_ONTO = _IN | {"onto", "into", "to"}


@dataclass(frozen=True, slots=True)
class _Kept:
    """Objects that are to stay, said by words[start:end]; `within` is where, or None: exactly where they are."""

    ids: tuple[str, ...]
    start: int
    end: int
    within: str | None = None


def moved_all_the_same(
    request: str, goals: Sequence[Goal], semantic_map: SemanticMap, library: Library
) -> Iterator[Diagnostic]:
    """E343 for each thing that is to stay by the request's words and that a goal moves, or whose place another thing is
    to have."""
    scene = Scene(semantic_map, library)
    line = one_line(request)
    words = tokens(line)
    where = {o.id: o.place for o in semantic_map.objects}
    placed = [g.condition.args for g in goals if g.condition.name == "On" and not g.condition.negated]
    for kept in _kept(words, line, scene, where):
        for id_ in kept.ids:
            here = where.get(id_)
            allowed = kept.within if kept.within is not None else here
            gone = next((p for o, p in placed if o == id_ and allowed is not None and not _at(p, allowed, scene)), None)
            other = next((o for o, p in placed if o != id_ and p == here and scene.single(p)), None)
            other = other or _wanted_there(words, line, kept, id_, here, scene)
            if gone is None and (other is None or (kept.within is not None and kept.within != here)):
                continue
            what = f"it is to go to {gone}" if gone is not None else f"{other} is to go to {here}, where it stands"
            span = span_of(words[kept.start : kept.end], line)
            title = f"the request contradicts itself, or the reply the request: {id_} is to stay, and {what}"
            yield Diagnostic("E343", title, span, f"{id_} is to stay", "say which of the two is wanted")


def _wanted_there(
    words: Sequence[Token], line: str, kept: _Kept, id_: str, here: str | None, scene: Scene
) -> str | None:
    """What another sentence of the request wants on the one position where a thing is to stay, whatever the reply
    makes of it."""
    if here is None or not scene.single(here):
        return None
    for place in mentions_in(words, scene):
        begin, end = sentence_at(words, place.start)
        led = place.start > begin and words[place.start - 1].text in _ONTO
        if place.id != here or not led or kept.start <= place.start <= kept.end:
            continue
        begin = kept.end if begin <= kept.start < place.start else begin
        if any(t.text in _LATER for t in words[begin:end]):
            continue
        named = {m.id for m in mentions_in(words, scene) if begin <= m.start < place.start and scene[m.id].movable}
        named |= {i for m in meant_objects(words, line, scene) if begin <= m.start < place.start for i in m.ids}
        if named and id_ not in named:
            return min(named)
    return None


def _at(place: str, allowed: str, scene: Scene) -> bool:
    return scene.within(place, allowed) or scene.within(allowed, place)


def _kept(words: Sequence[Token], line: str, scene: Scene, where: dict[str, str | None]) -> Iterator[_Kept]:
    for i, t in enumerate(words):
        begin, end = sentence_at(words, i)
        if any(w.text in _LATER for w in words[begin:end]):
            continue
        if t.text in _STAYING and not any(w.text in _NOT for w in words[max(begin, i - 3) : i]):
            place, stop = _place(words, i + 1, end, scene)
            pointed = "there" in [w.text for w in words[i + 1 : i + 3]]
            subject, start = _subject(words, i, begin, line, scene, where, pointed=pointed)
            said = place is not None or "where" in [w.text for w in words[i : i + 4]]
            if subject and (said or not lexicon().is_(words[start].text, "pronouns")):
                yield _Kept(subject, start, stop, place)
        elif t.text in {"keeps", "keep"} and [w.text for w in words[i + 1 : i + 3]] in (
            ["its", "place"],
            ["its", "position"],
        ):
            subject, start = _subject(words, i, begin, line, scene, where, pointed=False)
            yield _Kept(subject, start, i + 3)
        elif t.text in _TOUCHING and any(w.text in _NOT for w in words[max(begin, i - 3) : i]):
            found = _object(words, i + 1, scene, where)
            if found:
                named = landmark(words, i + 1, scene)
                yield _Kept(found, i, named.end if named is not None else i + 1)
            elif t.text in {"move", "moves", "moved", "budge"}:
                subject, start = _subject(words, i, begin, line, scene, where, pointed=False)
                yield _Kept(subject, start, i + 1)
        elif t.text in _REMOVED and _denied(words, begin, i, end):
            subject, start = _subject(words, i, begin, line, scene, where, pointed=False)
            yield _Kept(subject, start, i + 1)
        elif t.text in _TOUCHED and (found := _nothing_on(words, begin, i, scene, where)):
            yield _Kept(found, begin, i + 1)
        elif t.text in {"leave", "leaves"} and any(w.text in _NOT for w in words[max(begin, i - 2) : i]):
            place, stop = _place(words, i, end, scene)
            subject, start = _subject(words, i, begin, line, scene, where, pointed=False)
            if place is not None:
                yield _Kept(subject, start, stop, place)
        elif t.text in _KEEPING:
            found = _object(words, i + 1, scene, where)
            after = [w.text for w in words[i + 2 : end]]
            place = _left_on(words, i + 1, end, scene)
            there = place is not None and all(scene.within(where.get(o), place) for o in found)
            if found and place is not None and there and "where" not in after:
                yield _Kept(found, i, end, place)
            elif found and ("where" in after or "alone" in after or "untouched" in after):
                yield _Kept(found, i, end)


def _denied(words: Sequence[Token], begin: int, i: int, end: int) -> bool:
    """ "Under no circumstances may X be taken out of there", "X must not be removed": in the passive voice."""
    said = [w.text for w in words[begin:i]]
    if "be" not in said[-2:] or (words[i].text == "taken" and not {w.text for w in words[i + 1 : end][:3]} & _OUT):
        return False
    never = any(tuple(said[k : k + 3]) in _NEVER for k in range(len(said)))
    return never or bool(set(said[-4:]) & _NOT)


def _nothing_on(
    words: Sequence[Token], begin: int, i: int, scene: Scene, where: dict[str, str | None]
) -> tuple[str, ...]:
    """ "Nothing that's on the shelf now may be moved", "none of the things on level 2 must be touched"."""
    none = next((k for k in range(i - 1, begin - 1, -1) if words[k].text in {"nothing", "none"}), None)
    if none is None:
        return ()
    places = [m.id for m in mentions_in(words, scene) if none < m.start < i and not scene[m.id].movable]
    return tuple(o for o, p in where.items() if len(places) == 1 and scene.within(p, places[0]))


def _place(words: Sequence[Token], at: int, end: int, scene: Scene) -> tuple[str | None, int]:
    """ "... in the sorting area", "... the bar" right behind a verb of staying or leaving."""
    begin = at + 1 if at < end and words[at].text in _IN | {"leave", "leaves"} else at
    if begin == at:
        return None, at
    for length in range(min(5, end - begin), 0, -1):
        found = resolve_places(words[begin : begin + length], scene, Talk())
        if isinstance(found, Found) and len(found.ids) == 1 and not {ANYWHERE, ORIGIN} & set(found.ids):
            return found.ids[0], begin + length
    return None, at


def _object(words: Sequence[Token], at: int, scene: Scene, where: dict[str, str | None]) -> tuple[str, ...]:
    found = landmark(words, at, scene)
    return _pointed(words, at, found.end, found.ids, scene, where) if found is not None else ()


def _left_on(words: Sequence[Token], at: int, end: int, scene: Scene) -> str | None:
    """ "Leave the red block in the sorting area": the place named right behind what is to be left."""
    found = landmark(words, at, scene)
    return _place(words, found.end, end, scene)[0] if found is not None and found.end < end else None


def _subject(
    words: Sequence[Token],
    i: int,
    begin: int,
    line: str,
    scene: Scene,
    where: dict[str, str | None],
    *,
    pointed: bool,
) -> tuple[tuple[str, ...], int]:
    """What a verb of staying is said of: the last thing named before it in its clause, or what "it" stands for."""
    spans = [(m.start, m.end, m.ids) for m in meant_objects(words[:i], line, scene)]
    spans += [(m.start, m.end, (m.id,)) for m in mentions_in(words[:i], scene) if scene[m.id].movable]
    spans.sort()
    pronoun = next((k for k in range(i - 1, begin - 1, -1) if lexicon().is_(words[k].text, "pronouns")), None)
    inside = [s for s in spans if s[0] >= begin]
    last = inside[-1] if inside else None
    between = {t.text for t in words[last[1] : i]} if last is not None else set[str]()
    if between & _OTHERS or (pronoun is None and between & {"and", ","}):
        return (), i
    clause = max((k for k in range(begin, i) if words[k].text in {",", "and", "but"}), default=begin)
    if last is not None and (last[0] >= clause or pronoun is None):
        return _pointed(words, last[0], last[1], last[2], scene, where), last[0]
    if pronoun is not None and not pointed and spans:
        near = [s for s in spans if s[1] <= pronoun]
        single = near[-1] if near else None
        if single is not None:
            return _pointed(words, single[0], single[1], single[2], scene, where), pronoun
    return (), i


def _pointed(
    words: Sequence[Token], start: int, end: int, ids: Sequence[str], scene: Scene, where: dict[str, str | None]
) -> tuple[str, ...]:
    """Of several things that a phrase fits those that are "there": on the last place named before it."""
    if len(ids) <= 1:
        return tuple(ids)
    if not any(t.text in {"there", "thats", "already"} for t in words[end : end + 5]):
        return ()
    places = [m.id for m in mentions_in(words[:start], scene) if not scene[m.id].movable]
    places += [i for k in range(1, start) for i in _bare(words, k, scene)]
    at = places[-1] if places else None
    there = tuple(i for i in ids if at is not None and scene.within(where.get(i), at))
    return there if len(there) == 1 else ()


def _bare(words: Sequence[Token], k: int, scene: Scene) -> tuple[str, ...]:
    """ "On 12": the one place with this number."""
    if not words[k].digits or words[k - 1].text not in _ONTO:
        return ()
    found = tuple(p.id for p in scene.places if p.number == words[k].number)
    return found if len(found) == 1 else ()
