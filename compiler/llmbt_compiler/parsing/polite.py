"""Words that say nothing: courtesy that looks like a condition ("if it's not too much trouble", "when you have a
moment"), "next to nothing"."""

from __future__ import annotations

import re
from dataclasses import replace

from llmbt_compiler.parsing.explained import without
from llmbt_compiler.parsing.model import Extent, LabelledStep

__all__ = ["outspoken"]

_BE = r"(?:(?:is|was|['’]s)(?:\s+not|n['’]t)?|(?:would|wo)n?['’]?t?\s+(?:not\s+)?be)"
_ENDS = r"(?=\s*(?:[,.;!]|$))"
_POLITE = re.compile(
    r"\bnext\s+to\s+nothing(?:\s+else)?(?:\s+in\s+particular)?\b"
    r"|\bif\s+(?:it|that|this)\b[^,;.!]{0,30}?\b(?:trouble|bother|hassle|inconvenience|much\s+to\s+ask)\b(?:\s+(?:for|to)\s+you)?"
    r"|\bif\s+(?:it|that|this)(?:\s+is|['’]s)\s+(?:ok|okay|fine|alright|all\s+right|convenient|possible)\b(?:\s+(?:with|for|by)\s+you)?"
    r"|\bif\s+you\s+(?:(?:do|would)(?:n['’]?t|\s+not)\s+mind|can|could|may|will|would|like|wish)" + _ENDS + r"|"
    r"\bif\s+(?:I|we)\s+(?:may|might|could)(?:\s+ask)?" + _ENDS + r"|"
    r"\b(?:if|when|whenever|once|as\s+soon\s+as)\s+you\s*(?:['’]ve|have)?\s*(?:have|get|find|got)\s+(?:a|the|some)\s+"
    r"(?:spare\s+|free\s+)?(?:moment|minute|second|sec|chance|time)\b"
    r"|\b(?:if|when|whenever)\s+you(?:['’]re|\s+are)\s+(?:ready|free|able)" + _ENDS,
    re.IGNORECASE,
)


_SHOULD = re.compile(r"^\W*(should)\s+(?!I\b|we\b)[^,;.!?]{2,60},", re.IGNORECASE)
"""A condition without an "if"."""


def outspoken(step: LabelledStep) -> LabelledStep:
    """The step without words that say nothing, its condition with an "if" ("should it fall, ..."); offsets stay."""
    m = _SHOULD.match(step.text)
    if m is not None:
        a, b = m.span(1)
        step = replace(step, text=f"{step.text[:a]}{'if':<{b - a}}{step.text[b:]}")
    m = _POLITE.search(step.text)
    return without(step, Extent(*m.span())) if m is not None else step
