"""What a step adds to a name that is clear without it: ", which is the one at the back", ", the last one there"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import rank_of, relations
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["explanation", "without"]

_LONGEST = 25
_RELATIVE = frozenset({"which", "that", "who"})
_BEING = frozenset({"is", "are", "was", "stands", "lies", "sits", "happens", "currently"})
_FURTHER = frozenset({"further", "farther", "nearer", "closer", "deeper"})
_END = frozenset({",", ".", ";", ":", "(", ")", "!", "?"})
_NOT = ("negation", "except", "instead", "conditional")


def explanation(step: LabelledStep, scene: Scene) -> Extent | None:
    """The words after a comma that only say more about the thing named right before it; None without such.

    A parenthesis is one where it tells of relations, ranks or of what is free.

    The name has a number or is the thing's own, a relative clause tells of it, or a further noun phrase: of a place one
    for a place ("position 34, the rightmost position of level 3"), of an object one with a rank ("the milk, the
    leftmost drink"). What tells of it by another colour, names another
    thing of its kind or denies something is none.
    """
    line = tokens(step.text)
    actions = {s.start for s in step.spans if s.label is Kind.ACTION}
    for i, t in enumerate(line):
        thing = _named_before(line, i, scene) if t.text in {",", "("} else None
        if thing is None or i + 2 >= len(line):
            continue
        if t.text == "(":
            end = next((k for k in range(i, len(line)) if line[k].text == ")"), 0)
            inner = line[i + 1 : end]
            told = next((r.start for r in relations(inner)), len(inner))
            stands = _stands(inner, scene, thing) if end and _placed_elsewhere(step, t, line[end]) else None
            if stands is not None and _agrees(inner[:stands], scene, thing):
                return Extent(t.start, line[end].end)
            if end and _remarks(inner) and _agrees(inner[:told], scene, thing):
                return Extent(t.start, line[end].end)
            continue
        relative = line[i + 1].text in _RELATIVE and line[i + 2].text in _BEING
        end = _end(line, i + 1, actions)
        ranks = scene[thing].movable and _a_rank(line, i + 1, end, actions)
        told = _a_relation(line, i + 1, end, actions) if scene[thing].movable else 0
        if not (relative or ranks or told or (not scene[thing].movable and _a_place(line[i + 1 :], scene))):
            continue
        if _agrees(line[i + 1 : told or end], scene, thing):
            return Extent(t.start, line[end - 1].end)
    return None


def without(step: LabelledStep, extent: Extent) -> LabelledStep:
    """A step with blanks in place of some of its words, so that every offset stays, and without their keywords;
    what is left is as sure as its own."""
    text = step.text[: extent.start] + " " * (extent.end - extent.start) + step.text[extent.end :]

    def clear(start: int, end: int) -> bool:
        return end <= extent.start or extent.end <= start

    kept = tuple(s for s in step.spans if clear(s.start, s.end))
    sure = min((s.confidence for s in kept if s.confidence is not None), default=step.confidence)
    return replace(step, text=text, spans=kept, readings=(), confidence=sure)


def _named_before(line: Sequence[Token], i: int, scene: Scene) -> str | None:
    """The one thing that the words before an offset name by its number, or by a name of its own; a parenthesis may
    stand between ("object 3 (yellow block), the leftmost one")."""
    if i and line[i].text == "," and line[i - 1].text == ")":
        i = next((k for k in range(i - 1, 0, -1) if line[k].text == "("), i)
    for length in range(min(i, 4), 0, -1):
        parts = line[i - length : i]
        if not parts[0].word or any(not (p.word or p.number is not None) for p in parts):
            continue
        for resolve in (resolve_objects, resolve_places):
            found = resolve(parts, scene, Talk())
            if not isinstance(found, Found) or len(found.ids) != 1 or found.corrected or found.chosen:
                continue
            (id_,) = found.ids
            own = " ".join(p.text for p in parts) in scene[id_].keys if id_ not in {ANYWHERE, ORIGIN} else False
            if own or (parts[-1].number is not None and id_ not in {ANYWHERE, ORIGIN}):
                return id_
    return None


def _remarks(inner: Sequence[Token]) -> bool:
    """Whether a parenthesis tells where a thing stands, or that another would do as well."""
    loose = any(lexicon().is_(t.text, "vacant") or t.text in {"any", "anywhere"} for t in inner)
    return bool(inner) and (loose or bool(relations(inner)) or rank_of(inner, 0, len(inner)) is not None)


def _placed_elsewhere(step: LabelledStep, opened: Token, closed: Token) -> bool:
    """Whether the step says a place behind a parenthesis."""
    places = [s for s in step.spans if s.label is Kind.DESTINATION]
    return any(s.start > closed.start for s in places) and any(opened.start < s.start < closed.start for s in places)


def _stands(inner: Sequence[Token], scene: Scene, thing: str) -> int | None:
    """Where in a parenthesis the words begin that say on which place the thing stands now ("on position 12")."""
    here = next((o.place for o in scene.map.objects if o.id == thing), None)
    at = next((k for k, t in enumerate(inner) if lexicon().is_(t.text, "at")), None)
    found = resolve_places(inner[at + 1 :], scene, Talk()) if at is not None else None
    if here is None or not isinstance(found, Found) or len(found.ids) != 1 or found.ids[0] in {ANYWHERE, ORIGIN}:
        return None
    return at if scene.within(here, found.ids[0]) else None


def _a_place(after: Sequence[Token], scene: Scene) -> bool:
    """Whether a noun phrase with an article begins that is about a place: its first noun is one for places."""
    if not lexicon().is_(after[0].text, "articles"):
        return False
    for t in after[1:5]:
        if t.text in _END or t.text in {"on", "in", "of", "to", "at"}:
            return False
        if t.text in scene.nouns(True) or t.text in scene.colours:
            return False
        if t.text in scene.nouns(False):
            return True
    return False


def _a_rank(line: Sequence[Token], begin: int, end: int, actions: set[int]) -> bool:
    """Whether a noun phrase with a rank is all there is, and no further member of a list."""
    if not lexicon().is_(line[begin].text, "articles") or any(t.text in {"and", "or"} for t in line[begin:end]):
        return False
    alone = end == len(line) or line[end].text != "," or any(t.start in actions for t in line[end + 1 : end + 3])
    stop = min(end, begin + 4)
    stop -= int(line[stop - 1].text == "one")  # "the leftmost one"
    return alone and rank_of(line, begin + 1, stop) is not None


def _a_relation(line: Sequence[Token], begin: int, end: int, actions: set[int]) -> int:
    """Where the relation begins in ", the carton next to the water", ", the one further to the front", said about the
    thing named before; 0: in none."""
    alone = end == len(line) or line[end].text != "," or any(t.start in actions for t in line[end + 1 : end + 3])
    if not alone or not lexicon().is_(line[begin].text, "articles") or any(t.text == "and" for t in line[begin:end]):
        return 0
    starts = [r.start for r in relations(line[begin:end])]
    starts += [k for k, t in enumerate(line[begin:end]) if t.text in _FURTHER]
    return next((begin + k for k in sorted(starts) if 0 < k < 5), 0)


def _end(line: Sequence[Token], begin: int, actions: set[int]) -> int:
    """Where it ends: at a mark, or at what is to be done next."""
    for j in range(begin + 1, min(len(line), begin + _LONGEST)):
        if line[j].text in _END:
            return j
        joined = line[j].text in {"and", "then"} and any(n.start in actions for n in line[j + 1 : j + 3])
        if joined:
            return j
    return min(len(line), begin + _LONGEST)


def _agrees(words: Sequence[Token], scene: Scene, thing: str) -> bool:
    if any(lexicon().is_(t.text, *_NOT) for t in words):
        return False
    entity = scene[thing]
    if entity.movable and any(t.text in scene.colours and t.text not in entity.colour for t in words[:6]):
        return False
    for t, after in zip(words, [*words[1:], None][: len(words)], strict=True):
        if after is None or after.number is None or not t.word:
            continue
        resolve = resolve_objects if entity.movable else resolve_places
        found = resolve((t, after), scene, Talk())
        numbered = t.text in entity.stem and entity.number is not None
        if numbered and isinstance(found, Found) and thing not in found.ids and not _inside(thing, found.ids, scene):
            return False
    return True


def _inside(thing: str, others: Sequence[str], scene: Scene) -> bool:
    return not scene[thing].movable and any(scene.within(thing, o) for o in others if o not in {ANYWHERE, ORIGIN})
