"""What the text filter gives: steps, each with its place in the reply, or a question."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from llmbt_ir.diagnostics import Span

__all__ = ["Dropped", "Question", "Step", "Steps"]


@dataclass(frozen=True, slots=True)
class Step:
    """One step: its number in the reply (its place, where it has none), its plain text, and where it stands.

    `start` and `end` are character offsets into the reply, half-open; `line` and `column` count from 1.
    `text` is without markup and line breaks; `runs` are pairs (offset in text, offset in the reply) at which
    the two run side by side anew, so that a part of the text points at its words in the reply.
    """

    number: int
    text: str
    start: int
    end: int
    line: int
    column: int = 1
    runs: tuple[tuple[int, int], ...] = ((0, 0),)

    def origin(self, start: int, end: int) -> tuple[int, int]:
        """The part of the reply from which text[start:end] was taken; start < end."""
        return self._origin(start), self._origin(end - 1) + 1

    def _origin(self, at: int) -> int:
        here, there = self.runs[max(0, bisect_right(self.runs, (at, 1 << 62)) - 1)]
        return there + at - here

    def span(self, start: int = 0, end: int | None = None, source: str = "steps.json") -> Span:
        """The words text[start:end] as diagnostics show them: a line of steps.json, columns from 1."""
        last = len(self.text) if end is None else end
        return Span(source, self.number, start + 1, last + 1, self.text)


@dataclass(frozen=True, slots=True)
class Dropped:
    """What was left out, and why (greeting or remark, explanation, condition, prohibition)."""

    text: str
    start: int
    end: int
    why: str


@dataclass(frozen=True, slots=True)
class Steps:
    """The steps of a reply in their order, and what was left out."""

    steps: tuple[Step, ...]
    dropped: tuple[Dropped, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """The artifact `steps.json`."""
        return {
            "schema_version": 1,
            "steps": [
                {
                    "number": s.number,
                    "text": s.text,
                    "start": s.start,
                    "end": s.end,
                    "line": s.line,
                    "column": s.column,
                    "runs": [list(r) for r in s.runs],
                }
                for s in self.steps
            ],
            "dropped": [{"text": d.text, "start": d.start, "end": d.end, "why": d.why} for d in self.dropped],
        }

    @staticmethod
    def from_json(data: Mapping[str, Any]) -> Steps:
        """The inverse of `as_json`; KeyError, TypeError or ValueError where it is not one."""
        return Steps(
            tuple(
                Step(
                    int(s["number"]),
                    str(s["text"]),
                    int(s["start"]),
                    int(s["end"]),
                    int(s["line"]),
                    int(s.get("column", 1)),
                    tuple((int(a), int(b)) for a, b in s["runs"]),
                )
                for s in data["steps"]
            ),
            tuple(
                Dropped(str(d["text"]), int(d["start"]), int(d["end"]), str(d["why"])) for d in data.get("dropped", ())
            ),
        )


@dataclass(frozen=True, slots=True)
class Question:
    """The model asks back instead of giving steps. `candidates` are names that it lists apart from its words."""

    text: str
    start: int
    end: int
    line: int
    candidates: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """For the artifact, where the reply was a question."""
        asked: dict[str, Any] = {"text": self.text, "start": self.start, "end": self.end, "line": self.line}
        if self.candidates:
            asked["candidates"] = list(self.candidates)
        return {"schema_version": 1, "question": asked}
