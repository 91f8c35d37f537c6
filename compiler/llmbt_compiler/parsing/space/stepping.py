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
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.rows import row_of
from llmbt_compiler.parsing.words import lexicon, tokens

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
_OWN = re.compile(
    rf"\b(?:by\s+|over\s+)?{_COUNT}\s+(?:slot|position|place|spot)s?\s+(?:further\s+)?(?:(?:over|along)\s+)?(?:to\s+)?(?:the\s+|its\s+)?"
    r"(?P<dir>left|right)\b(?!\s+(?:of|than|from|next|beside|hand|on|in)\b)",
    re.IGNORECASE,
)
_ALONG = re.compile(
    r"\b(?:count|go|move|look)\s+(?:along|across|down)\s+(?P<where>[^,;:.!?]{2,40}?)\s*,?\s+(?:from\s+(?:the\s+)?(?P<end>left|right)\s+)?"
    r"to\s+(?P<slot>the\s+[a-z]+\s+(?:slot|position|place|spot))\s*,?\s+and\s+(?P<order>[^;:.!?]{4,80}?\s+(?:in|on|into|onto)\s+)"
    r"(?P<there>that(?:\s+one)?|it|this(?:\s+one)?)(?=\s*(?:[.,;!?]|$))",
    re.IGNORECASE,
)
_FAR = re.compile(
    r"(?:\b(?P<on>on|onto|to|into|in|at)|(?:->|=>|\u2192|:))\s+(?P<outer>(?:the\s+)?[a-z0-9 _]{3,30}?)"
    r"\s*,\s*(?:all\s+the\s+way\s+(?:to|on|at)?\s*|right\s+)?"
    r"(?P<lead>(?:on|at|to|over\s+(?:on|to|at))\s+(?:the|its)\s+)?(?:(?P<far>far|very|extreme)\s+)?(?P<side>left|right)(?P<end>(?:[\s-]hand)?\s+(?:end|side|corner))?"
    r"(?=\s*(?:[,.;!?]|$|please\b))",
    re.IGNORECASE,
)
_COUNTS = {"a": 1, "an": 1, "one": 1, "two": 2, "three": 3, "1": 1, "2": 2, "3": 3}


