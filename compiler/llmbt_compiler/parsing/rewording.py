"""Words that say a plain thing in a way of their own, put plainly: ", i.e. crate C," as a parenthesis, "the slot that
this leaves empty" as the vacated slot, "on second thought" as nothing. Every offset stays."""

from __future__ import annotations

import re
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.explained import without
from llmbt_compiler.parsing.model import Extent, LabelledStep

__all__ = ["reworded"]

_SLOT = r"(?:slot|position|place|spot|location)"
_IDLE = re.compile(
    r"\bon\s+(?:second\s+thoughts?|reflection|the\s+(?:one|other)\s+hand)\b"
    r"|\b(?:in\s+addition(?!\s+to)|in\s+the\s+(?:meantime|end|process)|in\s+(?:doing\s+so|short|summary|total|particular)"
    r"|at\s+the\s+same\s+time|at\s+(?:once|last)|for\s+(?:now|a\s+start|good\s+measure|the\s+(?:moment|time\s+being))"
    r"|to\s+(?:begin|start)\s+with|to\s+finish(?:\s+(?:up|off))?(?=,)|by\s+the\s+way|of\s+course|as\s+a\s+(?:last|final|first|next)\s+step"
    r"|after\s+all|come\s+to\s+think\s+of\s+it)\b"
    r"|,?\s+one\s+(?:per|(?:in|on|to|at|into|for)\s+(?:each|every))\s+(?:of\s+the\s+)?(?:free\s+|empty\s+)?"
    rf"{_SLOT}s?\b|,?\s+one\s+(?:each|after\s+(?:the\s+other|another)|by\s+one|at\s+a\s+time)(?=\s*[,.;!]|\s*$)"
    r"|,?\s+(?:using|with)\s+(?:the\s+)?[\w\s]{2,30}?\s+(?:as|for)\s+(?:a\s+|an\s+)?(?:temporary|intermediate|interim|buffer)\b"
    r"(?:\s+\w+){0,2}?(?:\s+if\s+(?:needed|necessary|required|need\s+be))?(?=\s*[,.;!]|\s*$)"
    r"|,?\s*\bfilling\s+(?:it|them)\s+(?:up\s+)?(?:starting\s+)?(?:from|with|at)\s+(?:its|the|their)\s+(?:first|lowest|left)\b[^,;.]{0,25}"
    r"|\blet\s+(?:me|us|the\s+(?:user|operator))\s+know\b(?:\s+(?:when|once|if|that|as\s+soon\s+as|about)\b[^,;.]*)?"
    r"|\bstand(?:ing)?\s+by\b(?:\s+for\b[^,;.]*)?"
    r"|\bwhat\s+(?:he|she|I|they|the\s+user)\s+(?:ordered|wants?|wanted|would\s+like|asked\s+for|needs?|is\s+after)\s+"
    r"(?:is|was|are|were)\s+(?=[^:.;]*:)"
    r"|\bfor\s+the\s+(?:next|new|coming|upcoming|incoming|following)\s+(?:delivery|arrival|shipment|batch|load|round|job|order|task)\b"
    r"|(?<=\w)\s+if\s+(?:needed|necessary|required|need\s+be|applicable|desired)(?=\s*[.;!]|\s*$)",
    re.IGNORECASE,
)
"""Says nothing about what goes where."""
_OF_ALL = re.compile(
    r"(?:(?<=est)|(?<=est\sone)|(?<=est\scube)|(?<=est\sblock))\s+(?:(?:out\s+)?of\s+(?:them\s+all|the\s+(?:whole\s+|entire\s+)?(?:lot|bunch)|all(?:\s+of\s+them)?)"
    r"|(?:that\s+)?(?:we|you|I)(?:['\u2019]ve|\s+have)(?:\s+got)?)\b(?=\s*(?:[,:;.!?>-]|$|and\b|on\b|to\b|in\b|goes\b|should\b))",
    re.IGNORECASE,
)
"""Behind a superlative: of all there are."""
_TELEGRAM = re.compile(r"\bSTOP\b(?=\s+[A-Z]{2}|\s*$)")
_NAMELY = re.compile(
    r"(?P<lead>,?\s*(?:i\s?\.\s?e\s?\.|that\s+is\s+to\s+say|that\s+is(?=,)|namely|viz\.?|aka|a\.k\.a\.|in\s+other\s+words|meaning(?=[,:]))[,:]?)\s+"
    r"(?P<what>[^,;.()]{2,40}?)(?P<end>,|(?=\s*[.;!]|\s*$))",
    re.IGNORECASE,
)
_LEFT = re.compile(
    rf"\b(?:the\s+)?(?:now\s+)?(?P<noun>{_SLOT})\s+(?:that|which)?\s*(?:it|this|that|he|she|they|object\s+\d|\w+\s+\w)?\s*"
    r"(?:has|have|had|is|was)?\s*(?:just|now|thereby|thus)?\s*(?:been\s+)?"
    r"(?:freed|vacated|emptied|(?:left|leaves|leave|becomes?|became)(?:\s+(?:free|empty|open|vacant|behind))(?:\s+behind)?)"
    r"(?:\s+(?:by\s+(?:it|this|that)|up|in\s+this\s+way|that\s+way))?(?=\s*[,.;!]|\s*$|\s+with\b|\s+by\b)"
    rf"|\bthe\s+(?P<just>{_SLOT})\s+(?:(?:that\s+|which\s+)?(?:it|this|that|he|she|they)\s+(?:has|have)\s+(?:just\s+|now\s+)?(?:left|vacated)"
    r"|(?:thus|thereby|just|so)\s+(?:vacated|freed|emptied))\b(?!\s+(?:there|it|them)\b)",
    re.IGNORECASE,
)


