"""What a request leaves open, and a reply decided without asking; what it names, and the scene does not have.

Words alone, no model: only what is plain is told. A definite singular ("the green block") that fits several objects, of
which the goals take one; a name with a number that the map does not have; a colour that nothing in it has.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from llmbt_atl.library import Library
from llmbt_compiler.parsing import Extent, Goal
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic, Span
from llmbt_ir.scene import COLOURS
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["OpenPoint", "open_points"]

_POINTING = frozenset({"the", "that", "this", "my", "your"})
_TELLING = frozenset({
    "left", "right", "next", "beside", "behind", "front", "between", "nearest", "closest", "near", "above", "below",
    "leftmost", "rightmost", "largest", "smallest", "biggest", "tallest", "top", "bottom", "first", "second", "third",
    "last", "other", "same", "remaining", "rest", "that", "which", "whose", "with",
})  # fmt: skip
_MASS = frozenset({"cargo", "good"})
_AT = frozenset({"on", "in", "at", "from", "of"})
_ENDING = frozenset({"on", "onto", "in", "into", "at", "from", "to", "and", ",", ".", "then"})
_HUES = frozenset({*COLOURS, "gray", "violet", "cyan", "magenta", "turquoise", "gold", "golden"}) - {"wood"}


@dataclass(frozen=True, slots=True)
class OpenPoint:
    """Something to ask about, and what the reply took for it (None: the scene lacks it)."""

    diagnostic: Diagnostic
    taken: str | None = None


def open_points(
    request: str, goals: Sequence[Goal], semantic_map: SemanticMap, library: Library
) -> tuple[OpenPoint, ...]:
    """E141 for each phrase of the request that fits several objects and of which the goals take just one; E142 for each
    name in it that the scene lacks. In the order of the request."""
    scene = Scene(semantic_map, library)
    line = " ".join(request.split())[:2000]
    return tuple(_points(tokens(line), line, goals, scene))


def _points(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[OpenPoint]:
    where = {o.id: o.place for o in scene.map.objects}
    numbered = {i for i in range(len(words) - 1) if _numbered(words, i, scene)}
    named = {e for i in numbered if isinstance(f := _named(words, i, scene), Found) for e in f.ids}
    moved = {a for g in goals for a in g.condition.args}
    for i, t in enumerate(words):
        if i in numbered:
            found = _named(words, i, scene)
            if isinstance(found, Fault) and found.code in {"E301", "E302"}:
                yield OpenPoint(_lacks(found, words[i : i + 2], request))
        size = _noun_phrase(words, i, scene) if t.text in _POINTING else 0
        if size:
            fits = _fitting(words, i, size, scene, where)
            taken = moved & set(fits)
            if len(fits) > 1 and len(taken) == 1 and not named & set(fits):
                yield OpenPoint(_several(words[i : i + size], request, fits, *taken), *taken)
        if t.text in _HUES and t.text not in scene.colours and _is_noun(words, i + 1, scene) and not _if(words, i):
            found = resolve_objects(words[i : i + 2], scene, Talk())
            if isinstance(found, Fault) and found.code == "E301":
                yield OpenPoint(_lacks(found, words[i : i + 2], request))


def _numbered(words: Sequence[Token], i: int, scene: Scene) -> bool:
    """Whether "object 9" or "position 55" begins here: a word of ids, and a number that does not count something."""
    stems = frozenset[str]().union(*(e.stem for e in (*scene.objects, *scene.places) if e.number is not None))
    after = words[i + 1]
    counts = i + 2 < len(words) and _is_noun(words, i + 2, scene)
    return words[i].text in stems and after.number is not None and after.text != "one" and not counts


def _named(words: Sequence[Token], i: int, scene: Scene) -> Found | Fault:
    movable = any(words[i].text in e.stem for e in scene.objects)
    resolve = resolve_objects if movable else resolve_places
    return resolve(words[i : i + 2], scene, Talk())


def _is_noun(words: Sequence[Token], i: int, scene: Scene) -> bool:
    if i >= len(words) or not words[i].word:
        return False
    known = scene.word(words[i], True).text
    return bool(known) and known not in scene.colours and scene.understood(known, True)


def _noun_phrase(words: Sequence[Token], i: int, scene: Scene) -> int:
    """How many tokens "the green block" takes from its article on; 0 where it is plural, numbered, or told apart by
    what stands in it or right after it."""
    j = i + 1
    while j < len(words) and words[j].word and j - i <= 4:
        text = words[j].text
        if text in _TELLING or lexicon().is_(text, "all", "both", "rest", "same") or words[j].number is not None:
            return 0
        word = scene.word(words[j], True)
        if not word.text or word.corrected:
            return 0
        if word.text in _MASS:
            return 0
        if word.text not in scene.colours:
            after = words[j + 1] if j + 1 < len(words) else None
            plain = after is None or (after.number is None and after.text not in _TELLING and after.text != "(")
            return 0 if word.plural or not plain else j + 1 - i
        j += 1
    return 0


def _fitting(words: Sequence[Token], i: int, size: int, scene: Scene, where: dict[str, str | None]) -> tuple[str, ...]:
    """All objects that the phrase fits; only those on the place that is named after it, if some of them are there."""
    phrase = words[i + 1 : i + size]
    every = (Token("all", phrase[0].start, phrase[0].start), *phrase)
    found = resolve_objects(every, scene, Talk())
    if not isinstance(found, Found):
        return ()
    ids = found.ids
    rest = words[i + size :]
    if rest and rest[0].text in _AT:
        end = next((k for k, t in enumerate(rest[1:]) if t.text in _ENDING), len(rest) - 1)
        for length in range(min(6, end), 0, -1):
            place = resolve_places(rest[1 : 1 + length], scene, Talk())
            if isinstance(place, Found) and len(place.ids) == 1 and place.ids[0] in {p.id for p in scene.places}:
                there = tuple(o for o in ids if scene.within(where.get(o), place.ids[0]))
                return there or ids
    return ids


def _if(words: Sequence[Token], i: int) -> bool:
    return any(lexicon().is_(t.text, "conditional") for t in words[:i])


def _span(parts: Sequence[Token], request: str) -> Span:
    extent = Extent(parts[0].start, parts[-1].end)
    shown = "".join(c if c.isprintable() else " " for c in request)
    return Span("request", 1, extent.start + 1, extent.end + 1, shown if len(shown) <= 2000 else "")


def _several(parts: Sequence[Token], request: str, ids: Sequence[str], taken: str) -> Diagnostic:
    said = request[parts[0].start : parts[-1].end]
    return Diagnostic(
        "E141",
        f"`{said}` fits {len(ids)} objects, and the reply takes {taken} without asking",
        _span(parts, request),
        "which?",
        f"say which of {', '.join(ids[:6])}",
        candidates=tuple(ids),
    )


def _lacks(fault: Fault, parts: Sequence[Token], request: str) -> Diagnostic:
    return Diagnostic(
        "E142",
        f"the request names what is not there: {fault.title}",
        _span(parts, request),
        "not in the map",
        fault.help,
        candidates=fault.candidates,
    )
