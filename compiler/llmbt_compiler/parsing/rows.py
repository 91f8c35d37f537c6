"""Plans told as rows of things and places: "object 3 | position 14; object 5 | position 24", "parcel 17 -> A3",
"slots B1 and B2 receive parcel 17 and parcel 18, respectively"."""

from __future__ import annotations

import re
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import Shape, read_verb, shape_of
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["given", "rows"]

_SHORT = 400
_HEADING = re.compile(
    r"^(?P<title>[^:,;.]{0,80}?)(?::|\b(?:so|such)\s+that(?:\s+the)?\b|\bin\s+such\s+a\s+way\s+that\b)\s*(?=\S)",
    re.IGNORECASE,
)
_CUT = re.compile(r"\s*(?:[;\n]|,(?:\s*(?:and|then))?\s|\band\s)\s*", re.IGNORECASE)
_TO = (
    r"\s*(?:\||->|=>|→|⇒|=|:)\s*|\s+(?:-|–|—)\s+"
    r"|\s+(?:(?:goes|go|belongs?|is|are|ends?\s+up|gets?|comes?)\s+)?(?:to|on|onto|in|into|at)\s+(?:the\s+)?"
)
_SIGN = re.compile(r"\||->|=>|→|⇒|=|:|\s-\s|–|—")
_ROW = re.compile(rf"\W*?(?P<thing>[^|;:=→⇒]{{2,50}}?)(?:{_TO})(?P<place>[^|;:=→⇒]{{1,50}}?)[\s.!|]*", re.IGNORECASE)


def _things(step: LabelledStep, scene: Scene, at: tuple[int, int]) -> bool:
    parts = tokens(step.text, *at)
    found = resolve_objects(parts, scene, Talk({o.id: o.place for o in scene.map.objects})) if parts else None
    return isinstance(found, Found) and not found.corrected


def _place(step: LabelledStep, scene: Scene, at: tuple[int, int]) -> bool:
    parts = tokens(step.text, *at)
    found = resolve_places(parts, scene, Talk()) if parts else None
    return isinstance(found, Found) and not found.corrected and not {ANYWHERE, ORIGIN} & set(found.ids)


def _titled(step: LabelledStep, scene: Scene) -> int | None:
    """Where what follows a heading begins; None where the heading does not tell to put things somewhere, or names a
    thing. 0: there is none."""
    m = _HEADING.match(step.text)
    if m is None:
        return 0
    title = tokens(m["title"])
    if any(lexicon().is_(t.text, "negation", "conditional") for t in title):
        return None
    verbs = [s for s in step.spans if s.label is Kind.ACTION and s.end <= m.end()]
    shapes = {
        shape_of(t, scene.library) for s in verbs for t in read_verb(s.text.casefold(), (), scene.library).templates[:1]
    }
    if verbs and not shapes <= {Shape.PLACE, Shape.PICK, Shape.TRAVEL, Shape.OTHER}:
        return None
    named = any(t.number is not None or t.text in scene.vocabulary(True) for t in title)
    return None if named else m.end()