def reworded(step: LabelledStep) -> LabelledStep:
    """The step in plain words, with as many characters."""
    step = _either(_all_but(_that_one(_plain_codes(_its_surface(step)))))
    step = _go_and_wait(_silent(_to_its_place(_coloured(step))))
    return _vacant(_vacated(_in_parentheses(_seen_to(_resting(_closed_around(step))))))


_CLOSED_AROUND = re.compile(
    r"\b(?P<close>close|shut|tighten)\s+(?:the\s+|its\s+|your\s+)?(?:gripper|hand|fingers?|jaws?|claws?|grip)\s+"
    r"(?:firmly\s+|gently\s+)?(?:around|about|on|over|onto)\s+(?=\S)",
    re.IGNORECASE,
)


def _closed_around(step: LabelledStep) -> LabelledStep:
    """ "Close the gripper around it": grasp it."""
    m = _CLOSED_AROUND.search(step.text)
    if m is None:
        return step
    a, b = m.span()
    text = step.text[:a] + "grasp".ljust(b - a) + step.text[b:]
    kept = [s for s in step.spans if s.end <= a or b <= s.start]
    what = next((s for s in kept if s.start >= b), None)
    if what is None or what.label is Kind.ACTION:
        return step
    kept = [replace(s, label=Kind.TARGET) if s is what else s for s in kept]
    kept.append(KeywordSpan(a, a + 5, Kind.ACTION, "grasp"))
    return replace(step, text=text, spans=tuple(sorted(kept, key=lambda s: s.start)), readings=())


_RESTING = re.compile(
    r",?\s+(?:so|such)\s+that\s+(?:it|they)\s+(?:(?:then|will|can|finally|eventually)\s+)*(?:comes?\s+to\s+(?:rest|stand|lie)"
    r"|(?:rest|sit|stand|lie|land|end)s?(?:\s+up)?|(?:is|are)(?:\s+(?:placed|standing|sitting|lying|resting))?)\s+"
    r"(?=(?:on|onto|upon|in|at|inside|within)\s)",
    re.IGNORECASE,
)


_LED_TO = re.compile(r"\b(?:on|onto|upon|in|into|to|at|inside)\s+(?:the\s+|a\s+|an\s+|its\s+)?$", re.IGNORECASE)


