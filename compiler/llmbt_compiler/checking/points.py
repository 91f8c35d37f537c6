"""Something that a request leaves open, to ask about."""

from __future__ import annotations

from dataclasses import dataclass

from llmbt_ir.diagnostics import Diagnostic

__all__ = ["OpenPoint"]


@dataclass(frozen=True, slots=True)
class OpenPoint:
    """Something to ask about, and what the goals took for it (None: nothing that could be exchanged in them)."""

    diagnostic: Diagnostic
    taken: str | None = None
