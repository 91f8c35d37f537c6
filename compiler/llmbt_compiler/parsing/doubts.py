"""What takes an order back, or gives it to somebody else: "but do not do it", "or leave it", "unless she says no", "ask
Tom to put ...", "Tom has put ...", "the red cup, no, the blue cup"."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from llmbt_compiler.parsing.explained import without
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["corrects", "doubts", "put_right"]

_SHORT = 300
_RETRACTED = re.compile(
    r"\b(?:but|or|and|though)\s+(?:please\s+)?(?:do\s+not|don['’]?t|never)(?:\s+(?:actually|really|yet))?"
    r"(?:\s+do)?(?:\s+(?:it|so|that|this|anything))?(?:\s+(?:yet|now|really))?(?=\s*[.,;!]|\s*$)"
    r"|\bor\s+(?:else\s+)?(?:just\s+)?(?:leave|keep|forget|skip)\s+(?:it|them|that)\b[^,;.]*"
    r"|\bunless\s+(?:you|I|we|he|she|some(?:body|one)|any(?:body|one))\b(?!['’]?(?:re|\s+are)\s+(?:sure|unable))[^,;.]*"
    r"|\bor\s+(?:else\s+)?(?:maybe|perhaps|possibly|was|is|does|did|do|might|could|should|the\s+other\s+way)\b(?!\s+to\b)[^;.]*"
    r"|\b(?:check|confirm|clear\s+it|verify)\s+(?:\w+\s+){0,2}?with\s+(?:me|us)\b[^,;.]*|\bask\s+(?:me|us)\s+(?:first|which|what|where|before)\b[^,;.]*"
    r"|\b(?:it|they|that|which)\s+(?:must\s*n['’]?t|must\s+(?:not|never)|never|can(?:not|['’]t)|may\s+not|is\s+not\s+to|should\s*(?:n['’]t|\s+not|\s+never))"
    r"\s+(?:ever\s+)?(?:leaves?|be\s+(?:moved|taken)|move)\b(?!\s+(?:again|after|later|once|until|before))[^,;.]*"
    r"|\b(?:it|they)\s+(?:has|have|needs?|is|are)\s+to\s+(?:stay|remain)\s+(?:on|in|at|where)\b[^,;.]*"
    r"|\b(?:on|to)\s+the\s+(?:correct|proper|usual|wrong)\s+side\b[^,;.]*"
    r"|\bonly\s+(?:after|if|when|once|with)\s+(?:asking\s+)?(?:me|my|I|he|she|they|we|asking|permission)\b[^,;.]*",
    re.IGNORECASE,
)
_ASKING = re.compile(
    r"^\W*(?:please\s+)?(?:ask|tell|remind|instruct|order|command|let|have|get|beg|invite|urge)\s+(?:the\s+|your\s+|my\s+|our\s+)?"
    r"(?P<who>[a-z]+)\s+(?:not\s+)?to\s+(?=\w)",
    re.IGNORECASE,
)
_DID = re.compile(
    r"^\W*(?P<who>[A-Z][a-z]+|(?:[Mm]y|[Oo]ur|[Tt]he|[Aa])\s+[a-z]+|[Hh]e|[Ss]he|[Tt]hey|[Ww]e|I|[Ss]ome(?:body|one))\s*"
    r"(?:['’]s|['’]ve|\s(?:has|have|had))\s+(?:(?:already|just|now|also|since)\s+)*"
    r"(?:\w+ed|put|set|brought|taken|laid|given|sent|left|done)\b(?!\s+to\b)"
)
_CORRECTED = re.compile(
    r"\s*(?:[,;.\u2013\u2014(-]|\s-)?\s*(?:(?:oh|ah|er|uh|um|oops)[,\s]+)?"
    r"(?:no(?:,?\s+(?:wait|sorry|actually|rather))?|(?:sorry|wait|pardon|oops|scratch\s+that|correction|make\s+that|I\s+mean(?:t)?|or\s+rather)"
    r"(?:,?\s+no)?)\s*[,:\u2013\u2014-]?\s*(?:I\s+mean(?:t)?\s+|make\s+(?:that|it)\s+|rather\s+)?"
    r"(?P<lead>(?:(?:to|on|onto|into|in|at|for)\s+)?(?:the\s+|an?\s+)?)",
    re.IGNORECASE,
)
_SAID = re.compile(
    r"[,;.\u2013\u2014(-]\s*(?:oh,?\s+)?(?:(?:no|sorry|scratch\s+that|oops|correction)\b(?:\s+wait)?\s*[,:\u2013\u2014]"
    r"|(?:no\s+)?(?:wait|hang\s+on|hold\s+on)\b\s*[,:.\u2013\u2014]|I\s+mean(?:t)?\s+(?!to\b)|(?:or\s+)?rather\s+(?:on|in|to|onto)\s|make\s+(?:that|it)\s)",
    re.IGNORECASE,
)
_CORRECTS = re.compile(
    r"^\W*(?:(?:oh|ah|uh|um|er|hm+|oops|whoops|ok|okay|well|and|but)\b[\s,.!\u2026]*)*(?:"
    r"no\b(?=\s*[,.!:;\u2026\u2013\u2014-]|\s+(?:wait|sorry|hang|hold|actually|scratch|not|rather|on|onto|to|the|make)\b)"
    r"|(?:no,?\s+)?(?:wait|hang\s+on|hold\s+on|sorry|pardon|oops|whoops|my\s+(?:bad|mistake))\s*[,.!:;\u2026\u2013\u2014-]+\s*(?=\w)"
    r"|(?:scratch|strike|cancel|undo|ignore|forget)\s+(?:that|it|about|what)\b|correction\b"
    r"|(?:sorry,?\s+)?I\s+mean(?:t)?\b|(?:or\s+|actually,?\s+|no,?\s+)*make\s+(?:that|it)\s+(?=(?:the|an?|on|position|level|slot|object)\b|\d)"
    r"|or\b(?!\s+else\b)|rather\b|on\s+second\s+thoughts?\b|never\s*mind\b|not\s+[^,;:.]{1,40}[,;:\u2013\u2014]\s*(?:but\s+)?[^,;:]{1,40}$)",
    re.IGNORECASE,
)
"""Begins a step that puts the one before it right."""
_CUT = re.compile(r"\s[b-hj-z]$")
"""A lone letter at the end: the first of a word that the reply has no more room for."""


def doubts(step: LabelledStep, scene: Scene) -> Iterator[Extent]:
    """Where a step takes its order back, leaves it open, breaks off, or tells of another who does it or has done it."""
    if len(step.text) > _SHORT:
        return
    yield from (Extent(*m.span()) for m in _CUT.finditer(step.text) if any(s.end == m.start() for s in step.spans))
    yield from (Extent(*m.span()) for m in _RETRACTED.finditer(step.text))
    yield from (Extent(*m.span()) for m in _SAID.finditer(step.text))
    for pattern in (_ASKING, _DID):
        m = pattern.search(step.text)
        who = tokens(m["who"])[-1:] if m is not None else ()
        if m is not None and who and not lexicon().is_(who[0].text, "robot") and not scene.word(who[0], True).text:
            yield Extent(*m.span())


def corrects(text: str) -> bool:
    """Whether a step takes back, or puts otherwise, what was said before it: "no wait, object 2", "make that 32", "or
    was it 33?"."""
    return _CORRECTS.match(text) is not None


def put_right(step: LabelledStep) -> LabelledStep:
    """ "The red cup, no, the blue cup": only what it is corrected to."""
    spans = sorted(step.spans, key=lambda s: s.start)
    for a, b in pairwise(spans):
        m = _CORRECTED.fullmatch(step.text, a.end, b.start) if a.label is b.label else None
        if m is None or len(step.text) > _SHORT:
            continue
        return without(replace(step, readings=()), Extent(a.start, b.start))
    return step