def rows(step: LabelledStep, scene: Scene) -> LabelledStep:
    """A step of nothing but pairs of a thing and a place, with or without a heading: each as target and destination."""
    if len(step.text) > _SHORT:
        return step
    text = step.text.rstrip(" .!")
    begin = _titled(step, scene)
    if begin is None:
        return step
    cuts = [m.span() for m in _CUT.finditer(text, begin)]
    ends = [begin, *(e for cut in cuts for e in cut), len(text)]
    spans: list[KeywordSpan] = []
    signs = 0
    for a, b in zip(ends[::2], ends[1::2], strict=True):
        m = _ROW.fullmatch(text, a, b)
        if m is None or not _things(step, scene, m.span("thing")) or not _place(step, scene, m.span("place")):
            return step
        signs += _SIGN.search(text, m.end("thing"), m.start("place")) is not None
        spans.append(KeywordSpan(*m.span("thing"), Kind.TARGET, m["thing"]))
        spans.append(KeywordSpan(*m.span("place"), Kind.DESTINATION, m["place"]))
    alone = len(spans) > 2 and (signs == len(spans) // 2 or begin)
    return replace(step, spans=tuple(spans), readings=()) if alone else step


_GETS = (
    r"(?:(?:should|must|will|shall|may|is\s+to|are\s+to)\s+)?(?:then\s+|now\s+|also\s+)?(?:gets?|receives?|takes?)"
    r"|(?:should|must|will|shall|is\s+to|are\s+to)\s+(?:hold|contain|house|have|be\s+given)|(?:is|are)\s+for"
)
_GIVEN = re.compile(rf"\W*(?P<place>[^;:.]{{2,80}}?)\s+(?:{_GETS})\s+(?P<thing>[^;:.]{{2,100}}?)", re.IGNORECASE)
_WHERE = re.compile(
    r"\W*(?P<place>[^,;:.]{2,60}?)\s+is\s+where\s+(?P<thing>[^,;:.]{2,60}?)\s+"
    r"(?:(?:should|must|has\s+to|have\s+to|needs?\s+to|is\s+to|will)\s+)?(?:be|go(?:es)?|belongs?|ends?\s+up|lives?)",
    re.IGNORECASE,
)
_AFTER = re.compile(
    r"\s*(?:,?\s*respectively|\bfirst\b(?=\s*(?:,|and\b|$))|\b(?:right\s+)?after\s+(?:it|that)|\btoo|\bas\s+well|\bplease)\s*",
    re.IGNORECASE,
)


def given(whole: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Position 21 gets object 3", "slots B1 and B2 receive parcels 17 and 18", "crate C gets slot A3"."""
    if len(whole.text) > _SHORT or any(lexicon().is_(t.text, "negation", "conditional") for t in tokens(whole.text)):
        return whole
    text = _AFTER.sub(lambda w: " " * len(w[0]), whole.text.rstrip(" .!"))
    step = replace(whole, text=text.ljust(len(whole.text)))
    spans = _gives(step, scene, text, 0, len(text))
    if spans is None:
        cuts = [m.span() for m in _CUT.finditer(text)]
        ends = [0, *(e for cut in cuts for e in cut), len(text)]
        each = [_gives(step, scene, text, a, b) for a, b in zip(ends[::2], ends[1::2], strict=True)]
        spans = [s for e in each for s in e or ()] if cuts and None not in each else None
    return replace(step, spans=tuple(spans), readings=()) if spans else whole


def _gives(step: LabelledStep, scene: Scene, text: str, start: int, end: int) -> list[KeywordSpan] | None:
    m = _WHERE.fullmatch(text, start, end) or _GIVEN.fullmatch(text, start, end)
    if m is None:
        return None
    named = bool(re.search(r"\d", m["place"])) or any(t.text in scene.vocabulary(False) for t in tokens(m["place"]))
    place, thing = m.span("place"), m.span("thing")
    if not named:
        return None
    if _place(step, scene, place) and _things(step, scene, thing):
        kinds = ((place, Kind.DESTINATION), (thing, Kind.TARGET))
    elif _things(step, scene, place) and _place(step, scene, thing):
        kinds = ((place, Kind.TARGET), (thing, Kind.DESTINATION))
    else:
        return None
    person = any(
        e.person and e.id in _ids(step, scene, a) for a, k in kinds if k is Kind.DESTINATION for e in scene.persons
    )
    if person:
        return None
    return [KeywordSpan(a, a + len(text[a:b].rstrip()), kind, text[a:b].rstrip()) for (a, b), kind in kinds]


def _ids(step: LabelledStep, scene: Scene, at: tuple[int, int]) -> tuple[str, ...]:
    found = resolve_places(tokens(step.text, *at), scene, Talk())
    return found.ids if isinstance(found, Found) else ()
