"""A description followed by the name of what is meant: "the block next to object 6, which is object 5", "the snack (the
chocolate)": the name counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["identified"]

_OPENING = frozenset({",", "(", "-", "\u2013", "\u2014", ":"})
_CLOSING = frozenset({",", ")", "-", "\u2013", "\u2014", ".", ";"})
_MEANING = frozenset({
    "which", "that", "is", "thats", "ie", "i", "e", ".", "namely", "so", "say", "viz", "in", "this", "case", "meaning",
    "it", "the", ",",
})  # fmt: skip
_LEADING = frozenset({"from", "off", "on", "onto", "to", "in", "into", "at", "and", "then", "over"})
_LONGEST = 14


def identified(step: LabelledStep, scene: Scene) -> LabelledStep | None:
    """The step with blanks in place of a description that a name follows, which is its target, or its destination, then
    ("the position to the right, position 23"); None without such.

    The name is a number's or a thing's own; the description names no other thing by itself and contradicts no colour
    of it; what goes on with "and" and a further name is a list, and no explanation.
    """
    line = tokens(step.text)
    for c, t in enumerate(line):
        if t.text not in _OPENING:
            continue
        for kind in (Kind.TARGET, Kind.DESTINATION):
            plain = _plain(step, line, c, kind, scene)
            if plain is not None:
                return plain
    return None


def _plain(step: LabelledStep, line: Sequence[Token], c: int, kind: Kind, scene: Scene) -> LabelledStep | None:
    described = _described(step, line, c, kind, scene)
    named = _named(line, c + 1, kind, scene)
    if described is None or named is None:
        return None
    start, end, thing = named
    head = next((described + r.start for r in relations(line[described:c])), c)
    hue = next((h.text for h in line[described:head] if h.text in scene.colours), None)
    if (hue is not None and hue not in scene[thing].colour) or _lists(line, end, kind, scene):
        return None
    closed = end < len(line) and line[end].text in _CLOSING - {"."}
    closing = line[end] if closed else None
    return _put(step, line[described].start, line[start].start, line[end - 1].end, kind, closing)


def _described(step: LabelledStep, line: Sequence[Token], c: int, kind: Kind, scene: Scene) -> int | None:
    """Where the description before an offset begins: the first target, or destination, of its verb, where that names
    no one thing."""
    before = [s for s in step.spans if s.end <= line[c].start]
    verb = max((s.end for s in before if s.label is Kind.ACTION), default=0)
    targets = [s for s in before if s.label is kind and s.start >= verb]
    if not targets or not c:
        return None
    first = next((k for k, t in enumerate(line) if t.start >= targets[0].start), c)
    last = max((k for k in range(c) if line[k].start < targets[0].end), default=first)
    if c - first > _LONGEST or _own(line[first : last + 1], kind, scene) is not None:
        return None
    return first - 1 if first and lexicon().is_(line[first - 1].text, "articles") else first


def _named(line: Sequence[Token], at: int, kind: Kind, scene: Scene) -> tuple[int, int, str] | None:
    """The name that follows, with nothing before it but "which is" and the like; where it begins and ends."""
    k = at
    while k < len(line) and (line[k].text in _MEANING or lexicon().is_(line[k].text, "articles")):
        k += 1
    for length in (3, 2, 1):
        thing = _own(line[k : k + length], kind, scene) if k + length <= len(line) else None
        after = line[k + length].text if k + length < len(line) else "."
        if thing is not None and (after in _CLOSING | _LEADING):
            return k, k + length, thing
    return None


def _own(parts: Sequence[Token], kind: Kind, scene: Scene) -> str | None:
    """The one thing that words name by its number or by a name of its own."""
    if not parts or not parts[0].word or any(not (p.word or p.number is not None) for p in parts):
        return None
    found = (resolve_objects if kind is Kind.TARGET else resolve_places)(parts, scene, Talk())
    if not isinstance(found, Found) or len(found.ids) != 1 or found.corrected or found.chosen:
        return None
    (id_,) = found.ids
    if id_ in {ANYWHERE, ORIGIN}:
        return None
    own = " ".join(p.text for p in parts) in scene[id_].keys
    return id_ if own or parts[-1].number is not None else None


def _lists(line: Sequence[Token], end: int, kind: Kind, scene: Scene) -> bool:
    """Whether a further name follows: ", the chocolate and the bread"."""
    k = end
    while k < len(line) and (line[k].text in {",", "and", "&"} or lexicon().is_(line[k].text, "articles")):
        k += 1
    return k > end and any(_own(line[k : k + n], kind, scene) is not None for n in (1, 2) if k + n <= len(line))


def _put(step: LabelledStep, start: int, name: int, end: int, kind: Kind, closing: Token | None) -> LabelledStep:
    text = step.text[:start] + " " * (name - start) + step.text[name:]
    if closing is not None:
        text = text[: closing.start] + " " * (closing.end - closing.start) + text[closing.end :]
    kept = [s for s in step.spans if s.end <= start or s.start >= end]
    meant = KeywordSpan(name, end, kind, step.text[name:end], 1.0)
    spans = tuple(sorted((*kept, meant), key=lambda s: s.start))
    sure = min((s.confidence for s in kept if s.confidence is not None), default=step.confidence)
    return replace(step, text=text, spans=spans, readings=(), confidence=sure)
