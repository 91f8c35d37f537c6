"""Places told by counting from another: "one level up", "one slot further right than position 34", "count along the
bottom level to the third slot and put it in that"."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.plainly import instead
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.words import lexicon, tokens
from llmbt_compiler.relations import DIRECTIONS, layout, ties

__all__ = ["stepped"]

_COUNT = r"(?P<count>a|an|one|two|three|1|2|3)"
_UP = re.compile(
    rf"\b(?:(?P<dir>up|down)\s+(?:by\s+)?(?:just\s+|exactly\s+)?{_COUNT}\s+(?P<noun>[a-z]+?)s?"
    rf"|{_COUNT.replace('count', 'count2')}\s+(?P<noun2>[a-z]+?)s?\s+(?:further\s+)?"
    r"(?P<dir2>up|down|higher|lower)(?:\s+(?:up|down))?)\b"
    r"(?!\s+(?:than|from)\b)",
    re.IGNORECASE,
)
_ASIDE = re.compile(
    rf"(?:\bto\s+)?\b{_COUNT}\s+(?:slot|position|place|spot)s?\s+(?:further\s+)?(?:(?:over|along)\s+)?(?:to\s+)?(?:the\s+)?(?P<dir>left|right)\s+"
    r"(?:than|of|from)\s+(?P<mark>[^,;:.!?]{2,40})",
    re.IGNORECASE,
)
_ALONG = re.compile(
    r"\b(?:count|go|move|look)\s+(?:along|across|down)\s+(?P<where>[^,;:.!?]{2,40}?)\s*,?\s+(?:from\s+(?:the\s+)?(?P<end>left|right)\s+)?"
    r"to\s+(?P<slot>the\s+[a-z]+\s+(?:slot|position|place|spot))\s*,?\s+and\s+(?P<order>[^;:.!?]{4,80}?\s+(?:in|on|into|onto)\s+)"
    r"(?P<there>that(?:\s+one)?|it|this(?:\s+one)?)(?=\s*(?:[.,;!?]|$))",
    re.IGNORECASE,
)
_COUNTS = {"a": 1, "an": 1, "one": 1, "two": 2, "three": 3, "1": 1, "2": 2, "3": 3}


def stepped(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """The step with the id of the place in place of such words; a fault where there is none so far on."""
    for settle in (_aside, _along, _level):
        done = settle(step, scene, talk)
        if done is not step:
            return done
    return step


def _row(place: str, scene: Scene) -> tuple[str, ...]:
    """The places of the kind of one and within the same container, from left to right."""
    around = next(iter(scene.map.containers(place)), None)
    slots = [
        e.id for e in scene.places if scene.single(e.id) and next(iter(scene.map.containers(e.id)), None) == around
    ]
    known = layout(scene.map, {})
    things = [t for i in slots if (t := known.get(i)) is not None]
    groups = ties(things, DIRECTIONS["left"])
    return tuple(g[0] for g in groups) if all(len(g) == 1 for g in groups) else ()


def _aside(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """ "One slot further right than position 34"."""
    m = _ASIDE.search(step.text)
    parts = tokens(step.text, *m.span("mark")) if m is not None else ()
    for size in range(min(len(parts), 6), 0, -1):
        found = resolve_places(parts[:size], scene, talk)
        thing = resolve_objects(parts[:size], scene, talk) if isinstance(found, Fault) else None
        if (
            isinstance(thing, Found)
            and len(thing.ids) == 1
            and talk.where.get(thing.ids[0]) in {e.id for e in scene.places}
        ):
            found = Found((str(talk.where[thing.ids[0]]),))
        if m is None or not isinstance(found, Found) or len(found.ids) != 1 or not scene.single(_only(found)):
            continue
        row, extent = _row(_only(found), scene), Extent(m.start(), parts[size - 1].end)
        if _only(found) not in row:
            return step
        count = _COUNTS[m["count"].casefold()]
        at = row.index(_only(found)) + (count if m["dir"].casefold() == "right" else -count)
        return _place(step, extent, row, at)
    return step


def _only(found: Found) -> str:
    return found.ids[0] if found.ids[0] not in {ANYWHERE, ORIGIN} else ""


def _place(step: LabelledStep, extent: Extent, row: Sequence[str], at: int) -> LabelledStep | Fault:
    if not 0 <= at < len(row):
        said = extent.cut(step.text)
        hint = f"the map has {', '.join(row[:6])}"
        return Fault("E302", f"there is no `{said}`", extent, "", hint, tuple(row[:6]))
    return instead(step, extent, row[at], Kind.DESTINATION)


def _along(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """ "Count along the bottom level to the fifth slot and put the red block in that"."""
    m = _ALONG.search(step.text)
    where = resolve_places(tokens(step.text, *m.span("where")), scene, talk) if m is not None else None
    if (
        m is None
        or not isinstance(where, Found)
        or len(where.ids) != 1
        or not _only(where)
        or scene.single(_only(where))
    ):
        return step
    inside = [e.id for e in scene.places if scene.single(e.id) and scene.within(e.id, _only(where))]
    row = _row(inside[0], scene) if inside else ()
    row = row if (m["end"] or "left").casefold() == "left" else row[::-1]
    number = next((n for t in tokens(m["slot"]) if (n := lexicon().ordinals.get(t.text))), None)
    if not row or len(row) != len(inside) or number is None:
        return step
    extent = Extent(m.start(), m.start("order"))
    if number > len(row):
        return _place(step, extent, row, number - 1)
    step = instead(step, extent, "", None)
    there = Extent(*m.span("there"))
    size = len(row[number - 1]) - (there.end - there.start)
    room = step.text[: m.start("order")].rstrip()
    if m.start("order") - len(room) <= size:
        return Fault("E305", f"`{m[0]}` is not understood", Extent(*m.span()), "where?", "name the place")
    text = room + step.text[len(room) + size : there.start] + row[number - 1] + step.text[there.end :]
    return _moved(step, text, m.start("order"), there, size, row[number - 1])


def _moved(step: LabelledStep, text: str, begin: int, there: Extent, size: int, place: str) -> LabelledStep:
    """The step with its keywords from `begin` on moved to the left, as the text is, and the place for "that"."""
    spans = [
        replace(s, start=s.start - size, end=s.end - size)
        for s in step.spans
        if begin <= s.start and s.end <= there.start
    ]
    spans += [s for s in step.spans if s.start >= there.end]
    start = there.end - len(place)
    spans.append(KeywordSpan(start, there.end, Kind.DESTINATION, place))
    return replace(step, text=text, spans=tuple(sorted(spans, key=lambda s: s.start)), readings=())


def _level(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """ "Lift the yellow block up by one level": so far above the level on which the thing stands."""
    m = _UP.search(step.text)
    if m is None:
        return step
    noun = (m["noun"] or m["noun2"]).casefold()
    levels = sorted(
        (e for e in scene.places if noun in e.words and not scene.single(e.id)), key=lambda e: natural(e.id)
    )
    if len(levels) < 2 or any(e.number is None for e in levels):
        return step
    extent = Extent(*m.span())
    lead = [s for s in step.spans if s.end <= extent.start]
    if lead and lead[-1].label is Kind.DESTINATION:
        return step  # "on position 24, one level lower"
    before = [s for s in lead if s.label is Kind.TARGET]
    said = tokens(step.text, before[-1].start, before[-1].end) if before else ()
    found = resolve_objects(said, scene, talk) if said else None
    unclear = Fault("E305", f"`{extent.cut(step.text)}` from where?", extent, "where?", "name the place")
    if isinstance(found, Fault) and found.code == "E304":
        found = _on_its_place(step, before[-1].end, found, scene, talk.where)
    if found is None or (isinstance(found, Fault) and found.code not in {"E304", "E305"}):
        return step
    if not isinstance(found, Found) or len(found.ids) != 1 or found.chosen:
        return unclear
    ids = [e.id for e in levels]
    here = next((k for k, i in enumerate(ids) if scene.within(talk.where.get(found.ids[0]), i)), None)
    if here is None:
        return unclear
    count = _COUNTS[(m["count"] or m["count2"]).casefold()]
    up = (m["dir"] or m["dir2"]).casefold() in {"up", "higher"}
    at = here + (count if up else -count)
    if not 0 <= at < len(ids):
        return _place(step, extent, ids, at)
    plain = f"to {_short(ids[at], scene)}"
    if len(plain) > extent.end - extent.start:
        return unclear
    step = instead(step, extent, plain, None)
    return instead(step, Extent(extent.start + 3, extent.end), plain[3:], Kind.DESTINATION)


def _short(place: str, scene: Scene) -> str:
    """The shorter of a place's id and its name."""
    name = next((p.name for p in scene.map.places if p.id == place), "") or place
    return min((place, name), key=len)


def _on_its_place(
    step: LabelledStep, at: int, fault: Fault, scene: Scene, where: Mapping[str, str | None]
) -> Found | Fault:
    """ "The yellow block on the shelf", of two: the one that stands there."""
    there = next((s for s in step.spans if s.label is Kind.LOCATION and s.start >= at), None)
    place = resolve_places(tokens(step.text, there.start, there.end), scene, Talk()) if there is not None else None
    if not isinstance(place, Found):
        return fault
    ids = tuple(i for i in fault.candidates if any(scene.within(where.get(i), p) for p in place.ids))
    return Found(ids) if len(ids) == 1 else fault
