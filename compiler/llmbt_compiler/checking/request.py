"""What a request leaves open, and a reply decided without asking; what it names, and the scene does not have.

Words alone, no model: only what is plain is told. A definite singular ("the green block") that fits several objects, of
which the goals take one; a name with a number that the map does not have; a colour that nothing in it has.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from llmbt_atl.library import Library
from llmbt_compiler.checking.phrases import definite
from llmbt_compiler.parsing import Extent, Goal, ParseResult
from llmbt_compiler.parsing.mentions import mentioned_in
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic, Severity, Span
from llmbt_ir.scene import COLOURS
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["OpenPoint", "open_points"]

_LEAVING = frozenset({
    "leave", "leaving", "stay", "stays", "keep", "remain", "remains", "where", "swap", "exchange", "switch", "already",
    "currently", "now", "was", "from", "empty",
    "still", "than", "rather", "like", "clear", "free", "stands", "temporarily", "via", "through",
})  # fmt: skip
_MOVING = frozenset({"move", "put", "place", "shift"})
_LEFT_OPEN = re.compile(
    r"\b(?:your (?:own )?(?:discretion|choice|choosing)|up to you|you (?:may |can )?(?:choose|pick|decide)"
    r"|no (?:particular |special )?preference|whichever|no matter (?:which|what)"
    r"|(?:does not|doesn['’]?t) matter which)\b",
    re.IGNORECASE,
)
"""Says that any of them will do."""
_SMALL = frozenset({"please", "pls", "plz", "could", "can", "would", "you", "robot", "now", "just", "hey", "hi", "and"})
_SHORT = 12
_TURNING = ("negation", "except", "instead", "conditional")
_HUES = frozenset({*COLOURS, "gray", "violet", "cyan", "magenta", "turquoise", "gold", "golden"}) - {"wood"}


@dataclass(frozen=True, slots=True)
class OpenPoint:
    """Something to ask about, and what the goals took for it (None: nothing that could be exchanged in them)."""

    diagnostic: Diagnostic
    taken: str | None = None


def open_points(
    request: str, parsed: ParseResult, semantic_map: SemanticMap, library: Library, said: str = ""
) -> tuple[OpenPoint, ...]:
    """E141 for each phrase of the request that fits several objects and of which the goals, or the steps as they were
    `said` (a landmark: "to the left of object 2"), take just one; E142 for each
    name in it that the scene lacks; E143 for what it names by its number, and no goal is about; E309 where it asks for
    a relation that the goals leave open. In the order of the request."""
    scene = Scene(semantic_map, library)
    line = " ".join(request.split())[:2000]
    words = tokens(line)
    return (
        *_points(words, line, parsed.goals, scene, frozenset(mentioned_in(said, scene))),
        *_passed_over(words, line, parsed, scene),
        *_relations(words, line, parsed),
        *_nowhere(words, line, parsed.goals, scene),
    )


def _passed_over(words: Sequence[Token], request: str, parsed: ParseResult, scene: Scene) -> Iterator[OpenPoint]:
    """Objects by their numbers or names, numbered places where nothing stands yet, and colours, that the request names
    and the goals leave out; not where it may name them for another reason: as landmarks, in a condition, to be left
    alone."""
    if any(t.text in _LEAVING or lexicon().is_(t.text, *_TURNING) for t in words) or _states(words):
        return
    landmarks = {id(t) for r in relations(words) for t in words[r.end : name_end(words, r)]}
    about = {a for g in parsed.goals for a in g.condition.args}
    about |= {i for m in parsed.moves for i in (m.target, m.place)}
    for start, end, ids in _mentions(words, scene):
        if not landmarks & {id(t) for t in words[start:end]} and not any(_concerns(i, about, scene) for i in ids):
            said = request[words[start].start : words[end - 1].end]
            title = f"the request names `{said}`, and the reply passes over it"
            yield OpenPoint(
                Diagnostic("E143", title, _span(words[start:end], request), "no goal is about it",
                           "say it again in other words, or leave it out", candidates=ids[:6])
            )  # fmt: skip


def _states(words: Sequence[Token]) -> bool:
    """Whether something is told ("object 3 is in the way"), and not only told apart ("that is nearer")."""
    return any(b.text in {"is", "are"} and a.text not in {"that", "which", "who"} for a, b in pairwise(words))


def _mentions(words: Sequence[Token], scene: Scene) -> Iterator[tuple[int, int, tuple[str, ...]]]:
    """Where a text names things, and which they may be."""
    occupied = {o.place for o in scene.map.objects}
    for i in range(len(words)):
        found = _named(words, i, scene) if i + 1 < len(words) and _numbered(words, i, scene) else None
        if isinstance(found, Found) and len(found.ids) == 1:
            (id_,) = found.ids
            inner = {id_, *(p.id for p in scene.map.inside(id_))} if not scene[id_].movable else set()
            if not inner & occupied:
                yield i, i + 2, (id_,)
        if words[i].text in scene.colours:
            yield i, i + 1, tuple(e.id for e in scene.objects if words[i].text in e.colour)
        for e in scene.objects:
            size = len(e.id.split("_"))
            text = " ".join(t.text for t in words[i : i + size])
            if e.number is None and text == e.id.replace("_", " "):
                yield i, i + size, (e.id,)


def _concerns(id_: str, about: set[str], scene: Scene) -> bool:
    """Whether the goals are about a thing, or about a place in it."""
    if id_ in about:
        return True
    return not scene[id_].movable and any(a in {p.id for p in scene.map.inside(id_)} for a in about)


def _relations(words: Sequence[Token], request: str, parsed: ParseResult) -> Iterator[OpenPoint]:
    left_open = next((d for d in parsed.diagnostics if d.code == "W309"), None)
    asked = relations(words)
    if left_open is not None and asked:
        span = _span(words[asked[0].start : asked[0].end], request)
        place = left_open.candidates[0]
        told = replace(left_open, code="E309", severity=Severity.ERROR, span=span, help=f"is {left_open.label} right?")
        yield OpenPoint(told, place)


def _nowhere(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[OpenPoint]:
    """A request that moves something and has no word for where to."""
    verbs = [i for i, t in enumerate(words) if t.text in _MOVING]
    placed = [g.condition for g in goals if g.condition.name == "On" and not g.condition.negated]
    if not verbs or not placed or len(words) > _SHORT or any(_leads(t, scene) for t in words):
        return
    places = dict.fromkeys(c.args[1] for c in placed)
    taken = next(iter(places)) if len(placed) == 1 else None
    title = f"where is {placed[0].args[0]} to go? the reply takes {', '.join(places)} without asking"
    span = _span(words[verbs[0] :], request)
    yield OpenPoint(Diagnostic("E305", title, span, "no place is named", "name the place"), taken)


def _leads(t: Token, scene: Scene) -> bool:
    """Whether a word may say where to: a place, a way, an order, a number."""
    if t.text in scene.colours or scene.word(t, True).text:
        return False
    return t.number is not None or not (t.text in _MOVING | _SMALL or lexicon().is_(t.text, "articles") or not t.word)


def _points(
    words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene, said: frozenset[str]
) -> Iterator[OpenPoint]:
    numbered = {i for i in range(len(words) - 1) if _numbered(words, i, scene)}
    named = {e for i in numbered if isinstance(f := _named(words, i, scene), Found) for e in f.ids}
    moved = {a for g in goals for a in g.condition.args}
    spoken_of = set(named)
    phrases = {m.start: m for m in definite(words, request, scene)}
    for i, t in enumerate(words):
        if i in numbered:
            found = _named(words, i, scene)
            if isinstance(found, Fault) and found.code in {"E301", "E302"}:
                yield OpenPoint(_lacks(found, words[i : i + 2], request))
        if i in phrases:
            fits = phrases[i].ids
            taken = (moved & set(fits)) or (said & set(fits))
            if len(fits) > 1 and len(taken) == 1 and not spoken_of & set(fits) and not _LEFT_OPEN.search(request):
                (one,) = taken
                told = _several(words[i : phrases[i].end], request, fits, one)
                yield OpenPoint(told, one if one in moved else None)
            spoken_of |= set(fits) if len(fits) == 1 else set()
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
