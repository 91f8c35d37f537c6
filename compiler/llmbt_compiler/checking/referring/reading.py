"""The noun phrases of a request, one after the other, with the objects that each may mean."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from llmbt_compiler.checking.referring.counted import one_there, other, several, some_of
from llmbt_compiler.checking.referring.lists import INDEFINITE, POINTING
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.neighbours import entered_beside, neighbour
from llmbt_compiler.checking.referring.nouns import bare, noun
from llmbt_compiler.checking.referring.predicates import predicated
from llmbt_compiler.checking.referring.ranks import ranked
from llmbt_compiler.checking.referring.relative import compared, related
from llmbt_compiler.checking.referring.simple import (
    colour_alone,
    felt_alone,
    plain,
    something,
    something_compared,
    told_alone,
)
from llmbt_compiler.checking.telling import entered
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token

__all__ = ["meant_objects"]


def meant_objects(words: Sequence[Token], line: str, scene: Scene) -> Iterator[Meant]:
    """Every phrase like "the green block", "a yellow one", "two of the drinks", "the block in the sorting area" with
    the objects that it fits; none where what stands after it may tell more than is understood here."""
    where = {o.id: o.place for o in scene.map.objects}
    before: set[str] = set()
    single: set[str] = set()
    earlier = _pointed_at(words, scene, where)
    group: tuple[str, ...] = ()
    mentions = mentions_in(words, scene)
    named = {m.end: m.id for m in mentions if scene[m.id].number is not None and scene[m.id].movable}
    cut = {k: m for m in mentions for k in range(m.start + 1, m.end)}  # "the pill | tray", "the flour | carton"
    for i, t in enumerate(words):
        before |= earlier.get(i, set())
        single |= {named[i]} if i in named else set()
        found = (
            several(words, i, scene, where)
            or some_of(words, i, scene, where)
            or entered_beside(words, i, line, scene, where)
            or something(words, i, scene)
            or predicated(words, i, line, scene, where)
            or something_compared(words, i, line, scene, where)
            or neighbour(words, i, line, scene, where)
            or told_alone(words, i, scene)
            or one_there(words, i, scene, where, group)
            or colour_alone(words, i, scene)
            or felt_alone(words, i, scene, group)
        )
        if found is not None:
            before |= set(found.ids)
            group = found.ids if len(found.ids) == found.count else group
            yield found
            continue
        if i and words[i - 1].text in {"any", "either"}:
            continue
        rest = other(words, i, single, scene)
        if rest is not None:
            yield rest
            continue
        end = noun(words, i, scene) if t.text in POINTING | INDEFINITE else 0
        if end in cut:
            whole = cut[end]
            found = Meant(i, whole.end, (whole.id,)) if scene[whole.id].movable and whole.start == i + 1 else None
        elif end:
            found = compared(words, i + 1, end, line, scene, where)
            if found is not None and found.ids == () and found.stop:
                yield replace(found, start=i)
                continue
            found = (
                found
                or ranked(words, i + 1, end, line, scene, where, group)
                or related(words, i + 1, end, line, scene, where)
                or plain(words, i + 1, end, scene, where)
            )
            if found is not None and entered(words, i):
                found = None
        elif bare(words, i, scene):
            end = noun(words, i - 1, scene)
            found = ranked(words, i, end, line, scene, where) or plain(words, i, end, scene, where) if end else None
        if found is not None and found.ids and not (t.text in {"that", "this"} and before & set(found.ids)):
            yield replace(found, start=i)
            before |= set(found.ids)
            single |= set(found.ids) if len(found.ids) == 1 else set()


def _pointed_at(words: Sequence[Token], scene: Scene, where: dict[str, str | None]) -> dict[int, set[str]]:
    """What "that block" may point back to, by the word behind its name: a thing, what has a colour,
    what is on a place."""
    found: dict[int, set[str]] = {}
    for m in mentions_in(words, scene):
        there = {o for o, p in where.items() if scene.within(p, m.id)} if not scene[m.id].movable else {m.id}
        if scene[m.id].movable or scene.single(m.id):
            found.setdefault(m.end, set()).update(there)
    for i, t in enumerate(words):
        pointing = i > 0 and words[i - 1].text in {"that", "this"}
        if t.text in scene.colours and not pointing:
            found.setdefault(i + 1, set()).update(e.id for e in scene.objects if t.text in e.colour)
    return found
