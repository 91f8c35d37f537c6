"""A description put into other words of the same length, so that every offset of the step stays."""

from __future__ import annotations

from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep

__all__ = ["instead"]


def instead(step: LabelledStep, extent: Extent, plain: str, kind: Kind | None) -> LabelledStep:
    """The step with `plain`, a keyword of `kind` (None: no keyword), in place of the words at `extent`; keywords that
    reach beyond them keep what is outside."""
    size = extent.end - extent.start
    text = step.text[: extent.start] + plain.ljust(size)[:size] + step.text[extent.end :]
    kept: list[KeywordSpan] = []
    for s in step.spans:
        if s.end <= extent.start or extent.end <= s.start:
            kept.append(s)
        elif s.start < extent.start and s.label is not Kind.ACTION:
            said = text[s.start : extent.start].rstrip()
            kept.append(replace(s, end=s.start + len(said), text=said))
    if kind is not None:
        kept.append(KeywordSpan(extent.start, extent.start + len(plain), kind, plain))
    kept = [s for s in kept if s.text.strip()]
    return replace(step, text=text, spans=tuple(sorted(kept, key=lambda s: s.start)), readings=())
