"""What a request wants left where it is, and the goals move all the same, or put something else in its place."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from llmbt_atl.library import Library
from llmbt_compiler.checking.referring import meant_objects
from llmbt_compiler.checking.sentences import one_line, sentence_at, span_of
from llmbt_compiler.checking.spots import meant_places
from llmbt_compiler.checking.staying import here_named, object_at, pointed_back, subject_before
from llmbt_compiler.checking.wording import phrase_at
from llmbt_compiler.parsing import Goal
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["moved_all_the_same"]

_STAYING = frozenset({"stay", "stays", "remain", "remains", "staying", "remaining"})
_KEEPING = frozenset({"keep", "keeps", "leave", "leaves", "leaving", "keeping"})
_TOUCHING = frozenset(
    {
        "touch",
        "move",
        "moving",
        "touching",
        "moved",
        "touched",
        "moves",
        "budge",
        "shift",
        "disturb",
        "remove",
        "displace",
        "relocate",
        "removing",
        "shifting",
        "disturbing",
    }
)
_TOUCHED = frozenset({"moved", "touched", "disturbed", "shifted", "budge", "move"})
_MOVED = frozenset({"move", "moves", "moved", "budge"})
_REMOVED = frozenset(
    {"taken", "removed", "lifted", "displaced", "relocated", "moved", "touched", "disturbed", "shifted"}
)
_NEVER = frozenset(
    {("under", "no", "circumstances"), ("on", "no", "account"), ("in", "no", "case"), ("at", "no", "time")}
)
_OUT = frozenset({"out", "from", "off", "away", "down"})
_LIFTING = frozenset({"lift", "lifting", "pick", "picking", "grasp", "grasping", "grip", "gripping"})
_TAKING = frozenset({"take", "taking", "remove", "removing"})
_PERSONS = frozenset({"i", "we", "he", "she", "they", "having", "to"})
_NOT = frozenset(
    {"not", "dont", "doesnt", "never", "without", "cannot", "cant", "mustnt", "longer", "shouldnt", "wont", "isnt"}
)
_LATER = frozenset({"until", "till", "if", "unless", "or", "then", "after", "afterwards", "once", "first", "when"})
_THREAT = frozenset({"there", "therell", "else", "otherwise", "ill", "shell", "hell", "theyll", "youll", "itll"})
_THERE = frozenset({"there", "in", "that", "thats", "is", "already", "on", "it", "standing", "sitting", "now"})
_STANDING = frozenset({"stay", "stand", "remain", "sit"})
_IN = frozenset({"in", "on", "at", "inside"})
_WHOLLY = frozenset({"completely", "totally", "entirely", "all", "fully", "absolutely", "quite", "strictly"})
_BEHIND = frozenset({
    "there", "where", "as", "and", "but", "put", "in", "exactly", "right", "just", "at", "so", "please", "though",
    "of", "on", "an", "even", "by", "for", "under", "until", "either", "untouched", "here", "now", "down", "from",
    "anywhere", "any", "it", "exclusively", "always", "forever", "alone", "behind", "still", "firmly", "that", "while",
    "whatever", "no", "completely", "then", "because", "since", "inside", "motionless", "unmoved",
})  # fmt: skip
"""What may follow a verb of staying that says no more than that."""
_CLEAR = frozenset({"clear", "unused", "untouched", "bare"})
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
    yield from _used_all_the_same(words, line, placed, scene)
    told = set[str]()
    for kept in _kept(words, line, scene, where):
        for id_ in (i for i in kept.ids if i not in told):
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
            told.add(id_)
            yield Diagnostic("E343", title, span, f"{id_} is to stay", "say which of the two is wanted")


def _used_all_the_same(
    words: Sequence[Token], line: str, placed: Sequence[Sequence[str]], scene: Scene
) -> Iterator[Diagnostic]:
    """E343 for a place that is to stay free, or that nothing may be put on, and that the goals put something on."""
    for place, start, end in _closed(words, line, scene):
        on = next((o for o, p in placed if scene.within(p, place)), None)
        if on is not None:
            title = f"the request contradicts itself: {place} is to stay free, and {on} goes there"
            yield Diagnostic("E343", title, span_of(words[start:end], line), "to stay free", "say which is wanted")


def _closed(words: Sequence[Token], line: str, scene: Scene) -> Iterator[tuple[str, int, int]]:
    """Each place that is to stay free by the request's words, and where they say it."""
    named = {m.start: (m.end, m.id) for m in mentions_in(words, scene) if not scene[m.id].movable}
    named |= {p.start: (p.stop or p.end, p.ids[0]) for p in meant_places(words, line, scene) if len(p.ids) == 1}
    named |= {k: (k + 1, p) for k in range(len(words)) for p in here_named(words, k, scene)}
    for start, (end, place) in sorted(named.items()):
        begin, stop = sentence_at(words, start)
        if _only_later(words, begin, stop):
            continue
        free = phrase_at(words, end, "staying", "empty_behind")
        free = free if _empty(words, free) or _empty(words, free + 1) else 0
        closed = phrase_at(words, end, "staying", "closed_behind")
        closed = 0 if [t.text for t in words[closed : closed + 1]] == ["for"] else closed  # "is reserved for"
        ends = {k: phrase_at(words, k, "staying", "closed_before") for k in range(begin, start)}
        before = next((k for k, at in ends.items() if at and start - 2 <= at <= start), None)
        adverb = int(end < stop and words[end].text in _WHOLLY)
        kept = _empty(words, end + adverb) and any(t.text in _KEEPING for t in words[max(begin, start - 3) : start])
        if free or closed or kept or before is not None:
            yield place, before if before is not None else start, max(free, closed, end)