def _resting(step: LabelledStep) -> LabelledStep:
    """ "Move it so that it comes to rest on the shelf": on the shelf, where no other place is said."""
    m = _RESTING.search(step.text)
    before = [s for s in step.spans if m is not None and s.label is Kind.DESTINATION and s.end <= m.start()]
    if m is None or any(_LED_TO.search(step.text, 0, s.start) for s in before):
        return step
    lead = max((s.start for s in step.spans if s.label is Kind.ACTION and s.end <= m.start()), default=None)
    after = next((s for s in step.spans if s.start >= m.end()), None)
    step = without(step, Extent(*m.span()))
    if lead is None or after is None or after.label is Kind.ACTION:
        return step
    return replace(step, spans=tuple(replace(s, label=Kind.DESTINATION) if s == after else s for s in step.spans))


_SURFACE = re.compile(
    r"\b(?:the\s+)?(?:(?:top|upper|flat|free)\s+)?(?:surface|tabletop|worktop)\s+of\s+(?=(?:the|our|my|your)\b)",
    re.IGNORECASE,
)
_BOLD_CODE = re.compile(r"\b[a-z]+\s+(?P<open>\*\*|__|`)(?=[A-Z]?\d{1,3}\b|[A-Z]\b)[A-Z]?\d{0,3}(?P<close>\*\*|__|`)")
_THAT_ONE = re.compile(
    r"^\W*(?:(?:do\s+you|can\s+you|you)\s+)?(?:see|know|spot|remember)\s+[^,;:.?!]{2,40}[?.!]\s+(?:[a-z]+\s+){1,3}?(?P<one>th(?:at|is)\s+one)\b",
    re.IGNORECASE,
)


def _its_surface(step: LabelledStep) -> LabelledStep:
    """ "Upon the surface of the table" is on the table."""
    m = _SURFACE.search(step.text)
    if m is None:
        return step
    a, b = m.span()
    text = step.text[:a] + " " * (b - a) + step.text[b:]
    spans = tuple(
        replace(s, start=b, text=text[b : s.end]) if a <= s.start < b < s.end else s
        for s in step.spans
        if not (a <= s.start and s.end <= b)
    )
    return replace(step, text=text, spans=spans, readings=())


def _plain_codes(step: LabelledStep) -> LabelledStep:
    """ "Slot **A2**" without the marks between the noun and its code."""
    text = step.text
    for m in _BOLD_CODE.finditer(text):
        for key in ("open", "close"):
            a, b = m.span(key)
            text = text[:a] + " " * (b - a) + text[b:]
    return replace(step, text=text) if text != step.text else step


def _that_one(step: LabelledStep) -> LabelledStep:
    """ "See the apple? Put that one on the bar": the thing that was just pointed out."""
    m = _THAT_ONE.match(step.text)
    if m is None:
        return step
    a, b = m.span("one")
    text = step.text[:a] + "it".ljust(b - a) + step.text[b:]
    kept = tuple(s for s in step.spans if s.end <= a or b <= s.start)
    spans = tuple(sorted((*kept, KeywordSpan(a, a + 2, Kind.TARGET, "it")), key=lambda s: s.start))
    return replace(step, text=text, spans=spans, readings=())


_ALL_BUT = re.compile(
    r"(?<=,)(?P<lead>\s*)(?:(?:all|everything|each\s+one)\s+(?:of\s+them\s+)?(?:but|except(?:\s+for)?|save(?:\s+for)?|bar|apart\s+from)"
    r"|(?:just|only)\s+not)(?=\s+(?:the|that|this|those|object|block|number|\d))",
    re.IGNORECASE,
)


def _all_but(step: LabelledStep) -> LabelledStep:
    """ "The green ones go on level 2, all but object 4": except object 4."""
    m = _ALL_BUT.search(step.text)
    if m is None:
        return step
    a, b = m.end("lead"), m.end()
    text = step.text[:a] + "except".ljust(b - a) + step.text[b:]
    kept = tuple(s for s in step.spans if s.end <= a or b <= s.start)
    return replace(step, text=text, spans=kept, readings=())


