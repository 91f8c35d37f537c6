"""Words that say nothing: courtesy that looks like a condition ("if it's not too much trouble", "when you have a
moment"), "next to nothing", sayings ("let me know when you are done"), telegrams ("STOP")."""

from __future__ import annotations

import re
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.explained import without
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.words import lemmas, lexicon

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


_UNREAL = re.compile(
    r"^\W*(?:had|were)\s+(?:I|we|he|she|it|they|there|the)\b[^.;!]*\bwould(?:n['\u2019]t|\s+not)?\b[^.;!]*[.!]?\s*$"
    r"|^[^.;!]*\bwould(?:n['\u2019]t|\s+not)?\s[^.;!]*\b(?:were\s+it\s+not|had\s+it\s+not)\b[^.;!]*[.!]?\s*$"
    r"|^\W*(?:who|why|when|how)\b(?!\s+(?:about|ever|not)\b)[^.;:!]*\?\s*$",
    re.IGNORECASE,
)
"""Tells of what is not so, or asks for what one knows: no order, whatever it names."""


_ON = r"(?:(?!\s+(?:and|then|but)\b)[^,;.:!?])*"
_SAYING = re.compile(
    rf"\b(?:(?:please\s+)?let\s+(?:me|us|him|her|them|the\s+\w+)\s+know\b{_ON}"
    rf"|keep\s+(?:me|us|him|her|them)\s+(?:posted|informed|updated|in\s+the\s+loop)\b{_ON}"
    r"|bear\s+with\s+(?:me|us)|take\s+your\s+time|call\s+it\s+a\s+day|have\s+a\s+(?:rest|break)"
    rf"|make\s+a\s+(?:mental\s+)?note\b{_ON}|do(?=\s+(?:put|place|bring|take|move|set|fetch|get)\b)"
    r"|(?:close|complete|finish|conclude|end)\s+(?:the|this|your)\s+(?:task|job|order|ticket|cycle|run|procedure|mission)\b"
    r"|quick(?:ly)?(?:,\s*quick(?:ly)?)*\s*[,!:](?=\s*\w)|job\s+done)"
    r"|\b(?:FYI|NB|N\.B\.|PS|P\.S\.)\s*[,:]?(?=\s)",
    re.IGNORECASE,
)
"""Said in passing, or to somebody: it asks for nothing that changes the scene."""
_SO_THAT = re.compile(
    r",?\s+so\s+(?:that\s+)?(?!(?:it|they|that|this|put|place|move|bring|take|set)\b)"
    r"(?:[a-z][\w'\u2019-]*\s+){1,5}(?:can|could|may|might|will|would|does|do)(?:n['\u2019]t|\s+not)?\s+"
    r"(?!(?:go|stand|sit|lie|end|rest|come)\b)(?:(?!\b(?:on|onto|to|into|in|at|and|then|from)\b)[^,;.:!?\d]){2,50}?(?=\s*[.;!,]|\s*$)",
    re.IGNORECASE,
)
"""What something is done for ("so that a new spring can be fitted later"): no order, and names no place."""
_STAYING = re.compile(
    r"^\W*(?:(?:please|just|and|but|then|also|finally|simply)\s+)*(?P<leave>leave)\s+(?P<thing>[^,;.:!?]{2,60}?)\s+"
    r"(?:(?:exactly|right|just|safely)\s+)?(?:(?:where|as)\s+(?:it|they|he|she)(?:\s+(?:currently\s+|already\s+)?"
    r"(?:is|are|stands?|sits?|lies?|was|were)|['\u2019](?:s|re))(?:\s+(?:now|for\s+now|at\s+the\s+moment))?"
    r"|alone|untouched|undisturbed|in\s+peace|in\s+place)[\s.!]*$",
    re.IGNORECASE,
)
_STOP = re.compile(r"(?<=[\w)])\s+(STOP)\b(?=\s*(?:$|[A-Z.,;!]))")
_BY_CAMERA = re.compile(
    r"\W*(?:please\s+)?(?P<verb>\w+)\s+(?P<means>(?:by|via|using|with|through)\s+(?:the\s+|your\s+)?(?:wrist\s+)?"
    r"(?:camera|sensors?|vision|image)\b)",
    re.IGNORECASE,
)


def outspoken(step: LabelledStep) -> LabelledStep:
    """The step without words that say nothing, its condition with an "if" ("should it fall, ..."); offsets stay."""
    m = _SHOULD.match(step.text)
    if m is not None:
        a, b = m.span(1)
        step = replace(step, text=f"{step.text[:a]}{'if':<{b - a}}{step.text[b:]}")
    if _UNREAL.search(step.text):
        return replace(step, spans=(), readings=())
    m = _STAYING.match(step.text)
    if m is not None:
        ends = (("leave", Kind.ACTION), ("thing", Kind.TARGET))
        return replace(step, spans=tuple(KeywordSpan(*m.span(k), kind, m[k]) for k, kind in ends), readings=())
    for pattern in (_POLITE, _SAYING, _SO_THAT):
        m = pattern.search(step.text)
        step = without(step, Extent(*m.span())) if m is not None else step
    return _telegram(_by_camera(step))


def _by_camera(step: LabelledStep) -> LabelledStep:
    """ "Confirm by camera that ...": with what it is seen is left out, and what looks is the verb."""
    m = _BY_CAMERA.match(step.text)
    if m is None or not lexicon().verbs["checking"].intersection(lemmas(m["verb"].casefold())):
        return step
    step = without(step, Extent(*m.span("means")))
    if any(s.start < m.end("verb") for s in step.spans):
        return step
    return replace(step, spans=(KeywordSpan(*m.span("verb"), Kind.ACTION, m["verb"]), *step.spans))


def _telegram(step: LabelledStep) -> LabelledStep:
    """ "PARCEL 17 TO SLOT A3 STOP" ends there, as with a full stop."""
    for m in _STOP.finditer(step.text):
        a, b = m.span(1)
        cut = tuple(
            replace(s, end=m.start(), text=step.text[s.start : m.start()]) if s.start < a < s.end else s
            for s in step.spans
            if not a <= s.start < b
        )
        step = replace(step, text=f"{step.text[:a]}.{' ' * (b - a - 1)}{step.text[b:]}", spans=cut, readings=())
    return step
