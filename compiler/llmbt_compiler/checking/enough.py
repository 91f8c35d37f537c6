"""What a request asks for a second time and the map has once ("another coke"), and a gap between two positions that
touch."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from llmbt_compiler.checking.referring import Meant
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.rows import row_of
from llmbt_compiler.parsing.words import Token, lexicon, singulars

__all__ = ["Lacking", "not_enough"]

_AGAIN = frozenset({"another", "second", "further", "additional", "extra"})
_GIVING = frozenset({"hand", "give", "pass", "bring", "fetch", "serve", "carry"})
_FILLING = frozenset({"fill", "filled", "occupy", "cover", "pack", "stuff"})
_WHOLLY = frozenset({
    "completely", "entirely", "fully", "wholly", "totally", "whole", "each", "every", "full", "brim", "all", "end",
})  # fmt: skip
_SLOTS = frozenset({"slot", "position", "spot", "place", "space"})
_MARKS = frozenset({",", ";", "and"})


@dataclass(frozen=True, slots=True)
class Lacking:
    """words[start:end] count what is not there, and what there is instead."""

    start: int
    end: int
    there: str
    candidates: tuple[str, ...] = ()


def not_enough(words: Sequence[Token], phrases: Sequence[Meant], scene: Scene) -> Iterator[Lacking]:
    """Every phrase that asks for one more of a thing than there are, or for a place where there is none."""
    yield from _another(words, phrases, scene)
    yield from _no_gap(words, scene)
    yield from _nobody(words, scene)
    yield from _filled(words, scene)


def _another(words: Sequence[Token], phrases: Sequence[Meant], scene: Scene) -> Iterator[Lacking]:
    """ "One coke for me and another one for Paul", "one milk here and one milk there", where there is one."""
    named = {m.start: (m.end, (m.id,)) for m in mentions_in(words, scene) if scene[m.id].movable}
    named |= {p.start: (max(p.end, 1), p.ids) for p in phrases if len(p.ids) == 1}
    spans = sorted((start, end, ids) for start, (end, ids) in named.items())
    for start, end, ids in spans:
        thing = scene[ids[0]]
        if thing.number is not None and any(words[k].number == thing.number for k in range(start, end)):
            continue
        begin, stop = sentence_at(words, start)
        noun = words[end - 1].text
        counted = start > begin and words[start - 1].text in {"one", "a"}
        for k in range(end, stop):
            after = words[k + 1].text if k + 1 < stop else ""
            more = words[k].text in _AGAIN and after in {"one", noun}
            twice = counted and words[k].text == "one" and after == noun and noun not in {"one", "block"}
            if (more or twice) and any(w.text in _MARKS for w in words[end:k]):
                yield Lacking(k, min(k + 2, stop), f"there is only {ids[0]}", ids)
                return


def _nobody(words: Sequence[Token], scene: Scene) -> Iterator[Lacking]:
    """ "Hand me the red cube", where nobody is on the map, and no place is named."""
    placed = any(not scene[m.id].movable for m in mentions_in(words, scene)) or relations(words)
    if scene.persons or placed or any(t.digits for t in words):
        return
    for i, t in enumerate(words[:-1]):
        before = {w.text for w in words[max(0, i - 4) : i]}
        to_me = words[i + 1].text in {"me", "us"} and (t.text in _GIVING or (t.text == "to" and before & _GIVING))
        if to_me:
            yield Lacking(i, i + 2, "nobody is on the map, to whom something could be brought")
            return


def _no_gap(words: Sequence[Token], scene: Scene) -> Iterator[Lacking]:
    """ "Between positions 13 and 14", which are next to each other."""
    named = mentions_in(words, scene)
    for relation in relations(words):
        if relation.name != "between":
            continue
        at = [m for m in named if relation.end <= m.start <= relation.end + 5][:2]
        if len(at) != 2 or any(scene[m.id].movable or not scene.single(m.id) for m in at):
            continue
        row = row_of(at[0].id, scene)
        if {m.id for m in at} in [set(pair) for pair in pairwise(row)]:
            yield Lacking(relation.start, at[1].end, f"{at[0].id} and {at[1].id} are next to each other")


def _filled(words: Sequence[Token], scene: Scene) -> Iterator[Lacking]:
    """ "Fill level 2 completely with greens", "a green block on every position of level 2", where there are fewer."""
    for i, t in enumerate(words):
        begin, end = sentence_at(words, i)
        said = [w.text for w in words[begin:end]]
        wholly = bool(set(said) & _WHOLLY)
        if t.text in _FILLING and wholly:
            place, stop = _container_in(words, i + 1, end, scene)
            led = next((k for k in range(stop, end) if words[k].text == "with"), None)
            kind = _kind_at(words, led + 1, scene) if place is not None and led is not None else ()
            first = i
        elif t.text in {"every", "each"} and i + 1 < end and set(singulars(words[i + 1].text)) & _SLOTS:
            place, stop = _container_in(words, i + 2, end, scene)
            articles = [k for k in range(begin, i) if words[k].text in {"a", "one"}]
            first = articles[-1] if articles else i
            kind = _kind_at(words, first, scene) if articles and first >= i - 5 else ()
        else:
            continue
        if place is None or not kind or "or" in said:
            continue
        slots = {p.id for p in scene.map.inside(place) if scene.single(p.id)}
        others = {o.place for o in scene.map.objects if o.place in slots and o.id not in kind}
        if slots and len(kind) < len(slots) - len(others):
            there = f"there are only {len(kind)} of them for {len(slots) - len(others)} positions"
            yield Lacking(first, max(stop, i + 1), there, kind)
            return


def _container_in(words: Sequence[Token], at: int, end: int, scene: Scene) -> tuple[str | None, int]:
    """The first place named here that has positions in it."""
    named = (m for m in mentions_in(words[:end], scene) if m.start >= at and not scene[m.id].movable)
    return next(((m.id, m.end) for m in named if any(scene.map.inside(m.id))), (None, end))


def _kind_at(words: Sequence[Token], at: int, scene: Scene) -> tuple[str, ...]:
    """All things of the kind that is named here: "(with) green blocks", "greens", "a yellow one"."""
    k = at
    while k < len(words) and (lexicon().is_(words[k].text, "articles") or words[k].text in {"one", "all"}):
        k += 1
    stop = next((n for n in range(k, min(len(words), k + 4)) if not scene.word(words[n], True).text), k)
    parts = [t for t in words[k:stop] if t.text not in {"one", "ones"}]
    found = resolve_objects((Token("all", parts[0].start, parts[0].start), *parts), scene, Talk()) if parts else None
    return found.ids if isinstance(found, Found) and not found.corrected else ()
