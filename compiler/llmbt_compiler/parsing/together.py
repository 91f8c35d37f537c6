"""Keywords that belong together or apart: "position 14 object 5" is a place and a thing, "green on level 1" a thing and
a place, "the cookies plus the apple" two things."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import pairwise

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.beside import mentions
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import Found, Talk, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import read_verb
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = [
    "also_named",
    "done_by",
    "headed_by_things",
    "inverted",
    "of_those",
    "parted",
    "placed_there",
    "released",
    "same_noun",
    "whole_with_colour",
]

_LINKS = frozenset({"plus", "and", "along", "together", "with", "as", "well", "also", "the", "a", "an", "then", ","})
_JOINING = ({"plus"}, {"as", "well"}, {"along", "with"}, {"together", "with"}, {"and"})
_FOLLOWED = re.compile(r"\bfollowed\s+by\b", re.IGNORECASE)
_ANYTHING = frozenset({"everything", "anything", "something", "all"})
_WORTH = frozenset({"the", "a", "an", "and", ","})


def of_those(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "The larger of the | two red cubes", "the red | and the blue cup": one phrase that the tagger cut."""
    out: list[KeywordSpan] = []
    for s in step.spans:
        last = out[-1] if out else None
        if last is not None and last.label is s.label is Kind.TARGET:
            gap = tokens(step.text, last.start, s.start)[-4:]
            words = [t.text for t in gap if t.number is None and not lexicon().is_(t.text, "articles")]
            between = tokens(step.text, last.end, s.start)
            own = {t.text for t in tokens(step.text, last.start, last.end)}
            bare = own <= scene.colours | lexicon().sizes.keys()
            linked = [t.text for t in between if not lexicon().is_(t.text, "articles")] == ["and"]
            if (words[-1:] == ["of"] and all(t.word for t in between)) or (bare and linked):
                out[-1] = replace(last, end=s.end, text=step.text[last.start : s.end])
                continue
        out.append(s)
    return replace(step, spans=tuple(out)) if len(out) < len(step.spans) else step


