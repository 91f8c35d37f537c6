"""Sentences that tell what goes where, several things at once or as a record of fields: "the banana goes on the table,
the apple on the bar", "put A where B is and vice versa", "destination of the drum: outbound tray",
``{"action": "place", "object": "object_1", "to": "position_12"}``.
"""

from __future__ import annotations

import re
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import Found, Talk, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import read_verb
from llmbt_compiler.parsing.words import tokens

__all__ = ["destined", "due", "goings", "record", "vice_versa"]

_SHORT = 300
_ON = r"(?:on|onto|to|into|in|at)"
_MODAL = r"(?:(?:should|must|will|has\s+to|have\s+to|needs?\s+to|is\s+to|are\s+to|can)\s+)?"
_GOING = re.compile(
    rf"\W*(?P<thing>[^,;:.]{{2,60}}?)\s+{_MODAL}(?:go(?:es)?|belongs?)\s+{_ON}\s+(?P<place>[^,;:.]{{1,60}})",
    re.IGNORECASE,
)
_LIKEWISE = re.compile(rf"\W*(?P<thing>[^,;:.]{{2,60}}?)\s+{_ON}\s+(?P<place>[^,;:.]{{1,60}})", re.IGNORECASE)
_CUT = re.compile(r"\s*(?:[,;]\s*(?:and\s+|while\s+)?|\band\s+|\bwhile\s+)", re.IGNORECASE)


def _found(step: LabelledStep, scene: Scene, at: tuple[int, int], kind: Kind) -> bool:
    """Whether these words name one place, or things, of the map by themselves."""
    parts = tokens(step.text, *at)
    if not parts:
        return False
    if kind is Kind.TARGET:
        things = resolve_objects(parts, scene, Talk({o.id: o.place for o in scene.map.objects}))
        return isinstance(things, Found) and not things.corrected and not things.chosen
    place = resolve_places(parts, scene, Talk())
    return isinstance(place, Found) and len(place.ids) == 1 and not place.corrected


