"""Questions to the user: from the model's own words, from the parser's complaints, from the check of the request."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from llmbt_atl.library import Library
from llmbt_atl.template import Role
from llmbt_compiler.checking.request import OpenPoint
from llmbt_compiler.parsing import exit_code_of
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.verbs import Shape, shape_of
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_compiler.reasoning.steps import Question
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Severity, Span
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["Asked", "Slot", "from_diagnostics", "from_model", "from_request", "mentioned_in"]

_ANSWER = "answer with --answer TEXT"
_LONGEST_NAME = 6
_SHOWN = 8


class Slot(StrEnum):
    """What an answer is put in: for the words asked about, or as the thing or the place that they lack."""

    WORDS = "words"
    TARGET = "target"
    DESTINATION = "destination"
    PUT_DOWN = "put down"
    REQUEST = "request"
    MODEL = "model"


@dataclass(frozen=True, slots=True)
class Asked:
    """One question: its diagnostic, the ids that may answer it, and where an answer goes: in step `step`, whose text is
    `line` (several sentences may have one number), columns `start` to `end` counted from 0. `taken`: what the reply
    took without asking."""

    diagnostic: Diagnostic
    slot: Slot
    candidates: tuple[str, ...] = ()
    step: int = 0
    start: int = 0
    end: int = 0
    line: str = ""
    taken: str | None = None

    @property
    def text(self) -> str:
        """The question, for a person and for the model."""
        return self.diagnostic.title

    def error(self) -> LlmbtError:
        """What ends the compilation where nobody answers: exit code 5."""
        return LlmbtError(self.diagnostic, exit_code=ExitCode.UNCLEAR)


def from_diagnostics(found: Sequence[Diagnostic], semantic_map: SemanticMap, library: Library) -> Asked | None:
    """The first of the parser's complaints as a question; None where one of them is none."""
    errors = [d for d in found if d.severity is Severity.ERROR]
    if not errors or any(exit_code_of(d) is not ExitCode.UNCLEAR for d in errors):
        return None
    first = errors[0]
    slot = _slot(first)
    scene = Scene(semantic_map, library)
    candidates = first.candidates
    if not candidates and slot in {Slot.DESTINATION, Slot.PUT_DOWN}:
        candidates = _destinations(scene)
    if not candidates and slot is Slot.TARGET:
        candidates = tuple(sorted((e.id for e in scene.objects), key=natural))
    hint = f"{first.help}; {_ANSWER}" if first.help else _ANSWER
    if candidates and not first.candidates:
        hint = f"{hint}: {_listed(candidates)}"
    told = replace(first, help=hint, candidates=candidates)
    span = first.span or Span("steps.json")
    return Asked(told, slot, candidates, span.line, max(0, span.column - 1), max(0, span.end_column - 1), span.text)


def _slot(diagnostic: Diagnostic) -> Slot:
    if diagnostic.code != "E305":
        return Slot.WORDS
    if diagnostic.title.endswith("never put anywhere"):
        return Slot.PUT_DOWN
    return Slot.TARGET if diagnostic.label == "what?" else Slot.DESTINATION


def from_request(point: OpenPoint) -> Asked:
    """What the check of the request found open."""
    d = point.diagnostic
    told = replace(d, help=f"{d.help}; {_ANSWER}" if d.help else _ANSWER)
    return Asked(told, Slot.REQUEST, d.candidates, taken=point.taken)


def from_model(question: Question, semantic_map: SemanticMap, library: Library) -> Asked:
    """The model's own question. Its candidates are those that it lists or names, or else what its `which` fits."""
    scene = Scene(semantic_map, library)
    listed = [i for name in question.candidates for i in _one(tokens(name), scene)]
    candidates = tuple(dict.fromkeys(listed)) or _mentioned(question.text, scene)
    diagnostic = Diagnostic(
        "E140",
        f"the request is unclear: {question.text}",
        Span("reply.json", question.line),
        help=f"{_ANSWER}: {_listed(candidates)}" if candidates else _ANSWER,
        candidates=candidates,
    )
    return Asked(diagnostic, Slot.MODEL, candidates)


def _listed(ids: Sequence[str]) -> str:
    more = f" and {len(ids) - _SHOWN} more" if len(ids) > _SHOWN else ""
    return ", ".join(ids[:_SHOWN]) + more


def _one(parts: Sequence[Token], scene: Scene) -> tuple[str, ...]:
    for resolve in (resolve_objects, resolve_places):
        found = resolve(parts, scene, Talk()) if parts else None
        if isinstance(found, Found) and not {ANYWHERE, ORIGIN} & set(found.ids) and not found.corrected:
            return found.ids
    return ()