def _only_later(words: Sequence[Token], begin: int, end: int) -> bool:
    """Whether a sentence speaks of a time, a condition or a choice; "or there'll be trouble" is none."""
    return any(
        t.text in _LATER and not (t.text == "or" and {w.text for w in words[k + 1 : k + 2]} & _THREAT)
        for k, t in enumerate(words[begin:end], begin)
    )


def _empty(words: Sequence[Token], at: int) -> bool:
    """Whether a word for a place that nothing stands on is right here."""
    return 0 < at < len(words) and (lexicon().is_(words[at].text, "vacant") or words[at].text in _CLEAR)


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
        if _only_later(words, begin, end):
            continue
        named = {m.id for m in mentions_in(words, scene) if begin <= m.start < place.start and scene[m.id].movable}
        named |= {i for m in meant_objects(words, line, scene) if begin <= m.start < place.start for i in m.ids}
        if named and id_ not in named:
            return min(named)
    return None


def _at(place: str, allowed: str, scene: Scene) -> bool:
    return scene.within(place, allowed) or scene.within(allowed, place)


def _kept(words: Sequence[Token], line: str, scene: Scene, where: dict[str, str | None]) -> Iterator[_Kept]:
    for i in range(len(words)):
        begin, end = sentence_at(words, i)
        if _only_later(words, begin, end):
            continue
        yield from _said_to_stay(words, i, line, scene, where)
        yield from _left_alone(words, i, scene, where)
        yield from _not_lifted(words, i, end, scene, where)
        behind = phrase_at(words, i, "staying", "behind")
        goes_on = behind and behind < end and words[behind].word and words[behind].text not in _BEHIND
        if behind and not goes_on and words[i].text not in _STAYING and _place(words, behind, end, scene)[0] is None:
            subject, start = subject_before(words, i, line, scene, where, pointed=False)
            yield _Kept(subject, start, behind)


