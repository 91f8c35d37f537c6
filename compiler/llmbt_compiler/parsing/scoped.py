"""Sets told by where they are and by what they leave out: "everything that still stands on the shelf", "all the things
on the bar but the tea", "everything but the green blocks", each one phrase whatever the tagger cut out of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.phrase import excepts
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon, singulars, tokens

__all__ = ["left_out_first", "scoped"]

_SHORT = 300
_WHOLE = frozenset({"everything", "whatever", "anything"})
_RELATIVE = frozenset({"that", "which"})
_STANDS = frozenset({
    "is", "are", "s", "stands", "stand", "sits", "sit", "lies", "lie", "rests", "rest", "remains", "remain", "still",
    "currently", "now", "standing", "sitting", "lying", "resting", "located", "placed", "left", "already", "presently",
})  # fmt: skip
_AT = frozenset({"on", "in", "at", "inside", "upon", "from", "off"})
_ENDS = frozenset({"on", "in", "at", "inside", "onto", "into", "to", "from", ".", ";", ":"})
_FOUND = frozenset({"you", "find", "see", "there", "happens", "to", "be"})
_BUT = frozenset({"save", "excluding", "excepting", "barring", "except"})
_MOST = 12


def scoped(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with such a phrase as one target: where a relative clause tells where the things are, where something
    is left out and another place follows to which they go, or where only something is left out."""
    line = tokens(step.text)
    if len(step.text) > _SHORT:
        return step
    for i in range(len(line)):
        end = _whole(line, i, scene)
        if not end:
            continue
        at, relative = _standing(line, end, scene, told=line[i].text == "whatever")
        out = _leaving_out(line, at or end, scene)
        off = {"off", "from"} & {t.text for t in line[end : end + 2]}
        if at and not relative and not (out and (off or _goes_on(line, out, scene))):
            continue
        if not (at or out):
            continue
        last = out or at
        start, stop = line[i].start, line[last - 1].end
        acts = (s for s in step.spans if s.label is Kind.ACTION and start <= s.start < stop)
        if any(s.text.casefold() not in _BUT for s in acts):
            continue
        kept = [s for s in step.spans if s.end <= start or stop <= s.start]
        kept.append(KeywordSpan(start, stop, Kind.TARGET, step.text[start:stop]))
        return replace(step, spans=tuple(sorted(kept, key=lambda s: s.start)))
    return step


def _whole(line: Sequence[Token], i: int, scene: Scene) -> int:
    """Where a noun phrase that begins at `i` and means all of some things ends; 0 for none."""
    lex = lexicon()
    if line[i].text in _WHOLE:
        return i + 2 if [t.text for t in line[i + 1 : i + 2]] == ["else"] else i + 1
    quantified = lex.is_(line[i].text, "all")
    if not quantified and line[i].text not in {"the", "those"}:
        return 0
    own = scene.vocabulary(True) | scene.generic(True)
    j = i + 1
    while j < len(line) and (line[j].text == "of" or lex.is_(line[j].text, "articles", "all")):
        j += 1
    begin = j
    while j < len(line) and line[j].word and line[j].text not in _ENDS | _RELATIVE | _STANDS:
        if not own & set(singulars(line[j].text)) and line[j].text not in lex.sizes:
            break
        j += 1
    if j == begin == i + 1 and quantified and excepts(line, j):
        return j  # "all but the white ball"
    plural = j > begin and line[j - 1].text.endswith("s") and scene.word(line[j - 1], True).plural
    return j if j > begin and (plural or quantified) else 0


def _standing(line: Sequence[Token], j: int, scene: Scene, *, told: bool) -> tuple[int, bool]:
    """Where "that still stands on the shelf" or "on the bar" ends, 0 for none; and whether it is a relative clause
    (`told`: as behind "whatever")."""
    begin = j
    if j < len(line) and line[j].text in _RELATIVE:
        j += 1
    while told and j < len(line) and line[j].text in _FOUND:
        j += 1
    relative = told or j > begin or (j < len(line) and line[j].text in {"standing", "sitting", "lying", "left"})
    while j < len(line) and line[j].text in _STANDS:
        j += 1
    relative &= j > begin
    if j + 1 >= len(line) or line[j].text not in _AT or (j > begin and not relative):
        return 0, False
    end = _place(line, j + 1, scene)
    return end, relative


def _place(line: Sequence[Token], j: int, scene: Scene) -> int:
    """Where the name of one place that begins at `j` ends; 0 for none."""
    for size in range(min(5, len(line) - j), 0, -1):
        words = line[j : j + size]
        if not all(t.word or t.number is not None for t in words):
            continue
        found = resolve_places(words, scene, Talk())
        one = isinstance(found, Found) and len(found.ids) == 1 and not (found.corrected or found.vague)
        if one and isinstance(found, Found) and not {ANYWHERE, ORIGIN} & set(found.ids):
            return j + size
    return 0


def _leaving_out(line: Sequence[Token], j: int, scene: Scene) -> int:
    """Where ", apart from the bread and the apple" ends; 0 for none."""
    lex = lexicon()
    if j < len(line) and line[j].text == ",":
        j += 1
    size = excepts(line, j) if j < len(line) else 0
    if not size or line[j].text in _RELATIVE | _STANDS or line[j].text == "without":
        return 0
    j += size
    stop = next((k for k in range(j, len(line)) if line[k].text in _ENDS), len(line))
    for n in range(min(stop - j, _MOST), 0, -1):
        words = line[j : j + n]
        if not (words[-1].word or words[-1].number is not None) or lex.is_(words[-1].text, "articles", "joints"):
            continue
        found = resolve_objects(words, scene, Talk({o.id: o.place for o in scene.map.objects}))
        if isinstance(found, Found) and not found.corrected and not found.chosen:
            closed = j + n < len(line) and line[j + n].text == ","
            return j + n + closed if closed and _goes_on(line, j + n, scene) else j + n
    return 0


def left_out_first(step: LabelledStep, scene: Scene) -> tuple[tuple[str, ...], Extent] | None:
    """ "Apart from the tea, everything on the bar goes to the table": what is left out, and where that is said."""
    line = tokens(step.text) if len(step.text) <= _SHORT else ()
    size = excepts(line, 0) if line and line[0].text not in _RELATIVE | _STANDS | {"without", "but"} else 0
    comma = next((i for i, t in enumerate(line) if t.text == ","), 0)
    if not size or comma <= size:
        return None
    where = Talk({o.id: o.place for o in scene.map.objects})
    for k in [i for i in range(len(line) - 1, size, -1) if line[i].text == ","]:
        found = resolve_objects(line[size:k], scene, where)
        if isinstance(found, Found) and not found.corrected and not found.chosen:
            return found.ids, Extent(0, line[k].end)
    return None


def _goes_on(line: Sequence[Token], j: int, scene: Scene) -> bool:
    """Whether a preposition and a place follow, to which things go."""
    lex = lexicon()
    for k in range(j, min(len(line) - 1, j + 8)):
        if line[k].text in {".", ";"}:
            return False
        if lex.is_(line[k].text, "onto", "at") and (_place(line, k + 1, scene) or lex.is_(line[k + 1].text, "me")):
            return True
    return False
