"""Questions to the user: from the model's own words, from the parser's complaints, from the check of the request."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from llmbt_atl.library import Library
from llmbt_atl.template import Role
from llmbt_compiler.asking.offered import offered
from llmbt_compiler.checking.points import OpenPoint
from llmbt_compiler.parsing import exit_code_of
from llmbt_compiler.parsing.mentions import one_named
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.verbs import Shape, shape_of
from llmbt_compiler.parsing.words import tokens
from llmbt_compiler.reasoning.steps import Question
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Severity, Span
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["Asked", "Slot", "from_diagnostics", "from_model", "from_request"]

_ANSWER = "answer with --answer TEXT"
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
    if not candidates and (slot in {Slot.DESTINATION, Slot.PUT_DOWN} or first.title.endswith("no place named before")):
        candidates = _destinations(scene)
    if not candidates and (slot is Slot.TARGET or first.label == "what?"):
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
    if diagnostic.title.endswith(("points to nothing named before", "points to no place named before")):
        return Slot.WORDS
    return Slot.TARGET if diagnostic.label == "what?" else Slot.DESTINATION


def from_request(point: OpenPoint, semantic_map: SemanticMap, library: Library) -> Asked:
    """What the check of the request found open; where a place is, any that something may be put on answers it."""
    d = point.diagnostic
    if d.code == "E305":
        d = replace(d, candidates=_destinations(Scene(semantic_map, library)))
    told = replace(d, help=f"{d.help}; {_ANSWER}" if d.help else _ANSWER)
    return Asked(told, Slot.REQUEST, d.candidates, taken=point.taken)


def from_model(question: Question, semantic_map: SemanticMap, library: Library) -> Asked:
    """The model's own question. Its candidates are those that it lists or names, or else what its `which` fits."""
    scene = Scene(semantic_map, library)
    listed = [i for name in question.candidates for i in one_named(tokens(name), scene)]
    named, movable = offered(question.text, scene)
    candidates = tuple(dict.fromkeys(listed)) or named
    if not candidates and movable is not None:
        candidates = tuple(sorted((e.id for e in scene.objects), key=natural)) if movable else _destinations(scene)
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


def _destinations(scene: Scene) -> tuple[str, ...]:
    """Every place that a thing may be put on, and every place that has such in it."""
    slots = [
        slot.type
        for t in scene.library.templates.values()
        if shape_of(t, scene.library) is Shape.PLACE and (slot := t.param(Role.DESTINATION)) is not None
    ]
    found = [e.id for e in scene.places if any(scene.is_a(e.id, s) or scene.spots(e.id, s) for s in slots)]
    return tuple(sorted(found, key=natural))
