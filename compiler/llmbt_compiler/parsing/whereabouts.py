"""Places told by the things on them: "the level that object 3 is on", "the same level as object 1", "where the
newspaper is", "the position where the green block was before"."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import Shape, read_verb, shape_of
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["by_their_things", "in_its_stead", "whose_place"]

_SHORT = 300
_NOUN = (
    r"(?:position|slot|spot|place|location|level|tier|shelf|rack|table|surface|tray|piece\s+of\s+furniture|furniture)"
)
_THING = r"(?P<thing>(?:the\s+|a\s+)?[^,;:.]{1,40}?)"
_ON = r"(?:on|in|at)"
_NOW = r"(?:currently\s+|now\s+)?"
_STANDS = rf"(?:is|are|stands?|sits?|lies|rests?)\s*{_NOW}(?:standing|sitting|lying|resting|located|placed)?"
_STOOD = (
    r"(?:was|were|stood|had\s+been|has\s+been|used\s+to\s+be|came\s+from)"
    r"(?:\s+(?:standing|sitting|lying|located|placed))?"
)
_END = r"(?=\s*(?:[,;.!)]|$|\band\b|\bthen\b))"
_PLACE = rf"\b(?:the\s+)?(?P<noun>{_NOUN})\s+"
_TOLD = tuple(
    re.compile(pattern, re.IGNORECASE)
    for pattern in (
        rf"\bthe\s+same\s+(?P<noun>{_NOUN})\s+(?:as|that)\s+{_THING}(?:\s+(?:is|stands)(?:\s+{_ON})?)?{_END}",
        rf"{_PLACE}(?:that|which|where)?\s*{_THING}\s+{_STANDS}(?:\s+{_ON})?{_END}",
        rf"\bthe\s+(?P<noun>[a-z]+)\s+where\s+{_THING}\s+{_STANDS}(?:\s+{_ON})?{_END}",  # a noun of the map's own
        rf"{_PLACE}{_ON}\s+which\s+{_THING}\s+{_STANDS}{_END}",
        rf"{_PLACE}(?:that\s+is\s+)?(?:occupied|taken)\s+by\s+{_THING}{_END}",
        rf"\bwhere\s+{_THING}\s+{_STANDS}{_END}",
    )
)
_BEFORE = re.compile(
    rf"\b(?:(?:the\s+)?(?P<noun>{_NOUN}|(?<=the\s)[a-z]+(?=\s+where))\s+)?(?:where|that|which)\s+{_THING}\s+{_STOOD}(?:\s+{_ON})?"
    rf"(?:\s+(?:before|originally|initially|earlier|previously|at\s+the\s+(?:start|beginning)))*{_END}",
    re.IGNORECASE,
)
_ONTO = re.compile(r"\b(?:on|onto|to|into|in|at)\s+$", re.IGNORECASE)
_POINTING = ("pronouns", "plural_pronouns")


def _match(text: str, start: int = 0) -> tuple[re.Match[str], bool] | None:
    """The words that tell a place by a thing, and whether by where it was before."""
    was = _BEFORE.search(text, start)
    found = [(m, False) for p in _TOLD if (m := p.search(text, start))] + ([(was, True)] if was else [])
    return min(found, key=lambda f: (f[0].start(), -f[0].end()), default=None)


_FRONTED = re.compile(
    r"(?P<lead>\b(?:and|then)\s+(?:then\s+)?|[,;]\s*)where\s+(?:it|they|that(?:\s+one)?|this)\s+(?:was|stood|sat|lay|used\s+to\s+be|had\s+been|has\s+been)"
    r"(?:\s+(?:before|standing|sitting))?\s*,?\s+(?:(?:you|please|can|could|should|now|I\s+want\s+you\s+to)\s+)*(?P<verb>[a-z]+)\s+(?P<thing>[^,;:.!?]{2,60}?)"
    r"(?=\s*(?:[,;.!?]|$))",
    re.IGNORECASE,
)


def in_its_stead(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Take the red one off the shelf, and where it was you put the yellow one": that goes to the vacated place."""
    m = _FRONTED.search(step.text) if len(step.text) <= _SHORT else None
    acts = [s for s in step.spans if m is not None and s.label is Kind.ACTION and s.end <= m.start()]
    if m is None or not acts:
        return step
    templates = read_verb(m["verb"].casefold(), (), scene.library).templates
    if not any(shape_of(t, scene.library) is Shape.PLACE for t in templates):
        return step
    a, b = m.end("lead"), m.end()
    plain = f"{m['verb']} {m['thing']} in vacated slot"
    plain = plain if len(plain) <= b - a else f"{m['verb']} {m['thing']} vacated slot"
    if len(plain) > b - a:
        return step
    text = step.text[:a] + plain.ljust(b - a) + step.text[b:]
    thing, slot = a + len(m["verb"]) + 1, a + len(plain) - len("vacated slot")
    begin = next((t.start for t in tokens(text, thing, slot) if not lexicon().is_(t.text, "articles")), thing)
    end = thing + len(m["thing"])
    kept = [s for s in step.spans if s.end <= a or b <= s.start]
    kept += [
        KeywordSpan(a, a + len(m["verb"]), Kind.ACTION, m["verb"]),
        KeywordSpan(begin, end, Kind.TARGET, text[begin:end]),
        KeywordSpan(slot, slot + len("vacated slot"), Kind.DESTINATION, "vacated slot"),
    ]
    return replace(step, text=text, spans=tuple(sorted(kept, key=lambda s: s.start)), readings=())


def by_their_things(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with all words that tell a place by a thing as one destination, where a preposition is before them."""
    if len(step.text) > _SHORT or not any(s.label is Kind.ACTION for s in step.spans):
        return step
    hit = _match(step.text)
    if hit is None:
        return step
    m, _ = hit
    lead = _ONTO.search(step.text[: m.start()])
    parts = tokens(step.text, *m.span("thing"))
    pointing = all(lexicon().is_(t.text, *_POINTING) for t in parts)
    behind = m[0].startswith("where") and _right_behind_a_target(
        step, m.start()
    )  # "put the banana where the apple was"
    if (
        (lead is None and not behind)
        or pointing
        or any(s.label is Kind.ACTION and m.start() <= s.start < m.end() for s in step.spans)
    ):
        return step
    if not any(t.text in scene.vocabulary(True) or t.text in scene.generic(True) for t in parts):
        return step
    kept = [s for s in step.spans if s.end <= m.start() or m.end() <= s.start]
    kept.append(KeywordSpan(m.start(), m.end(), Kind.DESTINATION, m[0]))
    return replace(step, spans=tuple(sorted(kept, key=lambda s: s.start)))


def _right_behind_a_target(step: LabelledStep, at: int) -> bool:
    before = max((s for s in step.spans if s.end <= at), key=lambda s: s.end, default=None)
    return before is not None and before.label is Kind.TARGET and not step.text[before.end : at].strip()


def whose_place(words: Sequence[Token], text: str) -> tuple[tuple[Token, ...], tuple[Token, ...], bool] | None:
    """Of a phrase that tells a place by a thing: the noun for the place, the thing, and whether it is where the thing
    was before."""
    start, end = words[0].start, words[-1].end
    hit = _match(text[:end], start)
    if hit is None or hit[0].end() != end:
        return None
    m, before = hit
    noun = m.groupdict().get("noun")
    return (tokens(text, *m.span("noun")) if noun else ()), tokens(text, *m.span("thing")), before