def whole_with_colour(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Everything | red": the colour right behind it is part of it."""

    def whole(s: KeywordSpan) -> KeywordSpan:
        after = tokens(step.text, s.end)[:1]
        taken = any(o.start < a.end and s.end <= o.start for a in after for o in step.spans)
        if s.label is not Kind.TARGET or s.text.casefold() not in _ANYTHING or not after or taken:
            return s
        end = after[0].end
        return replace(s, end=end, text=step.text[s.start : end]) if after[0].text in scene.colours else s

    return replace(step, spans=tuple(whole(s) for s in step.spans))


def same_noun(step: LabelledStep) -> LabelledStep:
    """ "On the same | level": the noun is part of the name."""

    def whole(s: KeywordSpan) -> KeywordSpan:
        after = tokens(step.text, s.end)[:1]
        if s.label is Kind.ACTION or s.text.casefold() != "same" or not after or not after[0].word:
            return s
        end = after[0].end
        taken = any(o.start < end and s.end <= o.start for o in step.spans)
        return s if taken else replace(s, end=end, text=step.text[s.start : end])

    return replace(step, spans=tuple(whole(s) for s in step.spans))


def parted(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with a destination that names a place and, right behind it, a thing as two keywords."""
    out: list[KeywordSpan] = []
    for s in step.spans:
        cut = _cut(tokens(step.text, s.start, s.end), scene) if s.label is Kind.DESTINATION else None
        if cut is None:
            out.append(s)
            continue
        place, thing = cut
        for label, (a, b) in ((Kind.DESTINATION, place), (Kind.TARGET, thing)):
            out.append(replace(s, label=label, start=a, end=b, text=step.text[a:b]))
    return replace(step, spans=tuple(out)) if len(out) > len(step.spans) else step


def _cut(parts: tuple[Token, ...], scene: Scene) -> tuple[tuple[int, int], tuple[int, int]] | None:
    """The extents of a place and of a thing right behind it that are all there is."""
    for i in range(len(parts) - 1, 0, -1):
        place, thing = parts[:i], parts[i:]
        if len(exactly_named(place, scene.places)) != 1 or len(exactly_named(parts, scene.places)) == 1:
            continue
        found = resolve_objects(thing, scene, Talk())
        if thing[0].word and isinstance(found, Found) and not found.corrected and not found.chosen:
            return (place[0].start, place[-1].end), (thing[0].start, thing[-1].end)
    return None


_INTO = r"(?:on|onto|to|into|in|at)"
_FIRST = re.compile(
    rf"\W*{_INTO}\s+(?P<place>[^,;:.]{{2,60}}?)\s+(?:(?:should|must|will)\s+)?go(?:es)?\s+(?P<thing>[^,;:.]{{2,60}})",
    re.IGNORECASE,
)
_NEXT = re.compile(rf"\s*(?:[,;]\s*(?:and\s+)?|and\s+)(?={_INTO}\s)", re.IGNORECASE)
_SHORT = 300


def inverted(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Into slot A3 goes parcel 17, into A4 parcel 18": first the place, then the thing."""
    text = step.text.rstrip(" .!")
    cuts = [m.span() for m in _NEXT.finditer(text)] if len(text) <= _SHORT and _FIRST.match(text) else []
    ends = [0, *(e for cut in cuts for e in cut), len(text)]
    spans: list[KeywordSpan] = []
    for a, b in zip(ends[::2], ends[1::2], strict=True):
        m = _FIRST.fullmatch(text, a, b)
        lead = re.compile(rf"\W*{_INTO}\s+", re.IGNORECASE).match(text, a, b)
        cut = (m.span("place"), m.span("thing")) if m else _cut(tokens(text, lead.end(), b), scene) if lead else None
        if cut is None or len(exactly_named(tokens(text, *cut[0]), scene.places)) != 1:
            return step
        for kind, (c, d) in zip((Kind.DESTINATION, Kind.TARGET), cut, strict=True):
            spans.append(KeywordSpan(c, d, kind, text[c:d]))
    return replace(step, spans=tuple(spans), readings=()) if _FIRST.match(text) else step


def headed_by_things(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with each destination that is no place but names things, right before a place with "on" or "in", as a
    target: "green on level 1, yellow on level 2"."""
    out: list[KeywordSpan] = []
    for s, after in zip(step.spans, (*step.spans[1:], None), strict=False):
        out.append(s)
        if s.label is not Kind.DESTINATION or after is None or after.label is not Kind.DESTINATION:
            continue
        parts = tokens(step.text, s.start, after.start)
        on = next((i for i, t in enumerate(parts) if lexicon().is_(t.text, "at", "onto")), 0)
        rest = [t for t in parts[on + 1 :] if not lexicon().is_(t.text, "articles")]
        if not on or rest or isinstance(resolve_places(parts[:on], scene, Talk()), Found):
            continue
        if isinstance(resolve_objects(parts[:on], scene, Talk()), Found):
            end = parts[on - 1].end
            out[-1] = replace(s, label=Kind.TARGET, end=end, text=step.text[s.start : end])
    return replace(step, spans=tuple(out))


def also_named(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with a thing that is joined to another and was not labelled ("the cookies plus the apple"), where
    nothing follows that is said of it alone."""
    parts = tokens(step.text)
    spans = list(step.spans)
    for first, last in mentions(parts, scene):
        name = [t for t in parts if first.start <= t.start <= last.start]
        if any(s.start < last.end and first.start < s.end for s in spans) or not name[0].word:
            continue
        if len(exactly_named(name, scene.objects)) != 1:
            continue
        before = max((s for s in spans if s.end <= first.start), key=lambda s: s.end, default=None)
        lead = [t.text for t in parts if before is not None and before.end <= t.start and t.end <= first.start]
        if before is None or not lead or not set(lead) <= _LINKS or not any(j <= set(lead) for j in _JOINING):
            continue
        then = _FOLLOWED.search(step.text, before.end, first.start) is not None
        strong = bool(set(lead) - _WORTH) or then  # "plus", "along with", "followed by"
        if before.label is not Kind.TARGET and not (before.label is Kind.DESTINATION and strong):
            continue
        after = next((t.text for t in parts if t.start >= last.end), "")
        if lexicon().is_(after, "stative", "negation") or (not strong and lexicon().is_(after, "from")):
            continue
        spans.append(KeywordSpan(first.start, last.end, Kind.TARGET, step.text[first.start : last.end]))
        spans.sort(key=lambda s: s.start)
    return replace(step, spans=tuple(spans)) if len(spans) > len(step.spans) else step


def released(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Open the gripper to release object 6": a verb that was taken for a part of a name is an action."""
    out: list[KeywordSpan] = []
    for s in step.spans:
        parts = tokens(step.text, s.start, s.end) if s.label is not Kind.ACTION else ()
        verb = read_verb(parts[0].text, (), scene.library) if len(parts) > 1 else None
        if (
            verb is None
            or verb.corrected
            or not (verb.is_("opening") or verb.templates)
            or not _after_to(step, s.start)
        ) and not _emptied(step, s, scene):
            out.append(s)
            continue
        known = isinstance(resolve_objects(parts[1:], scene, Talk()), Found)
        if (not known or isinstance(resolve_places(parts, scene, Talk()), Found)) and not _emptied(step, s, scene):
            out.append(s)
            continue
        out.append(replace(s, label=Kind.ACTION, end=parts[0].end, text=step.text[s.start : parts[0].end]))
        out.append(replace(s, label=Kind.TARGET, start=parts[1].start, text=step.text[parts[1].start : s.end]))
    return replace(step, spans=tuple(out)) if len(out) > len(step.spans) else step


def _emptied(step: LabelledStep, span: KeywordSpan, scene: Scene) -> bool:
    """ "Move crate A to B1 and | empty slot A2": a verb, where it is no destination."""
    parts = tokens(step.text, span.start, span.end)
    named = (
        exactly_named(parts[1:], scene.places) if len(parts) > 1 and parts[0].text in {"empty", "clear", "free"} else ()
    )
    lead = [t.text for t in tokens(step.text, 0, span.start)][-1:]
    return (
        len(named) == 1
        and span.label is not Kind.ACTION
        and (not lead or lexicon().is_(lead[0], "joints") or lead == [","])
    )


def _after_to(step: LabelledStep, at: int) -> bool:
    return [t.text for t in tokens(step.text, 0, at)][-1:] == ["to"]


def placed_there(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with a place that a preposition joins to the thing right before it, and that was not labelled, as a
    destination ("... and the apple on the shelf"), where the thing does not stand there."""
    parts = tokens(step.text)
    spans = list(step.spans)
    for first, last in mentions(parts, scene):
        name = [t for t in parts if first.start <= t.start <= last.start]
        named = exactly_named(name, scene.places)
        before = max((s for s in spans if s.end <= first.start), key=lambda s: s.end, default=None)
        if len(named) != 1 or any(s.start < last.end and first.start < s.end for s in spans) or before is None:
            continue
        lead = [t.text for t in parts if before.end <= t.start and t.end <= first.start]
        plain = [w for w in lead if not lexicon().is_(w, "articles")]
        if before.label is not Kind.TARGET or len(plain) != 1 or not lexicon().is_(plain[0], "at", "onto"):
            continue
        things = resolve_objects(tokens(step.text, before.start, before.end), scene, Talk())
        here = [o.place for o in scene.map.objects if isinstance(things, Found) and o.id in things.ids]
        if not here or any(scene.within(p, named[0].id) for p in here):
            continue
        spans.append(KeywordSpan(first.start, last.end, Kind.DESTINATION, step.text[first.start : last.end]))
        spans.sort(key=lambda s: s.start)
    return replace(step, spans=tuple(spans)) if len(spans) > len(step.spans) else step


def done_by(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Clear the table by moving everything on it ...": the verb behind "by" is an action, labelled or not."""
    parts = tokens(step.text)
    for by, verb in pairwise(parts):
        if by.text != "by" or not verb.text.endswith("ing") or any(s.start <= verb.start < s.end for s in step.spans):
            continue
        known = read_verb(verb.text, (), scene.library)
        if known.templates and not known.corrected and any(s.label is Kind.ACTION for s in step.spans):
            action = KeywordSpan(verb.start, verb.end, Kind.ACTION, step.text[verb.start : verb.end])
            return replace(step, spans=tuple(sorted((*step.spans, action), key=lambda s: s.start)))
    return step