_EITHER = re.compile(
    r"\b(?:(?P<either>either)\s+)?(?P<one>(?:(?:the|a|an|my)\s+)?[a-z0-9]+(?:\s+[a-z0-9]+)?)\s+or\s+(?P<other>(?:(?:the|a|an|my)\s+)?[a-z0-9]+(?:\s+\d+)?)\b",
    re.IGNORECASE,
)
_PERMITTED = re.compile(
    r"\b(?:you\s+(?:choose|decide|pick)|your\s+(?:choice|call|pick)|either\s+(?:one\s+)?(?:is\s+(?:fine|ok|okay|good)|will\s+do|works)|whichever\s+(?:one\s+)?(?:you\b|suits|is\s+(?:handier|easier|easiest|fine|more\s+convenient)\b)"
    r"|I\s+don['\u2019]t\s+(?:mind|care)\s+which|up\s+to\s+you|just\s+one\b)[^;.!?]*",
    re.IGNORECASE,
)


def _either(step: LabelledStep) -> LabelledStep:
    """ "Either the apple or the bread, you choose": where the choice is left, the first of the two."""
    free = _PERMITTED.search(step.text)
    m = _EITHER.search(step.text) if free is not None else None
    if m is None or free is None or m.end() > free.start() > m.start():
        return step
    touched = [s for s in step.spans if s.start < m.end("other") and m.start("other") <= s.start]
    own = [s for s in step.spans if m.start("one") <= s.start < m.end("one")]
    if len(touched) != 1 or len(own) != 1 or touched[0].label is not own[0].label or own[0].label is Kind.ACTION:
        return step
    step = without(step, Extent(m.end("one"), m.end("other")))
    step = without(step, Extent(*m.span("either"))) if m["either"] else step
    again = _PERMITTED.search(step.text)
    return without(step, Extent(*again.span())) if again is not None else step


def _silent(step: LabelledStep) -> LabelledStep:
    for pattern in (_IDLE, _OF_ALL, _TELEGRAM):
        while (m := pattern.search(step.text)) is not None:
            trimmed = tuple(_shortened(s, m.start()) for s in step.spans)
            step = without(replace(step, spans=trimmed), Extent(*m.span()))
    return step


def _shortened(span: KeywordSpan, end: int) -> KeywordSpan:
    """A keyword up to where silent words begin in it."""
    if not span.start < end < span.end:
        return span
    text = span.text[: end - span.start].rstrip()
    return replace(span, end=span.start + len(text), text=text)


def _in_parentheses(step: LabelledStep) -> LabelledStep:
    """ "The metal box, i.e. crate C, ..." as "the metal box (crate C) ...", where something is named before."""
    m = _NAMELY.search(step.text)
    if m is None or not any(s.end == m.start() for s in step.spans):
        return step
    a, b = m.span()
    told = f"({m['what'].rstrip()})"
    if b - a < len(told) + 1:
        return step
    kept = tuple(s for s in step.spans if s.end <= a or b <= s.start)
    text = step.text[:a] + told.rjust(b - a) + step.text[b:]
    return replace(step, text=text, spans=kept, readings=())


def _vacated(step: LabelledStep) -> LabelledStep:
    """ "The slot that this has freed" as "the vacated slot"."""
    m = _LEFT.search(step.text)
    if m is None:
        return step
    plain = f"vacated {m['noun'] or m['just']}"
    a, b = m.span()
    if b - a < len(plain):
        return step
    touched = [s for s in step.spans if s.start < b and a < s.end]
    label = Kind.TARGET if any(s.label is Kind.TARGET for s in touched) else Kind.DESTINATION
    text = step.text[:a] + plain.ljust(b - a) + step.text[b:]
    kept = [s for s in step.spans if s not in touched]
    kept.append(KeywordSpan(a, a + len(plain), label, plain))
    return replace(step, text=text, spans=tuple(sorted(kept, key=lambda s: s.start)), readings=())


_COLOURED = re.compile(r"(?<=\bexcept\s)(?:for\s+)?what\s+is\s+(?P<colour>[a-z]+)(?=\s)", re.IGNORECASE)