def goings(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "The banana goes on the table, the apple on the bar and the milk on the desk": each thing and where it goes."""
    text = step.text.rstrip(" .!")
    if len(text) > _SHORT or not _GOING.match(text):
        return step
    cuts = [m.span() for m in _CUT.finditer(text)]
    ends = [0, *(e for cut in cuts for e in cut), len(text)]
    spans: list[KeywordSpan] = []
    for i, (a, b) in enumerate(zip(ends[::2], ends[1::2], strict=True)):
        m = _GOING.fullmatch(text, a, b) or (_LIKEWISE.fullmatch(text, a, b) if i else None)
        if m is None:
            return step
        for key, kind in (("thing", Kind.TARGET), ("place", Kind.DESTINATION)):
            if not _found(step, scene, m.span(key), kind):
                return step
            spans.append(KeywordSpan(*m.span(key), kind, m[key]))
    return replace(step, spans=tuple(spans), readings=()) if len(spans) > 2 else step


_IS = r"\s+(?:is|stands|sits|lies|are)(?:\s+(?:now|currently|right\s+now|at\s+the\s+moment))?"
_TAKES = re.compile(
    r"\W*(?P<one>[^,;:.]{2,60}?)\s+(?:should\s+|must\s+|will\s+)?(?P<verb>takes?)\s+the\s+(?:place|position|slot|spot)\s+of\s+"
    r"(?P<other>[^,;:.]{2,60}?),?\s+and\s+(?:vice[\s-]+versa|the\s+other\s+way\s+(?:a?round))",
    re.IGNORECASE,
)
_VICE_VERSA = re.compile(
    rf"\W*(?P<verb>\w+)\s+(?P<one>[^,;:.]{{2,60}}?)\s+(?:to\s+)?(?:where|the\s+\w+\s+(?:that|where))\s+(?P<other>[^,;:.]{{2,60}}?){_IS}"
    rf"(?:\s+on)?,?\s+and\s+(?:vice[\s-]+versa|the\s+other\s+way\s+(?:a?round)"
    rf"|(?P<back>[^,;:.]{{2,60}}?)\s+(?:to\s+)?where\s+(?P<first>[^,;:.]{{2,60}}?)(?:\s+(?:is|was|stands|stood)\b[\w\s]{{0,20}})?)",
    re.IGNORECASE,
)


def vice_versa(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Put A where B is and vice versa", "... and B where A is": the two change places."""
    text = step.text.rstrip(" .!") if len(step.text) <= _SHORT else ""
    m = _VICE_VERSA.fullmatch(text) or _TAKES.fullmatch(text)
    if m is None or not read_verb(m["verb"].casefold(), (), scene.library).templates:
        return step
    named = {
        k: resolve_objects(tokens(step.text, *m.span(k)), scene, Talk()) for k in m.groupdict() if k != "verb" and m[k]
    }
    ids = {k: f.ids if isinstance(f, Found) and len(f.ids) == 1 else () for k, f in named.items()}
    if not all(ids.values()) or ids["one"] == ids["other"]:
        return step
    if "back" in ids and (ids["back"], ids["first"]) != (ids["other"], ids["one"]):
        return step
    spans = [KeywordSpan(*m.span("verb"), Kind.ACTION, "swap")]
    spans += [KeywordSpan(*m.span(k), Kind.TARGET, m[k]) for k in named]
    return replace(step, spans=tuple(spans), readings=())


_DESTINED = re.compile(
    r"\W*(?:the\s+)?(?:(?:target|final|new)\s+)?(?:destination|target|goal|position|place|slot|spot|location)\s+(?:of|for)\s+"
    r"(?P<thing>[^,;:.]{2,60}?)\s*(?::|=|->|→|\s(?:is|will\s+be|should\s+be)\s)\s*(?:the\s+)?(?P<place>[^,;:.]{1,60}?)[\s.!]*",
    re.IGNORECASE,
)
_NEW = re.compile(r"\b(?:destination|target|final|new|goal)\b", re.IGNORECASE)


def destined(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Destination of the drum: outbound tray", "target position for object 6 is position 34"."""
    m = _DESTINED.fullmatch(step.text) if len(step.text) <= _SHORT else None
    if m is None or not _NEW.search(step.text, 0, m.start("thing")):
        return step
    ends = (("thing", Kind.TARGET), ("place", Kind.DESTINATION))
    if not all(_found(step, scene, m.span(k), kind) for k, kind in ends):
        return step
    return replace(step, spans=tuple(KeywordSpan(*m.span(k), kind, m[k]) for k, kind in ends), readings=())


_WOULD = (
    r"(?:(?:should|must|will|shall|ought\s+to|has\s+to|have\s+to|needs?\s+to|wants?\s+to|gets?\s+to|(?:is|are)\s+"
    r"(?:(?:supposed|meant|required|due|scheduled|going)\s+)?to)\s+(?:(?:then|now|also|finally)\s+)?)"
)
_WISHED = (
    r"\W*(?:(?:in|at)\s+the\s+end,?\s+|finally,?\s+)?(?:(?:please\s+)?(?:(?:make|be)\s+sure|ensure|see(?:\s+to\s+it)?)"
    r"(?:\s+that)?\s+|(?:the\s+)?(?:goal|aim|idea)\s+is\s+that\s+|it['’]?\s*i?s\s+time\s+for\s+|time\s+for\s+)?"
)
_THEN = r"(?:\s*[,;.]?\s*(?:and\s+|so\s+)?(?:please\s+)?\w+\s+(?:it|them)\s+there)?(?:,?\s+(?:please|now|then))*[\s.!]*"
_HOME = r"(?:place|home|spot|seat|rightful\s+place)"
_DUE = tuple(
    re.compile(pattern + _THEN, re.IGNORECASE)
    for pattern in (
        rf"{_WISHED}(?P<thing>[^,;:.]{{2,80}}?)\s+{_WOULD}(?:go|belong|live|get|end\s+up|be|sit|stand|rest|come)\s+"
        rf"(?:back\s+|up\s+|down\s+|over\s+)?{_ON}\s+(?P<place>[^,;:.]{{1,60}}?)",
        rf"{_WISHED}(?P<thing>[^,;:.]{{2,80}}?)\s+(?:goes|belongs?|lives?|gets|ends?\s+up)\s+"
        rf"(?:back\s+|up\s+|down\s+|over\s+)?{_ON}\s+(?P<place>[^,;:.]{{1,60}}?)",
        rf"{_WISHED}(?P<thing>[^,;:.]{{2,80}}?)\s+(?:(?:is|are)\s+(?:meant|destined|intended|bound|due|earmarked|scheduled)\s+"
        rf"(?:for|{_ON})|(?:has|have|finds?)\s+(?:its|their)\s+{_HOME}\s+{_ON}|deserves?(?:\s+an?\s+{_HOME}\s+{_ON})?)"
        rf"\s+(?P<place>[^,;:.]{{1,60}}?)",
        rf"\W*(?P<place>[^,;:.]{{2,60}}?)\s+(?:{_WOULD}(?:receive|get|hold|house|contain|accommodate|have|be\s+(?:occupied\s+"
        rf"by|filled\s+(?:with|by)|given))|receives|(?:is|are)\s+(?:meant|intended|destined)\s+for)\s+"
        rf"(?P<thing>[^,;:.]{{2,80}}?)",
        r"\W*(?:assign|allocate|allot|use|dedicate)\s+(?P<place>[^,;:.]{2,60}?)\s+(?:to|for)\s+(?P<thing>[^,;:.]{2,80}?)",
        r"\W*(?:(?:target|object|item|thing)\s*[:=]\s*)?(?P<thing>[^,;:.=]{2,60}?)\s*[,;:|–—-]?\s*(?:(?:target|final|new)\s+)?"
        r"destination\s*[:=]?\s*(?P<place>[^,;:.=]{1,60}?)",
    )
)


def due(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Object 1 is meant for position 12", "the cube wants to live in slot 3, so put it there", "slot 3 is to receive
    the drum", "use slot 3 for the drum", "object 1: destination position 12"."""
    if len(step.text) > _SHORT:
        return step
    for pattern in _DUE:
        m = pattern.fullmatch(step.text)
        ends = (("thing", Kind.TARGET), ("place", Kind.DESTINATION))
        if m is None or not all(_found(step, scene, m.span(k), kind) for k, kind in ends):
            continue
        spans = [KeywordSpan(*m.span(k), kind, m[k]) for k, kind in ends]
        return replace(step, spans=tuple(sorted(spans, key=lambda s: s.start)), readings=())
    return step


_FIELD = re.compile(
    r"[\"'`]?(?P<key>[A-Za-z]\w*)[\"'`]?\s*[:=]\s*[\"'`]?(?P<value>[^\"'`,;:={}]{1,60}?)[\"'`]?\s*(?:[,;]\s*|$)"
)
_DOING = frozenset({"action", "verb", "command", "cmd", "skill", "operation", "act", "function", "type", "name"})


def record(step: LabelledStep, scene: Scene) -> LabelledStep:
    """``{"action": "place", "object": "object_1", "to": "position_12"}``: the action, and names by what they are; of
    two places the last is where it goes, unless its field says "from"."""
    body = re.fullmatch(r"\W*?\{(?P<fields>[^{}]*)\}[\s,;.\]]*", step.text) if len(step.text) <= _SHORT else None
    at, end = body.span("fields") if body is not None else (0, 0)
    spans: list[KeywordSpan] = []
    while at < end:
        m = _FIELD.match(step.text[:end], at + len(step.text[at:end]) - len(step.text[at:end].lstrip()))
        if m is None:
            return step
        at, parts = m.end(), tokens(step.text, *m.span("value"))
        kind = None
        if m["key"].casefold() in _DOING:
            kind = Kind.ACTION
        elif exactly_named(parts, scene.objects):
            kind = Kind.TARGET
        elif exactly_named(parts, scene.places):
            kind = Kind.LOCATION if m["key"].casefold() in {"from", "source", "origin"} else Kind.DESTINATION
        if kind is None:
            return step
        spans.append(KeywordSpan(*m.span("value"), kind, m["value"]))
    kinds = [s.label for s in spans]
    return replace(step, spans=tuple(spans), readings=()) if kinds.count(Kind.ACTION) == 1 else step
