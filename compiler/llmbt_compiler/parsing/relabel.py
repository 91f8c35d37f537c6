"""Steps relabelled before they are read, where their form or the map's names say more than the tagger does: calls of a
program, notes without a verb, names that a keyword cuts.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.beside import mentions
from llmbt_compiler.parsing.headings import from_to, in_turn, named_by_heading
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import exactly_named
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import read_verb
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["relabelled"]

_LONGEST = 2000


def relabelled(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with the keywords that its form implies; as it is where its form implies none."""
    if len(step.text) > _LONGEST:
        return step
    told = from_to(step, scene)
    if told is not None:
        return told
    step = named_by_heading(in_turn(step))
    called = _calls(step, scene)
    if called is not None:
        return called
    told = _listed(step, scene) or _told_as_placing(step)
    if told is not step:
        return told
    return _whole_names(_nouns_for_verbs(step, scene), scene) if scene.snap else step


# --- calls ----------------------------------------------------------------------------------------------------------

_CALL = re.compile(r"(?:[A-Za-z]\w*\.)?(?P<verb>[A-Za-z]\w*)\s*\((?P<args>[^()]*)\)")
_ARGUMENT = re.compile(r"(?:\w+\s*[=:]\s*)?[\"'`]?(?P<name>[^\"'`,]*[^\"'`,\s])[\"'`]?\s*")
_BETWEEN = re.compile(r"[\s\d;,.>→-]*(?:and|then)?[\s;,.>→-]*")


def _calls(step: LabelledStep, scene: Scene) -> LabelledStep | None:
    """ "pick(object_1); place(object_1, position_12)": each name an action, its arguments by what they are."""
    found = list(_CALL.finditer(step.text))
    edges = [0, *(e for m in found for e in m.span()), len(step.text)]
    outside = zip(edges[::2], edges[1::2], strict=True)
    if not found or not all(_BETWEEN.fullmatch(step.text, a, b) for a, b in outside):
        return None
    spans: list[KeywordSpan] = []
    for m in found:
        spans.append(KeywordSpan(*m.span("verb"), Kind.ACTION, m["verb"]))
        spans += _arguments(step.text, *m.span("args"), scene)
    return replace(step, spans=tuple(spans), readings=())


def _arguments(text: str, start: int, end: int, scene: Scene) -> Iterator[KeywordSpan]:
    """Things are targets; the last place is where they go, one before it where they are."""
    names: list[tuple[int, int, bool]] = []
    at = start
    for part in text[start:end].split(","):
        m = _ARGUMENT.search(text, at, at + len(part))
        if m is not None and m["name"].strip():
            a, b = m.span("name")
            known = exactly_named(tokens(text, a, b), scene.places) if tokens(text, a, b) else ()
            names.append((a, b, bool(known)))
        at += len(part) + 1
    places = sum(place for _, _, place in names)
    for i, (a, b, place) in enumerate(names):
        kind = Kind.DESTINATION if place or (i and not places) else Kind.TARGET
        if place and places > 1 and i < len(names) - 1:
            kind = Kind.LOCATION
        yield KeywordSpan(a, b, kind, text[a:b])


# --- notes without a verb -------------------------------------------------------------------------------------------

_GOES = re.compile(
    r"\W*(?P<thing>[^,;:.]{2,80}?)\s+(?:(?:should|must|will|has to|have to|needs? to|is to|are to)\s+)?(?:then\s+|"
    r"also\s+|"
    r"now\s+)?(?:go|goes|belongs?)\s+(?:back\s+)?(?:on|onto|to|into|in|at)\s+(?P<place>[^,;:.]{2,80})[\s.!]*$",
    re.IGNORECASE,
)
_IS_GIVEN = re.compile(
    r"^\W*(?P<place>[^,;:.]{2,80}?)\s+(?:(?:should|must|will)\s+)?(?:gets?|"
    r"receives?)\s+(?P<thing>[^,;:.]{2,80})[\s.!]*$",
    re.IGNORECASE,
)
_COLON = re.compile(r"^\W*(?P<thing>[^,;:.]{2,60}?)\s*(?::|->|=>|→)\s*(?P<place>[^,;:.]{2,60})[\s.!]*$", re.IGNORECASE)
_HEADED = re.compile(r"^\W*(?P<place>[^,;:.]{2,40}?)\s*:\s*(?P<things>[^:;]{2,200}?)[\s.!]*$")
_PART = re.compile(r"(?:^|,|&|\band\b)\s*(?P<name>(?:(?!,|&|\band\b).)+?)\s*(?=,|&|\band\b|$)")
_LEAD = re.compile(r"^\W*(?:as|since|because)\s[^,;:.]{2,80},\s*(?=\S)", re.IGNORECASE)
_ROBOT = re.compile(r"(?:the )?(?:robot|arm|gripper|hand|manipulator|you|we)\b", re.IGNORECASE)


