"""Steps written with their labels in brackets: ``A[Pick] up T[object 1]``, and results as lines of text."""

from __future__ import annotations

import re

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing import LabelledStep, ParseResult

_KINDS = {"A": Kind.ACTION, "T": Kind.TARGET, "D": Kind.DESTINATION, "L": Kind.LOCATION}
_MARK = re.compile(r"([ATDL])(?:~(0\.\d+))?\[([^\]]*)\]")


def labelled(marked: str, number: int = 1) -> LabelledStep:
    """One step. ``A~0.3[Put]`` has a confidence of 0.3."""
    text, spans, at = "", [], 0
    for m in _MARK.finditer(marked):
        text += marked[at : m.start()]
        start = len(text)
        text += m.group(3)
        spans.append(KeywordSpan(start, len(text), _KINDS[m.group(1)], m.group(3), float(m.group(2) or 1)))
        at = m.end()
    return LabelledStep(number, text + marked[at:], tuple(spans))


def steps(*marked: str) -> tuple[LabelledStep, ...]:
    """Steps numbered from 1."""
    return tuple(labelled(m, i) for i, m in enumerate(marked, 1))


def shown(result: ParseResult) -> list[str]:
    """A result as the golden files have it."""
    out = [f"goal {g.condition} <- step {g.step_number}: {g.words}" for g in result.goals]
    out += [f"note step {n.step_number}, {n.kind}: {n.text}" for n in result.notes]
    for d in result.diagnostics:
        where = f"step {d.span.line}, columns {d.span.column}-{d.span.end_column}" if d.span else "-"
        near = f" [{', '.join(d.candidates)}]" if d.candidates else ""
        out.append(f"{d.code} {where}: {d.title} / {d.label}{near}")
    out.append(f"exit {int(result.exit_code)}")
    return out