def _mentioned(text: str, scene: Scene) -> tuple[str, ...]:
    """The things of the kind asked for that a question names, in their order; what "which block" fits where it names
    none."""
    words = tokens(text)
    objects, places, first = _names(words, scene)
    asked = next((i for i, t in enumerate(words) if t.text in {"which", "what", "where"}), None)
    if asked is not None and words[asked].text == "where":
        return tuple(places) or (_destinations(scene) if not objects or first is not None else tuple(objects))
    noun = _asked_noun(words, asked, scene) if asked is not None else ""
    wanted = {"object": objects, "place": places}.get(noun, objects if first == "object" else places)
    if wanted:
        return tuple(wanted)
    if asked is not None:
        fits = _fitting(words[asked + 1 :], scene)
        if fits:
            return fits
    return tuple(objects or places)


def mentioned_in(text: str, scene: Scene) -> tuple[str, ...]:
    """Everything that a text names by an id or a name of its own."""
    objects, places, _ = _names(tokens(text), scene)
    return (*objects, *places)


def _names(words: Sequence[Token], scene: Scene) -> tuple[list[str], list[str], str | None]:
    """The objects and the places that a text names by an id or a name of their own, and which come first."""
    objects: dict[str, None] = {}
    places: dict[str, None] = {}
    first: str | None = None
    i = 0
    while i < len(words):
        for length in range(min(_LONGEST_NAME, len(words) - i), 0, -1):
            parts = words[i : i + length]
            hit = _named(parts, scene)
            if hit is not None:
                movable = scene[hit].movable
                (objects if movable else places).setdefault(hit)
                first = first or ("object" if movable else "place")
                i += length
                break
        else:
            i += 1
    _lists(words, scene, objects, places)
    return list(objects), list(places), first


def _named(parts: Sequence[Token], scene: Scene) -> str | None:
    """The thing that just these words name: with a number, or by a name that nothing else has."""
    if any(t.text in {",", ".", "?", "or", "and", ":", "(", ")"} for t in parts) or parts[0].number is not None:
        return None
    if lexicon().is_(parts[0].text, "articles", "at", "from", "all") or not any(t.word for t in parts):
        return None
    for pool in (scene.objects, scene.places):
        hits = [e for e in pool if _spelt(parts) in e.keys]
        if len(hits) == 1:
            return hits[0].id
    if parts[-1].number is None:
        return None
    ids = _one(parts, scene)
    return ids[0] if len(ids) == 1 else None


def _spelt(parts: Sequence[Token]) -> str:
    return " ".join(t.number if t.number is not None else t.text for t in parts)


def _lists(words: Sequence[Token], scene: Scene, objects: dict[str, None], places: dict[str, None]) -> None:
    """ "Object 1, 2 or 4", "level 1 or 2": the numbers after a noun that has one already."""
    for i, t in enumerate(words):
        if not t.word or i + 1 >= len(words) or words[i + 1].number is None:
            continue
        j = i + 2
        while j < len(words) and (words[j].text in {",", "or", "and"} or words[j].number is not None):
            if words[j].number is not None:
                noun = t if not t.text.endswith("s") else replace(t, text=t.text[:-1])
                for id_ in _one((noun, words[j]), scene)[:1]:
                    (objects if scene[id_].movable else places).setdefault(id_)
            j += 1


def _asked_noun(words: Sequence[Token], asked: int, scene: Scene) -> str:
    """What "which" asks for: an object, a place, or neither to be told from its words."""
    for t in words[asked + 1 : asked + 6]:
        if not t.word or t.number is not None:
            continue
        if t.text in {"do", "should", "would", "shall", "is", "are", "did"}:
            break
        as_object, as_place = scene.word(t, True), scene.word(t, False)
        in_objects = bool(as_object.text) and not as_object.corrected and as_object.text not in scene.colours
        in_places = bool(as_place.text) and not as_place.corrected
        if in_objects != in_places:
            return "object" if in_objects else "place"
    return ""


def _fitting(after: Sequence[Token], scene: Scene) -> tuple[str, ...]:
    """ "Which green block": all of them."""
    stop = next(
        (
            i
            for i, t in enumerate(after)
            if not t.word or t.text in {"do", "should", "would", "shall", "is", "are", "of"}
        ),
        len(after),
    )
    nouns = [t for t in after[:stop] if t.number is None]
    for length in range(min(len(nouns), 4), 0, -1):
        parts = nouns[:length]
        every = (Token("all", parts[0].start, parts[0].start), *parts)
        for resolve in (resolve_objects, resolve_places):
            found = resolve(every, scene, Talk())
            if isinstance(found, Found) and len(found.ids) > 1 and not found.corrected:
                return found.ids
    return ()


def _destinations(scene: Scene) -> tuple[str, ...]:
    """Every place that a thing may be put on, and every place that has such in it."""
    slots = [
        slot.type
        for t in scene.library.templates.values()
        if shape_of(t, scene.library) is Shape.PLACE and (slot := t.param(Role.DESTINATION)) is not None
    ]
    found = [e.id for e in scene.places if any(scene.is_a(e.id, s) or scene.spots(e.id, s) for s in slots)]
    return tuple(sorted(found, key=natural))
