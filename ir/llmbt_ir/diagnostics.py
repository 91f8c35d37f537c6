"""Errors as values: a stable code, the place it is about, and a suggestion. Lines and columns count from 1."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum, StrEnum

__all__ = ["Diagnostic", "ExitCode", "LlmbtError", "Severity", "Span", "nearest"]


class ExitCode(IntEnum):
    """What the process tells its caller."""

    OK = 0
    BAD_INPUT = 1
    USAGE = 2
    NO_SUCCESS = 3
    NO_RECORDING = 4
    UNCLEAR = 5
    DIFFERENCES = 6
    INTERNAL = 70
    INTERRUPTED = 130


class Severity(StrEnum):
    """How much a diagnostic weighs."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Span:
    """A place in a file. `column` to `end_column` (exclusive) on `line`; `text` is that line, where it helps.

    `line` 0 stands for the file as a whole; `column` 0 for the whole line.
    """

    source: str
    line: int = 0
    column: int = 0
    end_column: int = 0
    text: str = ""


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One complaint. Codes never change their meaning once released (docs/diagnostics.md lists them)."""

    code: str
    title: str
    span: Span | None = None
    label: str = ""
    help: str = ""
    severity: Severity = Severity.ERROR
    candidates: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


class LlmbtError(Exception):
    """Carries diagnostics to the edge, where they are rendered; `exit_code` is the process's answer."""

    def __init__(self, *diagnostics: Diagnostic, exit_code: ExitCode = ExitCode.BAD_INPUT) -> None:
        super().__init__("; ".join(f"{d.code}: {d.title}" for d in diagnostics))
        self.diagnostics = diagnostics
        self.exit_code = exit_code


def nearest(word: str, vocabulary: Iterable[str], n: int = 3) -> tuple[str, ...]:
    """The words of a vocabulary that look most like `word`, best first; empty where none does."""
    pool = {v.lower(): v for v in sorted(vocabulary)}
    return tuple(pool[w] for w in difflib.get_close_matches(word.lower(), list(pool), n=n, cutoff=0.5))
