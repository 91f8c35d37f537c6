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
    r"|(?<=\w)\s+if\s+(?:needed|necessary|required|need\s+be|applicable|desired)(?=\s*[.;!]|\s*$)",
    re.IGNORECASE,
)
"""Says nothing about what goes where."""
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
    r"(?:\s+(?:by\s+(?:it|this|that)|up|in\s+this\s+way|that\s+way))?(?=\s*[,.;!]|\s*$|\s+with\b|\s+by\b)",
    re.IGNORECASE,
)


def reworded(step: LabelledStep) -> LabelledStep:
    """The step in plain words, with as many characters."""
    step = _silent(step)
    return _vacated(_in_parentheses(step))


def _silent(step: LabelledStep) -> LabelledStep:
    for pattern in (_IDLE, _TELEGRAM):
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
    plain = f"vacated {m['noun']}"
    a, b = m.span()
    if b - a < len(plain):
        return step
    touched = [s for s in step.spans if s.start < b and a < s.end]
    label = Kind.TARGET if any(s.label is Kind.TARGET for s in touched) else Kind.DESTINATION
    text = step.text[:a] + plain.ljust(b - a) + step.text[b:]
    kept = [s for s in step.spans if s not in touched]
    kept.append(KeywordSpan(a, a + len(plain), label, plain))
    return replace(step, text=text, spans=tuple(sorted(kept, key=lambda s: s.start)), readings=())