def stepped(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """The step with the id of the place in place of such words; a fault where there is none so far on."""
    for settle in (_aside, _further, _along, _level, _far):
        done = settle(step, scene, talk)
        if done is not step:
            return done
    return step


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
        row, extent = row_of(_only(found), scene), Extent(m.start(), parts[size - 1].end)
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
    row = row_of(inside[0], scene) if inside else ()
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


def _far(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """ "On the top level, far right": its last position there."""
    m = _FAR.search(step.text)
    found = resolve_places(tokens(step.text, *m.span("outer")), scene, talk) if m is not None else None
    if m is None or not (m["lead"] or m["far"] or m["end"] or "all the way" in m[0].casefold()):
        return step
    if not isinstance(found, Found) or len(found.ids) != 1 or not _only(found) or scene.single(_only(found)):
        return step
    inside = [e.id for e in scene.places if scene.single(e.id) and scene.within(e.id, _only(found))]
    row = row_of(inside[0], scene) if inside else ()
    extent = Extent(m.start("outer"), m.end())
    if not row or len(row) != len(inside):
        return Fault("E304", f"`{extent.cut(step.text)}` fits several places", extent, "where?", "name the place")
    return _place(step, extent, row, 0 if m["side"].casefold() == "left" else len(row) - 1)


def _level(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """ "Lift the yellow block up by one level": so far above the level on which the thing stands."""
    m = _UP.search(step.text)
    if m is None:
        return step
    noun = (m["noun"] or m["noun2"]).casefold()
    levels = [e for e in scene.places if noun in e.words and not scene.single(e.id)]
    if len(levels) < 2 or any(e.number is None for e in levels):
        return step
    extent = Extent(*m.span())
    thing = _moved_thing(step, extent, scene, talk)
    if thing is None:
        return step
    unclear = Fault("E305", f"`{extent.cut(step.text)}` from where?", extent, "where?", "name the place")
    if isinstance(thing, Fault):
        return unclear
    ids = scene.upwards(e.id for e in levels)
    here = next((k for k, i in enumerate(ids) if scene.within(talk.where.get(thing), i)), None)
    if here is None:
        return unclear
    count = _COUNTS[(m["count"] or m["count2"]).casefold()]
    up = (m["dir"] or m["dir2"]).casefold() in {"up", "higher"}
    at = here + (count if up else -count)
    if not 0 <= at < len(ids):
        return _place(step, extent, ids, at)
    return _going(step, extent, _short(ids[at], scene)) or unclear


def _going(step: LabelledStep, extent: Extent, place: str) -> LabelledStep | None:
    """The step with "to" a place in place of some words; None where there is no room."""
    if len(place) + 3 > extent.end - extent.start:
        return None
    step = instead(step, extent, f"to {place}", None)
    return instead(step, Extent(extent.start + 3, extent.end), place, Kind.DESTINATION)


def _moved_thing(step: LabelledStep, extent: Extent, scene: Scene, talk: Talk) -> str | Fault | None:
    """The thing of the step that goes by so much; None where it names none of the map, or its place as well."""
    lead = [s for s in step.spans if s.end <= extent.start]
    if lead and lead[-1].label is Kind.DESTINATION:
        return None  # "on position 24, one level lower"
    found: Found | Fault | None = None
    for span in [s for s in reversed(lead) if s.label is Kind.TARGET][:2]:
        found = resolve_objects(tokens(step.text, span.start, span.end), scene, talk)
        if isinstance(found, Found) and len(found.ids) > 1:
            found = Fault("E304", "several things", extent, candidates=found.ids)
        if isinstance(found, Fault) and found.code == "E304":
            found = _on_its_place(step, span.end, found, scene, talk.where)
        if not isinstance(found, Fault) or found.code != "E305":
            break  # else "the yellow one on the shelf is too far left: shift it"
    if found is None or (isinstance(found, Fault) and found.code not in {"E304", "E305"}):
        return None
    if isinstance(found, Fault):
        return found
    unclear = Fault("E304", f"`{extent.cut(step.text)}`: several things?", extent, "which?", "", found.ids)
    return found.ids[0] if len(found.ids) == 1 and not found.chosen else unclear


def _further(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """ "Shift it one place to the right": from where it stands."""
    m = _OWN.search(step.text)
    extent = Extent(*m.span()) if m is not None else Extent(0, 0)
    thing = _moved_thing(step, extent, scene, talk) if m is not None else None
    if m is None or thing is None:
        return step
    unclear = Fault("E305", f"`{extent.cut(step.text)}` from where?", extent, "where?", "name the place")
    here = talk.where.get(thing) if isinstance(thing, str) else None
    row = row_of(here, scene) if here is not None and scene.single(here) else ()
    if here is None or here not in row:
        return unclear
    count = _COUNTS[m["count"].casefold()]
    at = row.index(here) + (count if m["dir"].casefold() == "right" else -count)
    return _going(step, extent, row[at]) or unclear if 0 <= at < len(row) else _place(step, extent, row, at)


def _short(place: str, scene: Scene) -> str:
    """The shorter of a place's id and its name."""
    name = next((p.name for p in scene.map.places if p.id == place), "") or place
    return min((place, name), key=len)


def _on_its_place(
    step: LabelledStep, at: int, fault: Fault, scene: Scene, where: Mapping[str, str | None]
) -> Found | Fault:
    """ "The yellow block on the shelf", of two: the one that stands there."""
    there = next((s for s in step.spans if s.label is Kind.LOCATION and s.start >= at), None)
    after = tokens(step.text, there.start, there.end) if there is not None else ()
    place = resolve_places(after, scene, Talk()) if after else None
    if not isinstance(place, Found):
        return fault
    ids = tuple(i for i in fault.candidates if any(scene.within(where.get(i), p) for p in place.ids))
    return Found(ids) if len(ids) == 1 else fault