def _listed(step: LabelledStep, scene: Scene) -> LabelledStep | None:
    """ "Level 1: object 1, object 2": a place and, behind the colon, nothing but names of things."""
    m = _HEADED.match(step.text)
    if m is None or len(exactly_named(tokens(step.text, *m.span("place")), scene.places)) != 1:
        return None
    spans = [KeywordSpan(*m.span("place"), Kind.DESTINATION, m["place"])]
    for part in _PART.finditer(m["things"]):
        a, b = (m.start("things") + i for i in part.span("name"))
        if len(exactly_named(tokens(step.text, a, b), scene.objects)) != 1:
            return None
        spans.append(KeywordSpan(a, b, Kind.TARGET, part["name"]))
    return replace(step, spans=tuple(spans), readings=()) if len(spans) > 1 else None


def _told_as_placing(step: LabelledStep) -> LabelledStep:
    """A step that says where a thing goes without telling anybody to put it there ("object 1 goes to position 11",
    "position 21 gets object 3", "object 3: position 22"): its thing as target and its place as destination."""
    text = step.text
    if len(text) > 300:
        return step
    taken = {s.label for s in step.spans}
    lead = _LEAD.match(text)
    for pattern in (_GOES, _IS_GIVEN, _COLON):
        m = pattern.match(text, lead.end() if lead and pattern is _GOES else 0)
        if m is None or _ROBOT.match(m["thing"]):
            continue
        if pattern is _IS_GIVEN and (_ROBOT.match(m["place"]) or not re.search(r"\d", m["place"])):
            continue
        if pattern is _COLON and (Kind.ACTION in taken or not re.search(r"\d", m["place"])):
            continue
        ends = [(m.start(k), m.end(k), label) for k, label in (("thing", Kind.TARGET), ("place", Kind.DESTINATION))]
        spans = tuple(KeywordSpan(a, b, label, text[a:b]) for a, b, label in sorted(ends, key=lambda e: e[:2]))
        return replace(step, spans=spans, readings=())
    return step


def _nouns_for_verbs(step: LabelledStep, scene: Scene) -> LabelledStep:
    """An action that is no verb and names a thing of the scene ("Milk to the user") is a target."""
    own = scene.vocabulary(True)

    def label(s: KeywordSpan) -> KeywordSpan:
        word = s.text.casefold()
        if s.label is not Kind.ACTION or (word not in own and word not in scene.colours):
            return s
        verb = read_verb(word, (), scene.library)
        known = (verb.templates or verb.classes) and not verb.corrected
        return s if known else replace(s, label=Kind.TARGET)

    return replace(step, spans=tuple(label(s) for s in step.spans))


# --- names that a keyword cuts --------------------------------------------------------------------------------------


def _whole_names(step: LabelledStep, scene: Scene) -> LabelledStep:
    """A keyword that covers a part of a name is the whole of it, where nothing else is labelled there."""
    spans = sorted(step.spans, key=lambda s: s.start)
    for first, last in mentions(tokens(step.text), scene):
        touched = [s for s in spans if s.start < last.end and first.start < s.end]
        kinds = {s.label for s in touched}
        if not touched or len(kinds) > 1 or kinds == {Kind.ACTION}:
            continue
        start, end = min(first.start, touched[0].start), max(last.end, touched[-1].end)
        if len(touched) == 1 and (start, end) == (touched[0].start, touched[0].end):
            continue
        if first.text == "a" or lexicon().is_(last.text, "articles"):
            continue
        whole = replace(
            touched[0], start=start, end=end, text=step.text[start:end], confidence=min(s.confidence for s in touched)
        )
        spans = sorted([*(s for s in spans if s not in touched), whole], key=lambda s: s.start)
    return replace(step, spans=tuple(spans))
