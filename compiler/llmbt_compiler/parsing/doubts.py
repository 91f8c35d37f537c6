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

__all__ = ["doubts", "put_right"]

_SHORT = 300
_RETRACTED = re.compile(
    r"\b(?:but|or|and|though)\s+(?:please\s+)?(?:do\s+not|don['’]?t|never)(?:\s+(?:actually|really|yet))?"
    r"(?:\s+do)?(?:\s+(?:it|so|that|this|anything))?(?:\s+(?:yet|now|really))?(?=\s*[.,;!]|\s*$)"
    r"|\bor\s+(?:else\s+)?(?:just\s+)?(?:leave|keep|forget|skip)\s+(?:it|them|that)\b[^,;.]*"
    r"|\bunless\s+(?:you|I|we|he|she|some(?:body|one)|any(?:body|one))\b(?!['’]?(?:re|\s+are)\s+(?:sure|unable))[^,;.]*"
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
    r"[,;.\u2013\u2014(-]\s*(?:oh,?\s+)?(?:no|sorry|scratch\s+that|oops|correction)\b(?:\s+wait)?\s*[,:\u2013\u2014]",
    re.IGNORECASE,
)
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


def put_right(step: LabelledStep) -> LabelledStep:
    """ "The red cup, no, the blue cup": only what it is corrected to."""
    spans = sorted(step.spans, key=lambda s: s.start)
    for a, b in pairwise(spans):
        m = _CORRECTED.fullmatch(step.text, a.end, b.start) if a.label is b.label else None
        if m is None or len(step.text) > _SHORT:
            continue
        return without(replace(step, readings=()), Extent(a.start, b.start))
    return step
