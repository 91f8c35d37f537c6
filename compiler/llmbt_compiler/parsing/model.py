"""What goes into the parser and what comes out: labelled steps, goals, notes, diagnostics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from llmbt_compiler.keywords.labels import KeywordSpan, Reading, TaggedStep
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import Diagnostic, ExitCode, Severity

__all__ = ["Extent", "Goal", "LabelledStep", "Move", "Note", "NoteKind", "ParseResult", "exit_code_of"]

_CODES = {
    "E304": ExitCode.UNCLEAR,
    "E305": ExitCode.UNCLEAR,
    "E307": ExitCode.UNCLEAR,
    "E308": ExitCode.NO_SUCCESS,
    "E309": ExitCode.UNCLEAR,
    "E312": ExitCode.UNCLEAR,
    "E314": ExitCode.UNCLEAR,
    "E343": ExitCode.NO_SUCCESS,
}


@dataclass(frozen=True, order=True, slots=True)
class Extent:
    """Characters `start` to `end` (exclusive), counted from 0."""

    start: int
    end: int

    def cut(self, text: str) -> str:
        """What it covers."""
        return text[self.start : self.end]

    def __or__(self, other: Extent) -> Extent:
        return Extent(min(self.start, other.start), max(self.end, other.end))


@dataclass(frozen=True, slots=True)
class LabelledStep:
    """One step with its keywords. `confidence` is the tagger's for the step; None: that of its worst keyword.

    `reply` is where the step stands in the reply, as the text filter says it; `runs` its pairs (offset in the
    text, offset in the reply) at which the two run side by side anew, where the filter changed the text.
    """

    number: int
    text: str
    spans: tuple[KeywordSpan, ...] = ()
    confidence: float | None = None
    reply: Extent | None = None
    runs: tuple[tuple[int, int], ...] = ()
    readings: tuple[Reading, ...] = ()

    @classmethod
    def of(
        cls, number: int, tagged: TaggedStep, reply: Extent | None = None, runs: tuple[tuple[int, int], ...] = ()
    ) -> LabelledStep:
        """A step as the tagger labelled it."""
        return cls(number, tagged.text, tagged.spans, tagged.confidence, reply, runs, tagged.readings)

    @property
    def certainty(self) -> float:
        """From 0 to 1."""
        if self.confidence is not None:
            return self.confidence
        return min((s.confidence for s in self.spans), default=1.0)

    def in_reply(self, extent: Extent) -> Extent | None:
        """A part of the step, in the reply; the whole step where the filter changed its text and left no
        runs.
        """
        if self.reply is None:
            return None
        if self.runs and extent.end > extent.start:
            return Extent(self._there(extent.start), self._there(extent.end - 1) + 1)
        if self.reply.end - self.reply.start != len(self.text):
            return self.reply
        return Extent(self.reply.start + extent.start, self.reply.start + extent.end)

    def _there(self, at: int) -> int:
        here, there = max((r for r in self.runs if r[0] <= at), default=(0, 0))
        return there + at - here


@dataclass(frozen=True, slots=True)
class Goal:
    """A condition to be brought about, and the words it came from: `span` in the step,
    `reply` in the reply.
    """

    condition: Condition
    step_number: int
    words: str
    span: Extent
    reply: Extent | None = None


class NoteKind(StrEnum):
    """Why a note is given."""

    LEFT_OUT = "left out"
    CHOSEN = "chosen"
    MOVED_AGAIN = "moved again"
    CORRECTED = "read as"
    INFERRED = "inferred"


@dataclass(frozen=True, slots=True)
class Note:
    """Something the user should be told that stops nothing."""

    step_number: int
    kind: NoteKind
    text: str
    span: Extent = Extent(0, 0)


@dataclass(frozen=True, slots=True)
class Move:
    """What a step does with an object: to this place. `chosen`: the step named no place but one that contains it."""

    target: str
    place: str
    goal: Goal
    chosen: bool = False


@dataclass(frozen=True, slots=True)
class ParseResult:
    """The goals in the order of the steps. With an error among the diagnostics they are
    not to be built on. `moves` are all that the steps do with objects, also what later steps undo.
    """

    goals: tuple[Goal, ...] = ()
    notes: tuple[Note, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    moves: tuple[Move, ...] = ()

    def errors(self) -> Iterator[Diagnostic]:
        """The diagnostics that forbid a tree."""
        return (d for d in self.diagnostics if d.severity is Severity.ERROR)

    @property
    def ok(self) -> bool:
        """Whether a tree may be built."""
        return next(self.errors(), None) is None

    @property
    def conditions(self) -> tuple[Condition, ...]:
        """The goals' conditions, in order."""
        return tuple(g.condition for g in self.goals)

    @property
    def exit_code(self) -> ExitCode:
        """0, or the answer that settles most: bad input before an impossibility, which no answer mends, before a
        question."""
        codes = {exit_code_of(d) for d in self.errors()}
        order = (ExitCode.BAD_INPUT, ExitCode.NO_SUCCESS, ExitCode.UNCLEAR)
        return next((c for c in order if c in codes), ExitCode.OK)


def exit_code_of(diagnostic: Diagnostic) -> ExitCode:
    """The process's answer to one diagnostic: an unknown name with something near to it is a question (5)."""
    if diagnostic.code in {"E301", "E302"} and diagnostic.candidates:
        return ExitCode.UNCLEAR
    return _CODES.get(diagnostic.code, ExitCode.BAD_INPUT)
