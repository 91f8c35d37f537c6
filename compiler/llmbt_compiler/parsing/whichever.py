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
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["emptied", "narrowed", "whichever"]

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


_WITHIN = re.compile(
    r"\b(?P<on>on|onto|to|in|into)\s+(?P<outer>(?:the\s+)?[a-z0-9 _]{3,30}?)\s*,"
    r"\s*(?:and\s+there\s+|there\s+)?(?:right\s+)?"
    r"(?:in|on|at|into|onto)\s+the\s+"
    r"(?P<free>free\s+|empty\s+|vacant\s+)?(?P<rank>[a-z]+|\d(?:st|nd|rd|th))\s+(?P<free2>free\s+|empty\s+|vacant\s+)?(?P<noun>slot|position|spot|place)"
    r"(?P<free3>\s+(?:(?:that|which)\s+)?(?:(?:nobody|no[\s-]?one|nothing)\s+"
    r"(?:has|uses|is\s+(?:on|in|using)|stands\s+(?:on|in))(?:\s+yet)?"
    r"|(?:['\u2019]s|is)\s+(?:still\s+)?(?:free|empty|vacant|available|not\s+taken)))?(?=\s*(?:[,.;!?]|$))",
    re.IGNORECASE,
)


def narrowed(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "On level 2, in the middle spot that nobody has yet": the free middle spot on level 2."""
    m = _WITHIN.search(step.text)
    found = resolve_places(tokens(step.text, *m.span("outer")), scene, Talk()) if m is not None else None
    if m is None or not isinstance(found, Found) or len(found.ids) != 1 or found.corrected or found.vague:
        return step
    if m["rank"].casefold() in lexicon().ordinals and not (m["free"] or m["free2"] or m["free3"]):
        return step  # the third of a row is understood as it stands
    outer = m["outer"].strip()
    free = "free " if m["free"] or m["free2"] or m["free3"] else ""
    phrase = f"{free}{m['rank']} {m['noun']} of {outer}"
    lead, extent = len(m["on"]) + 1, Extent(*m.span())
    if found.ids[0] in {"*", "<"} or len(phrase) + lead > extent.end - extent.start:
        return step
    return instead(step, Extent(extent.start + lead, extent.end), phrase, Kind.DESTINATION)


_WHOLE = re.compile(
    r"^(?P<lead>[^.;:!?]{3,80}?[,;]\s*(?:would\s+you\s*,\s*)?(?:(?:and|so)\s+)?)"
    r"(?P<all>(?:everything|whatever|anything|all)\s+(?:that\s+|you\s+find\s+)?(?:(?:is|stands|sits|lies)\s+|['\u2019]s\s+)?(?:(?:still|now|currently|standing|lying)\s+)*"
    r"(?:(?:on|in)\s+it|there))\s+(?=(?:goes|go|should|must|has|is\s+to)\b|(?:back\s+)?(?:on)?to\s)",
    re.IGNORECASE,
)
_BARE = re.compile(r"\b(?:clear|empty|free|bare|cleared|emptied|freed)\b", re.IGNORECASE)


def emptied(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Empty the shelf, everything on it goes to the sorting area": where the things go is all that is asked for."""
    m = _WHOLE.match(step.text)
    if m is None or _BARE.search(m["lead"]) is None:
        return step
    line = tokens(m["lead"])
    named: set[str] = set()
    for size in (2, 1):
        for i in range(len(line) - size + 1):
            found = resolve_places(line[i : i + size], scene, Talk())
            plain = all(t.word or t.number is not None for t in line[i : i + size]) and line[i].text not in {"the", "a"}
            if plain and not named and isinstance(found, Found) and len(found.ids) == 1 and not found.corrected:
                named.add(found.ids[0])
    if len(named) != 1 or (place := named.pop()) not in {e.id for e in scene.places} or scene.single(place):
        return step
    name = min(place, next((p.name for p in scene.map.places if p.id == place), "") or place, key=len)
    plain_text, extent = f"all on {name}", Extent(0, m.end("all"))
    if len(plain_text) > extent.end:
        return step
    step = instead(step, extent, plain_text, Kind.TARGET)
    whole = next((s for s in step.spans if s.start >= m.end()), None)
    return replace(step, spans=tuple(s for s in step.spans if s is not whole or s.label is not Kind.TARGET))
