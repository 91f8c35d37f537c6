"""Headings that a step needs to be understood: "Object 1: sorting area → position 11", "Position 21: pick up object 1
and place it there", "Apple: carry it to the shelf"; and "one box at a time", which names no box.
"""

from __future__ import annotations

import re
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import exactly_named
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["from_to", "headed", "in_turn", "named_by_heading"]

_SHORT = 300
_FROM_TO = re.compile(
    r"^\W*(?P<thing>[^,;:.→>]{2,60}?)\s*:\s*(?:from\s+)?(?P<origin>[^,;:.→>]{2,60}?)\s*(?:->|=>|→|⇒|\bto\b)\s*"
    r"(?P<place>[^,;:.→>]{2,60})[\s.!]*$",
    re.IGNORECASE,
)
_HEADED = re.compile(r"^\W*(?P<place>[^,;:.]{2,40}?)\s*:\s*(?=\w)")
_AT_A_TIME = re.compile(r"\bone\s+(?P<each>\w+)\s+(?:at a time|after (?:the other|another))\b", re.IGNORECASE)


def from_to(step: LabelledStep, scene: Scene) -> LabelledStep | None:
    """A thing, the place where it is, and the place where it is to be; None where a step is not of that form."""
    m = _FROM_TO.match(step.text[:_SHORT])
    if m is None:
        return None
    if any(len(exactly_named(tokens(step.text, *m.span(k)), scene.places)) != 1 for k in ("origin", "place")):
        return None
    kinds = {"thing": Kind.TARGET, "origin": Kind.LOCATION, "place": Kind.DESTINATION}
    return replace(step, spans=tuple(KeywordSpan(*m.span(k), kinds[k], m[k]) for k in kinds), readings=())


def headed(step: LabelledStep, scene: Scene) -> tuple[LabelledStep, str, Extent] | None:
    """A step that is headed by a place and points to it ("there"): without the keywords of the heading, the place, and
    where it is named. None where a step has no such heading."""
    m = _HEADED.match(step.text[:_SHORT])
    if m is None or not any(s.label is Kind.ACTION for s in step.spans):
        return None
    found = exactly_named(tokens(step.text, *m.span("place")), scene.places)
    if len(found) != 1 or not any(lexicon().is_(t.text, "there") for t in tokens(step.text, m.end("place"))):
        return None
    end = m.end("place")
    return (
        replace(step, spans=tuple(s for s in step.spans if s.start >= end)),
        found[0].id,
        Extent(m.start("place"), end),
    )


def in_turn(step: LabelledStep) -> LabelledStep:
    """The step without the keyword in "one box at a time"."""
    gone = [m.span("each") for m in _AT_A_TIME.finditer(step.text)]
    kept = tuple(s for s in step.spans if not any(a < s.end and s.start < b for a, b in gone))
    return replace(step, spans=kept) if gone else step


def named_by_heading(step: LabelledStep) -> LabelledStep:
    """ "Apple: carry it to the shelf": the step without the pronoun right behind the verb, which is what the heading
    names."""
    spans = sorted(step.spans, key=lambda s: s.start)
    if [s.label for s in spans[:3]] != [Kind.TARGET, Kind.ACTION, Kind.TARGET]:
        return step
    head, verb, pronoun = spans[:3]
    pointing = lexicon().is_(pronoun.text.casefold(), "pronouns", "plural_pronouns")
    between = step.text[head.end : verb.start].strip(" *_")
    lead = {t.text for t in tokens(step.text, verb.end, pronoun.start)}
    if between != ":" or not pointing or not lead <= {"both", "all", "each", "of"}:
        return step
    return replace(step, spans=tuple(s for s in step.spans if s is not pronoun))