def _coloured(step: LabelledStep) -> LabelledStep:
    """ "Everything except what is green" leaves out the green ones."""
    m = _COLOURED.search(step.text)
    if m is None or any(s.label is Kind.ACTION and s.start < m.end() and m.start() < s.end for s in step.spans):
        return step
    a, b = m.span()
    return replace(step, text=step.text[:a] + f"{m['colour']} ones".ljust(b - a) + step.text[b:])


_ITS_PLACE = re.compile(
    r"(?:(?<=\breturn\sit\s)|(?<=\bback\s))(?:to|in|into|on|onto)\s+its\s+(?:own\s+|usual\s+|proper\s+)?"
    r"(?:place|spot|slot|position)(?=\s*[.,;!]|\s*$)",
    re.IGNORECASE,
)


def _to_its_place(step: LabelledStep) -> LabelledStep:
    """ "Return it to its place", "put it back in its slot": back."""
    m = _ITS_PLACE.search(step.text)
    if m is None:
        return step
    a, b = m.span()
    step = without(step, Extent(a, b))
    return replace(step, text=step.text[:a] + "back".ljust(b - a) + step.text[b:])


_SEEN_TO = re.compile(
    r"\b(?P<see>(?:see(?:\s+to\s+it)?|make\s+sure|ensure)\s+)that\s+(?:he|she|the\s+\w+)\s+(?:gets|receives|is\s+given)\b",
    re.IGNORECASE,
)


def _seen_to(step: LabelledStep) -> LabelledStep:
    """ "See that he gets them": what is to be seen to is the order."""
    m = _SEEN_TO.search(step.text)
    return without(step, Extent(*m.span("see"))) if m is not None else step


_VACANT = re.compile(
    rf"(?:the|a|any)\s+(?:(?:first|next|lowest|lowest-numbered)\s+)?{_SLOT}(?P<inner>\s+(?:of|in|on)\s+(?:the\s+)?\w+(?:\s+\w+)?)?\s+"
    r"(?:(?:that|which)(?:['\u2019]s|\s+(?:is|are))\s+(?:still\s+|currently\s+)?(?:free|empty|available|vacant|unoccupied|not\s+taken)"
    r"|(?:that\s+)?(?:nobody|no[\s-]?one|nothing)\s+(?:has|uses|occupies|is\s+(?:on|in|using)|stands\s+(?:on|in))(?:\s+yet)?)\b",
    re.IGNORECASE,
)
_WAITING = re.compile(
    r"\b(?P<going>go(?:\s+over|\s+back)?|head|drive|walk)\s+(?:and\s+)?(?P<wait>wait|stay|stand\s+by|stop|remain|park)\s+"
    r"(?:there\s+)?(?=(?:at|by|in|on|near)\s)",
    re.IGNORECASE,
)


def _vacant(step: LabelledStep) -> LabelledStep:
    """ "The first slot that is free" as "a free slot": which is the first does not depend on those that are taken."""
    m = _VACANT.search(step.text)
    if m is None:
        return step
    a, b = m.span()
    plain = f"a free slot{m['inner'] or ''}"
    touched = [s for s in step.spans if s.start < b and a < s.end]
    if b - a < len(plain) or any(s.label is Kind.ACTION or s.start < a or b < s.end for s in touched):
        return step
    label = touched[0].label if touched else Kind.DESTINATION
    kept = [s for s in step.spans if s not in touched]
    kept.append(KeywordSpan(a, a + len(plain), label, plain))
    text = step.text[:a] + plain.ljust(b - a) + step.text[b:]
    return replace(step, text=text, spans=tuple(sorted(kept, key=lambda s: s.start)), readings=())


def _go_and_wait(step: LabelledStep) -> LabelledStep:
    """ "Go and wait at the desk" goes there."""
    m = _WAITING.search(step.text)
    if m is None or not any(s.label is Kind.ACTION and s.start == m.start() for s in step.spans):
        return step
    after = next((s for s in step.spans if s.start >= m.end()), None)
    step = without(step, Extent(m.end("going"), m.end()))
    if after is None or after.label is not Kind.LOCATION:
        return step
    return replace(step, spans=tuple(replace(s, label=Kind.DESTINATION) if s == after else s for s in step.spans))
