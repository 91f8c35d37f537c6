"""The request read as if it were steps: a second witness of one wish, held against what the reply made of it.

The parser is strict: where a request's own words fit several things, or count further than there are places, it says
so, and a reply that goes on all the same has decided something that nobody told it. What the parser cannot read in a
request (a remark, a courtesy) says nothing, so that only a few of its complaints are taken up here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from llmbt_atl.library import Library
from llmbt_compiler.checking.choices import left_open
from llmbt_compiler.checking.points import OpenPoint
from llmbt_compiler.checking.referring import MASS, meant_objects, told_apart
from llmbt_compiler.checking.sentences import one_line
from llmbt_compiler.parsing import Goal, LabelledStep, ParseResult
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic, Severity, Span
from llmbt_ir.semantic_map import SemanticMap

_TOO_FAR = ("there is no", "the scene has no `")
"""How E302 begins where a place is counted that is not there, and not just a name unknown."""
_MORE = frozenset({",", "(", "that", "which", "who", "whose", "you", "i", "we", "they"})

__all__ = ["witnessed"]


def witnessed(
    request: str,
    sentences: Sequence[LabelledStep],
    own: ParseResult,
    goals: Sequence[Goal],
    semantic_map: SemanticMap,
    library: Library,
) -> Iterator[OpenPoint]:
    """E141 where the request's `own` reading fits several things and the goals take fewer of them; E142 where it counts
    further than the map does ("the fifth position from the left")."""
    scene = Scene(semantic_map, library)
    line = one_line(request)
    words = tokens(line)
    phrases = [p for p in meant_objects(words, line, scene) if p.ids]
    moved = {g.condition.args[0] for g in goals if g.condition.args}
    apart = [
        moved & set(p.ids)
        for p in phrases
        if len(p.ids) > 1 and told_apart(words, p.start, p.end, sorted(moved & set(p.ids)), p.ids, scene)
    ]
    for fault in own.errors():
        sentence = next((s.text for s in sentences if fault.span is not None and s.number == fault.span.line), "")
        if fault.code == "E302" and fault.title.startswith(_TOO_FAR):
            yield OpenPoint(_told(fault, "E142", f"the request names what is not there: {fault.title}", sentence))
        taken = sorted(moved & set(fault.candidates))
        if fault.code != "E304" or not fault.title.endswith("things") or not 0 < len(taken) < len(fault.candidates):
            continue
        if (
            _goes_on(fault, sentence)
            or _apart(fault, sentence, taken, scene)
            or left_open(words, line, scene, movable=True)
        ):
            continue
        if set(taken) in apart:
            continue
        groups = [set(p.ids) for p in phrases if len(p.ids) == p.count > 1]
        if any(group & set(fault.candidates) == set(taken) for group in groups):
            continue  # "the two greens on the shelf: the front one ..."
        if any(set(p.ids) < set(fault.candidates) and len(p.ids) <= len(taken) for p in phrases):
            continue  # "the green block on the shelf": its place tells
        title = f"{fault.title}, and the reply takes {', '.join(taken)} without asking"
        yield OpenPoint(_told(fault, "E141", title, sentence), taken[0] if len(taken) == 1 else None)


def _goes_on(fault: Diagnostic, sentence: str) -> bool:
    """Whether more follows that may tell which one is meant ("the red thing, the one to eat"), or the phrase looks
    back to something ("the other yellow one", "of the pair, the larger")."""
    if fault.span is None:
        return True
    parts = tokens(sentence)
    after = next((t.text for t in parts if t.start >= fault.span.end_column - 1), "")
    before = next((t.text for t in reversed(parts) if t.end <= fault.span.column - 1), "")
    inside = {t.text for t in parts if fault.span.column - 1 <= t.start < fault.span.end_column - 1}
    last = max((t for t in parts if t.start < fault.span.end_column - 1), key=lambda t: t.start, default=None)
    pair = last is not None and last.text in lexicon().sizes
    return after in _MORE or before == "its" or bool(inside & (MASS | {"other", "its"})) or pair


def _apart(fault: Diagnostic, sentence: str, taken: Sequence[str], scene: Scene) -> bool:
    """Whether what the goals take is told apart from the rest by what stands around the words complained of."""
    if fault.span is None:
        return False
    parts = tokens(sentence)
    start = sum(t.end <= fault.span.column - 1 for t in parts)
    end = sum(t.start < fault.span.end_column - 1 for t in parts)
    return told_apart(parts, start, end, taken, fault.candidates, scene)


def _told(fault: Diagnostic, code: str, title: str, sentence: str) -> Diagnostic:
    at = fault.span
    span = Span("request", 1, at.column, at.end_column, " ".join(sentence.split())) if at is not None else None
    return replace(fault, code=code, title=title, span=span, severity=Severity.ERROR)