def _said_to_stay(
    words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Iterator[_Kept]:
    """ "The red one stays where it is", "it must not be taken out of there"."""
    t = words[i]
    begin, end = sentence_at(words, i)
    if t.text in _STAYING and not any(w.text in _NOT for w in words[max(begin, i - 3) : i]):
        place, stop = _place(words, i + 1, end, scene)
        pointed = "there" in [w.text for w in words[i + 1 : i + 3]]
        subject, start = subject_before(words, i, line, scene, where, pointed=pointed)
        said = place is not None or "where" in [w.text for w in words[i : i + 4]]
        behind = place is None and i + 1 < end and words[i + 1].word and words[i + 1].text not in _BEHIND
        if subject and not behind and (said or not lexicon().is_(words[start].text, "pronouns")):
            yield _Kept(subject, start, stop, place)
    elif t.text in _REMOVED and _denied(words, begin, i, end):
        subject, start = subject_before(words, i, line, scene, where, pointed=False)
        yield _Kept(subject, start, i + 1)
    elif t.text in _TOUCHED and (found := _nothing_on(words, begin, i, scene, where)):
        yield _Kept(found, begin, i + 1)
    elif t.text in {"leave", "leaves", "leaving"} and any(w.text in _NOT for w in words[max(begin, i - 2) : i]):
        place, stop = _place(words, i, end, scene)
        subject, start = subject_before(words, i, line, scene, where, pointed=False)
        if place is not None:
            yield _Kept(subject, start, stop, place)
    elif t.text in _MOVED and any(w.text in _NOT for w in words[max(begin, i - 3) : i]):
        nothing = i + 1 == len(words) or object_at(words, i + 1, scene, where) is None
        subject, start = subject_before(words, i, line, scene, where, pointed=False)
        yield _Kept(subject if nothing else (), start, i + 1)


def _left_alone(words: Sequence[Token], i: int, scene: Scene, where: dict[str, str | None]) -> Iterator[_Kept]:
    """ "Hands off the green one", "don't touch what's there", "leave object 3 alone", "let it be"."""
    t = words[i]
    begin, end = sentence_at(words, i)
    denied = any(w.text in _NOT for w in words[max(begin, i - 4) : i])
    at = phrase_at(words, i, "staying", "hands_off") or (denied and phrase_at(words, i, "staying", "denied")) or 0
    at = at or (i + 1 if t.text in _TOUCHING and denied else 0)
    found = object_at(words, at, scene, where) if 0 < at < len(words) else None
    if found is not None:
        yield _Kept(found[2], i, found[1])
        return
    found = None
    if t.text in _KEEPING | {"let"} and i + 1 < len(words):
        found = object_at(words, i + 1, scene, where) or pointed_back(words, i + 1, scene, where)
    if found is None:
        return
    _, stop, ids = found
    after = [w.text for w in words[i + 2 : end]]
    place = _place(words, stop, end, scene)[0] if stop < end else None
    if t.text == "let":
        k = stop
        while k < end and words[k].text in _THERE:
            k += 1
        rest = [w.text for w in words[k : k + 2]]
        beside = any(k < r.start < end for r in relations(words))  # "let it stand on the right of the green one"
        if (rest[:1] == ["be"] and rest[1:] in ([], ["."], [","], ["!"])) or (
            rest[:1] and rest[0] in _STANDING and not place and not beside
        ):
            yield _Kept(ids, i, k)
    elif place is not None and all(scene.within(where.get(o), place) for o in ids) and "where" not in after:
        yield _Kept(ids, i, end, place)
    elif {"where", "alone", "untouched", "be", "undisturbed", "put", "peace"} & set(after[stop - i - 2 :]):
        yield _Kept(ids, i, end)


def _not_lifted(
    words: Sequence[Token], i: int, end: int, scene: Scene, where: dict[str, str | None]
) -> Iterator[_Kept]:
    """ "Don't take it off the table", "without lifting it": what is not to be lifted goes nowhere. Not where a manner
    follows ("don't grip it too hard"), or it is somebody else who does not."""
    begin, _ = sentence_at(words, i)
    before = {w.text for w in words[max(begin, i - 4) : i]}
    if words[i].text not in _LIFTING | _TAKING or not before & _NOT or before & _PERSONS:
        return
    at = i + 1 + int([w.text for w in words[i + 1 : i + 2]] == ["up"])
    found = (object_at(words, at, scene, where) or pointed_back(words, at, scene, where)) if at < end else None
    if found is None:
        return
    stop = found[1]
    off = stop < end and words[stop].text in _OUT
    while stop < end and words[stop].text in _OUT | {"up", "at", "all"}:
        stop += 1
    ends = stop >= end or not words[stop].word or words[stop].text in {"while", "and", "but", "or", "in", "doing"}
    if off or (words[i].text in _LIFTING and ends):
        yield _Kept(found[2], i, stop)


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
    begin = at + 1 if at < end and words[at].text in _IN | {"leave", "leaves", "leaving"} else at
    if begin == at:
        return None, at
    for length in range(min(5, end - begin), 0, -1):
        found = resolve_places(words[begin : begin + length], scene, Talk())
        if isinstance(found, Found) and len(found.ids) == 1 and not {ANYWHERE, ORIGIN} & set(found.ids):
            return found.ids[0], begin + length
    return None, at
