"""Requests that want more in one place than it holds, or one thing in two places, whatever the reply makes of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from llmbt_atl.library import Library
from llmbt_compiler.checking.referring import Meant, meant_objects, place_named, standing_there
from llmbt_compiler.checking.sentences import ENDS, one_line, sentence_at, sentences, span_of
from llmbt_compiler.checking.staying import here_named
from llmbt_compiler.parsing import Goal
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.words import Token, lexicon, singulars, tokens
from llmbt_ir.diagnostics import Diagnostic
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["too_many"]

_ONTO = frozenset({"on", "onto", "in", "into", "to", "at", "along", "across"})
_LESS = frozenset({"there", "here", "else", "isnt", "not", "that", "which"})
"""Behind "everything": not all that there is."""
_ALL = frozenset({"all", "every", "each"})
_JOINING = frozenset({"and", ",", "&", "the", "both", "also", "plus"})
_OTHERWISE = frozenset({
    "then", "after", "afterwards", "later", "first", "until", "or", "from", "swap", "exchange", "switch", "between",
    "respectively", "either", "if", "clear", "empty", "free", "via", "not", "starting", "where",
})  # fmt: skip
_SHARING = frozenset({"share", "shares", "sharing", "shared"})
_TOGETHER = frozenset({"both", "two", "three", "four", "five", "six", "pair"})
_AT_ONCE = frozenset({"as", "well", "same", "time", "once", "simultaneously"})
_WANTING = frozenset({"want", "have", "need", "keep", "leave", "should", "must", "like", "has", "needs", "wanted"})
_ALSO = frozenset({"also", "still", "too", "well", "simultaneously", "same", "once", "both"})
_PILES = frozenset({"tower", "pyramid", "stack", "pile", "column", "turret"})
_BUILDING = frozenset({"build", "make", "form", "construct", "erect", "create", "assemble", "building", "making"})
_EXCEPTING = frozenset({"but", "except", "apart", "besides", "else", "other", "than", "without"})


@dataclass(frozen=True, slots=True)
class _Named:
    """What words[start:end] name; `led`: a word like "on" stands before it."""

    start: int
    end: int
    ids: tuple[str, ...]
    count: int = 1
    led: bool = False


def too_many(request: str, goals: Sequence[Goal], semantic_map: SemanticMap, library: Library) -> Iterator[Diagnostic]:
    """E308 for more things than a place has positions, what stays there counted; E343 for a thing in two places."""
    scene = Scene(semantic_map, library)
    line = one_line(request)
    words = tokens(line)
    phrases = tuple(meant_objects(words, line, scene))
    yield from _full(words, line, phrases, goals, scene)
    for begin, end in sentences(words):
        yield from _all_on_single(words, line, begin, end, scene)
        yield from _all_in_hand(words, line, begin, end, scene)
        named = _objects(words, begin, end, phrases, scene)
        if [r.name for r in relations(words[begin:end])] == ["top"]:
            yield from _stacked(words, line, begin, end, named)
        if {t.text for t in words[begin:end]} & _OTHERWISE or relations(words[begin:end]):
            continue
        places = _places(words, begin, end, scene)
        yield from _in_two(words, line, named, places, scene)
        yield from _on_one(words, line, named, places, scene)
        yield from _shared(words, line, begin, end, places, scene)
        yield from _stacked(words, line, begin, end, named)


def _full(
    words: Sequence[Token], line: str, phrases: Sequence[Meant], goals: Sequence[Goal], scene: Scene
) -> Iterator[Diagnostic]:
    """ "All six blocks on level 1", which has four positions."""
    moved = {g.condition.args[0] for g in goals if g.condition.name == "On"}
    for phrase in (*phrases, *_together(words, tuple(_everything(words, scene)))):
        end = next((k for k in range(phrase.end, len(words)) if words[k].text in ENDS), len(words))
        first = max(phrase.end, phrase.stop)
        clause = next((k for k in range(first, end) if words[k].text in {",", "and"}), end)
        onto = (place_named(words, k + 1, scene) for k in range(first, clause) if words[k].text in _ONTO)
        place, stop = next(((p, e) for p, e in onto if p is not None), (None, end))
        more = any(words[k].text == "and" and _names_place(words, k + 1, scene) for k in range(stop, end))
        if phrase.count < 2 or place is None or more:
            continue
        slots = [p.id for p in scene.map.inside(place) if scene.single(p.id)]
        stay = [o.id for o in scene.map.objects if o.place in slots and o.id not in moved | set(phrase.ids)]
        if slots and phrase.count + len(stay) > len(slots):
            title = f"{place} has {len(slots)} positions, and the request wants {phrase.count} things there"
            label = f"{', '.join(stay)} stays there" if stay else "too many"
            span = span_of(words[phrase.start : stop], line)
            yield Diagnostic("E308", title, span, label, "take another place")


def _names_place(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """ "... (and) level 2", "... on the sorting area"."""
    at += int(at < len(words) and words[at].text in _ONTO)
    return at < len(words) and place_named(words, at, scene)[0] is not None


def _together(words: Sequence[Token], phrases: Sequence[Meant]) -> tuple[Meant, ...]:
    """ "All the greens and all the yellows": one phrase of both."""
    out: list[Meant] = []
    for p in sorted(phrases, key=lambda p: p.start):
        joined = out and {t.text for t in words[out[-1].end : p.start]} <= _JOINING
        if joined and not set(out[-1].ids) & set(p.ids):
            ids = (*out[-1].ids, *p.ids)
            out[-1] = Meant(out[-1].start, p.end, ids, len(ids))
        else:
            out.append(p)
    return tuple(out)


def _everything(words: Sequence[Token], scene: Scene) -> Iterator[Meant]:
    """ "Everything from the sorting area": all that stands there, or all there is."""
    for i, t in enumerate(words):
        begin, end = sentence_at(words, i)
        said = {w.text for w in words[begin : min(end, i + 10)]}
        if said & _EXCEPTING or lexicon().function["negation"] & said - {"no"}:
            continue
        if t.text in _ALL and not (i and words[i - 1].text in {"of", "them", "they", "are", "at", "it", "that"}):
            yield from _all(words, i, end, scene)
        if t.text != "everything" or {w.text for w in words[i + 1 : i + 5]} & _LESS:
            continue
        there = i + 1 < end and words[i + 1].text in {"from", "on", "in", "off", "thats"}
        place, stop = place_named(words, i + 2, scene) if there else (None, i + 1)
        ids = tuple(o.id for o in scene.map.objects if place is None or scene.within(o.place, place))
        onto = there and place is not None and not any(w.text in _ONTO for w in words[stop:end])
        if ids and (place is not None or not there) and not onto:
            yield Meant(i, stop, ids, len(ids))


def _all(words: Sequence[Token], i: int, end: int, scene: Scene) -> Iterator[Meant]:
    """ "All of the blocks", "every green block", "all six of them": all there are of a kind."""
    k = i + 1
    while k < end and (words[k].text in {"of", "the", "these", "those", "my", "single"} or words[k].number is not None):
        k += 1
    numbers = {t.number for t in words[i:k] if t.number is not None}
    if k < end and words[k].text == "them":
        ids = tuple(e.id for e in scene.objects)
        if numbers == {str(len(ids))}:
            yield Meant(i, k + 1, ids, len(ids))
        return
    for stop in (k + 2, k + 1):
        found = resolve_objects((Token("all", words[i].start, words[i].end), *words[k:stop]), scene, Talk())
        if k < stop <= end and isinstance(found, Found) and not found.corrected:
            where = {o.id: o.place for o in scene.map.objects}
            ids, after = standing_there(words, stop, found.ids, scene, where)  # "all that stuff on level one"
            yield Meant(i, after, ids, len(ids))
            return


def _in_two(
    words: Sequence[Token], line: str, named: Sequence[_Named], places: Sequence[_Named], scene: Scene
) -> Iterator[Diagnostic]:
    """ "The water on the desk and on the bar"."""
    if len({n.ids for n in named}) != 1 or len(named[0].ids) != 1:
        return
    for a, b in pairwise(places):
        between = {t.text for t in words[a.end : b.start]}
        apart = not (scene.within(a.ids[0], b.ids[0]) or scene.within(b.ids[0], a.ids[0]))
        joined = between & {"and", "plus", "also", "well"} and between <= _JOINING | _ONTO | _AT_ONCE
        if a.led and (joined or _still_wanted(words, a, b, named[0], scene)) and apart:
            title = f"the request contradicts itself: {named[0].ids[0]} would be in two places: {a.ids[0]}, {b.ids[0]}"
            yield Diagnostic("E343", title, span_of(words[a.start : b.end], line), "two places", "name one of them")


def _still_wanted(words: Sequence[Token], a: _Named, b: _Named, thing: _Named, scene: Scene) -> bool:
    """ "Object 5 on position 13, and I also want it in the sorting area still": another place for the same thing, at
    the same time; the first is not where it stands anyway."""
    between = [t.text for t in words[a.end : b.start]]
    here = next((o.place for o in scene.map.objects if o.id == thing.ids[0]), None)
    _, end = sentence_at(words, a.start)
    also = set(between) | {t.text for t in words[b.end : min(end, b.end + 5)]}
    plainly = b.led and thing.start < a.start and "it" in between and set(between) & {"and", "but", "while"}
    return bool(plainly and set(between) & _WANTING and also & _ALSO) and not scene.within(here, a.ids[0])


def _on_one(
    words: Sequence[Token], line: str, named: Sequence[_Named], places: Sequence[_Named], scene: Scene
) -> Iterator[Diagnostic]:
    """ "Object 3 and object 5 both on position 24"."""
    if len(places) != 1 or not places[0].led or not scene.single(places[0].ids[0]):
        return
    joined = all({t.text for t in words[a.end : b.start]} <= _JOINING for a, b in pairwise(named))
    ids = tuple(dict.fromkeys(i for n in named for i in n.ids))
    it = any(t.text == "it" for t in words[named[-1].end : places[0].start]) if named else False
    if (
        joined
        and not it
        and len(ids) > 1
        and named[-1].end <= places[0].start
        and all(len(n.ids) == n.count for n in named)
    ):
        title = f"{places[0].ids[0]} takes one thing at a time, and the request wants {', '.join(ids)} there"
        span = span_of(words[named[0].start : places[0].end], line)
        yield Diagnostic("E308", title, span, "too many", "take another place")


def _shared(
    words: Sequence[Token], line: str, begin: int, end: int, places: Sequence[_Named], scene: Scene
) -> Iterator[Diagnostic]:
    """ "Both of them sharing that slot", "the two in one slot", "together with the one that's in there"."""
    said = [t.text for t in words[begin:end]]
    slots = {w for w in scene.generic(False) if any(scene.single(p.id) for p in scene.places if scene.fits(p, w))}
    denied = lexicon().function["negation"] & set(said)
    for k, w in enumerate(said):
        after = said[k + 1 : k + 6]
        noun = next((n for n, a in enumerate(after) if set(singulars(a)) & slots), None)
        on_one = after[:1] in (["it"], ["that"]) and any(scene.single(p.ids[0]) and p.led for p in places)
        share = w in _SHARING and (noun is not None or on_one)
        single = w in {"in", "on", "into", "onto"} and after[:1] in (["one"], ["a"]) and noun in {1, 2}
        single = single and (after[0] == "one" or "single" in after[1:2]) and bool({"both", "two"} & set(said[:k]))
        single = single or (w in {"in", "on", "into", "onto"} and after[:4] == ["one", "and", "the", "same"])
        rest = said[k + 2 :]
        joined = [w, *after[:1]] in (["together", "with"], ["along", "with"]) and _in_there(rest)
        if not denied and (share or single or joined):
            title = "a position takes one thing at a time, and the request wants more of them on one"
            yield Diagnostic("E308", title, span_of(words[begin + k : end], line), "too many", "take another place")
            return


def _all_on_single(words: Sequence[Token], line: str, begin: int, end: int, scene: Scene) -> Iterator[Diagnostic]:
    """ "Squeeze both of them onto position 14, then we save a spot"."""
    said = {t.text for t in words[begin:end]}
    if said & (_OTHERWISE - {"then", "from", "not", "where"}) or lexicon().function["negation"] & said:
        return
    at = next(
        (
            k
            for k in range(begin, end)
            if words[k].text in _TOGETHER
            and [t.text for t in words[max(0, k - 2) : k]] != ["of", "the"]  # "the middle one of the three"
            and _on_single(words, k + 1, end, scene)
        ),
        None,
    )
    if at is not None:
        title = "a position takes one thing at a time, and the request wants more of them on one"
        yield Diagnostic("E308", title, span_of(words[at:end], line), "too many", "take another place")


def _all_in_hand(words: Sequence[Token], line: str, begin: int, end: int, scene: Scene) -> Iterator[Diagnostic]:
    """ "Pick up both oils and hold them": the hand holds one thing."""
    said = [t.text for t in words[begin:end]]
    last = len(said) - 1
    hold = next((k for k, w in enumerate(said) if w in {"hold", "holding"} and said[min(k + 1, last)] != "on"), None)
    if hold is None or lexicon().function["negation"] & set(said) or not _TOGETHER & set(said):
        return
    if not any(not scene[m.id].movable for m in mentions_in(words[begin:end], scene)):
        title = "the hand holds one thing at a time, and the request wants more of them held"
        yield Diagnostic("E308", title, span_of(words[begin + hold : end], line), "too many", "one after the other")


def _on_single(words: Sequence[Token], at: int, end: int, scene: Scene) -> bool:
    """ "(Both) of them onto position 14": a single place right behind what is counted, and no other with it."""
    to = next((k for k in range(at, min(end, at + 5)) if words[k].text in _ONTO), None)
    if to is None or any(not t.word or t.number is not None for t in words[at:to]):
        return False
    named = [p.ids[0] for p in _places(words, at, end, scene)]
    place = next((p for p in _places(words, to, end, scene) if p.start - 2 <= to < p.start), None)
    return place is not None and scene.single(place.ids[0]) and len(set(named)) == 1


def _in_there(said: Sequence[str]) -> bool:
    """Whether something is told as what a place holds already: "that's in there", "already in it"."""
    return any(a in {"in", "on"} and b in {"there", "it"} for a, b in pairwise(said))


def _stacked(words: Sequence[Token], line: str, begin: int, end: int, named: Sequence[_Named]) -> Iterator[Diagnostic]:
    """ "Stack object 5 on object 6": nothing stands on a thing."""
    said = [t.text for t in words[begin:end]]
    pile = next((k for k, w in enumerate(said) if w in _PILES and said[max(0, k - 1)] in {"a", "one", "the"}), None)
    denied = lexicon().function["negation"] & set(said)
    if pile is not None and _BUILDING & set(said[:pile]) and not denied and "column" not in said:
        title = f"the request wants a {said[pile]}, and things stand on places alone"
        yield Diagnostic("E308", title, span_of(words[begin:end], line), "no place", "name a place for each")
        return
    verb = next((k for k in range(begin, end) if words[k].text in {"stack", "stacked", "pile"}), None)
    for a, b in pairwise(named) if verb is not None else ():
        between = [t.text for t in words[a.end : b.start] if not lexicon().is_(t.text, "articles")]
        on = between in (["on"], ["onto"], ["upon"], ["atop"], ["on", "top", "of"])
        if on and a.start > (verb or 0) and len(b.ids) == 1:
            title = f"the request wants a thing on {b.ids[0]}, and things stand on places alone"
            yield Diagnostic("E308", title, span_of(words[a.start : b.end], line), "no place", "name a place")


def _objects(
    words: Sequence[Token], begin: int, end: int, phrases: Sequence[Meant], scene: Scene
) -> tuple[_Named, ...]:
    """The objects named in a sentence, in order, none within another's words."""
    found = [_Named(m.start, m.end, m.ids, m.count) for m in phrases if not _one_of(words, m.start)]
    found += [_Named(m.start, m.end, (m.id,)) for m in mentions_in(words, scene) if scene[m.id].movable]
    found = sorted((n for n in found if begin <= n.start < end), key=lambda n: (n.start, -n.end))
    kept: list[_Named] = []
    for n in found:
        if not kept or n.start >= kept[-1].end:
            kept.append(n)
    return tuple(kept)


