"""One thing told by a clause about its rank: "whatever is furthest to the right on the bar", "whichever block is the
largest", put as the noun phrase that it is ("the rightmost object", "the largest block")."""

from __future__ import annotations

import re
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.plainly import instead
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import tokens

__all__ = ["whichever"]

_END = (
    r"(?P<far>furthest|farthest|most|nearest|closest)(?:\s+(?:over|out|across|away))?\s+(?:to\s+|on\s+|at\s+|towards?\s+)?(?:the\s+)?(?:far\s+)?"
    r"(?P<side>left|right|front|back|rear)(?:[\s-]+hand)?(?:\s+(?:side|end))?"
)
_CLAUSE = re.compile(
    r"\b(?P<what>whatever|whichever|what|the\s+(?:one|thing|object|item)\s+(?:that|which))(?:\s+(?:of\s+the\s+)?(?P<noun>[a-z]+(?:\s+[a-z]+)?))??"
    r"(?:['\u2019]s|\s+(?:is|stands|sits|lies|happens\s+to\s+be|comes))\s+(?:standing\s+|sitting\s+|lying\s+)?(?:the\s+)?"
    rf"(?:{_END}|(?P<rank>leftmost|rightmost|frontmost|rearmost|largest|biggest|smallest|tiniest|tallest|shortest|nearest|closest))"
    r"(?:\s+(?P<noun2>one|block|cube|thing|object|item))?(?!\s+(?:of|from|to)\b)\b",
    re.IGNORECASE,
)
_SIDES = {"left": "leftmost", "right": "rightmost", "front": "frontmost", "back": "rearmost", "rear": "rearmost"}


def whichever(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with such a clause as a noun phrase, and the place behind it as where the thing stands, where the step
    says another to which it goes."""
    m = _CLAUSE.search(step.text)
    if m is None:
        return step
    noun = next((n for k in ("noun", "noun2") if (n := m[k]) and n.casefold() != "one"), "")
    words = tokens(noun)
    if any(not scene.word(t, True).text and t.text not in scene.generic(True) for t in words):
        return step
    near = m["far"] is not None and m["far"].casefold() in {"nearest", "closest"}
    rank = m["rank"] or (_SIDES[m["side"].casefold()] if not near else "")
    if not rank:
        return step
    what = noun or ("object" if "object" in scene.generic(True) else "one")
    extent = Extent(*m.span())
    phrase = f"the {rank.casefold()} {what}"
    if len(phrase) > extent.end - extent.start:
        return step
    step = instead(step, extent, phrase, Kind.TARGET)
    spans = tuple(
        replace(s, start=s.start + 4, text=s.text[4:]) if s.start == extent.start and s.label is Kind.TARGET else s
        for s in step.spans
    )
    return _standing(replace(step, spans=spans), extent.end, scene)


def _standing(step: LabelledStep, at: int, scene: Scene) -> LabelledStep:
    """With the place right behind the phrase as where the thing stands, if it goes to another."""
    after = tokens(step.text, at)
    if not after or after[0].text not in {"on", "in", "at", "off", "from"}:
        return step
    goes = [s for s in step.spans if s.label is Kind.DESTINATION and s.start > after[0].end]
    for size in range(min(len(after) - 1, 5), 0, -1):
        found = resolve_places(after[1 : 1 + size], scene, Talk())
        if not isinstance(found, Found) or len(found.ids) != 1 or found.corrected:
            continue
        a, b = after[1].start, after[size].end
        if not any(s.start >= b for s in goes):
            return step
        kept = [s for s in step.spans if s.end <= a or b <= s.start]
        kept.append(KeywordSpan(a, b, Kind.LOCATION, step.text[a:b]))
        return replace(step, spans=tuple(sorted(kept, key=lambda s: s.start)))
    return step