def _one_of(words: Sequence[Token], start: int) -> bool:
    """ "The smaller of | the two barrels": one of them."""
    k = start
    while k and (words[k].number is not None or lexicon().is_(words[k].text, "articles")):
        k -= 1
    lex = lexicon()
    picked = words[k - 1].text if k and words[k].text == "of" else ""
    return picked in lex.sizes or picked in lex.ordinals or picked in {"one", "either", "any", "whichever", "which"}


def _places(words: Sequence[Token], begin: int, end: int, scene: Scene) -> tuple[_Named, ...]:
    found = [m for m in mentions_in(words, scene) if not scene[m.id].movable and begin <= m.start < end]
    inside = {k for m in found for k in range(m.start, m.end)}
    named = [_Named(m.start, m.end, (m.id,), led=_led(words, m.start)) for m in found]
    for k in range(begin, end):  # "on 12 and 34"
        here = here_named(words, k, scene) if k not in inside else ()
        if here and (_led(words, k) or (named and words[k - 1].text in {"and", ","})):
            named.append(_Named(k, k + 1, here, led=_led(words, k)))
    return tuple(sorted(named, key=lambda n: n.start))


def _led(words: Sequence[Token], start: int) -> bool:
    """Whether a word like "on" leads to a place."""
    k = start - 1
    while k >= 0 and lexicon().is_(words[k].text, "articles"):
        k -= 1
    return k >= 0 and words[k].text in _ONTO
