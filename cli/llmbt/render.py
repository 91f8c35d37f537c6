"""How a person and a machine meet a diagnostic: one renderer for each."""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Iterable
from typing import Any

from llmbt_ir.diagnostics import Diagnostic, ExitCode, Severity, Span

__all__ = ["diagnostic_json", "internal_error", "print_json", "render", "report", "usage_json"]

SCHEMA_VERSION = 1
COLOURS = {Severity.ERROR: "31;1", Severity.WARNING: "33;1", Severity.NOTE: "36;1"}


def _colour(text: str, code: str, wanted: bool) -> str:
    return f"\x1b[{code}m{text}\x1b[0m" if wanted else text


def _where(span: Span) -> str:
    parts = [span.source]
    if span.line:
        parts.append(f"line {span.line}")
    if span.column:
        parts.append(f"columns {span.column}-{max(span.column, span.end_column - 1)}")
    return ", ".join(parts)


def _safe(text: str) -> str:
    """Text that cannot steer a terminal: control characters are shown, not sent."""
    return "".join(c if c.isprintable() or c == "\t" else f"\\x{ord(c):02x}" for c in text)


def render(diagnostic: Diagnostic, *, colour: bool = False) -> str:
    """A diagnostic as text: code and title, the place with its line, the help."""
    head = _colour(f"{diagnostic.severity.value}[{diagnostic.code}]", COLOURS[diagnostic.severity], colour)
    lines = [f"{head}: {_safe(diagnostic.title)}"]
    span = diagnostic.span
    if span is not None:
        lines.append(f"  --> {_safe(_where(span))}")
        if span.text:
            number = str(span.line) if span.line else ""
            gutter = " " * len(number)
            lines.append(f"{number} | {_safe(span.text)}")
            if span.column:
                marks = "^" * max(1, span.end_column - span.column)
                lines.append(f"{gutter} | {' ' * (span.column - 1)}{marks} {_safe(diagnostic.label)}".rstrip())
    lines += [f"note: {_safe(n)}" for n in diagnostic.notes]
    if diagnostic.candidates and not diagnostic.help:
        lines.append(f"candidates: {', '.join(_safe(c) for c in diagnostic.candidates)}")
    if diagnostic.help:
        lines.append(f"help: {_safe(diagnostic.help)}")
    return "\n".join(lines)


def diagnostic_json(diagnostic: Diagnostic) -> dict[str, Any]:
    """A diagnostic for machines. Lines and columns count from 1, 0 stands for none."""
    span = diagnostic.span
    return {
        "code": diagnostic.code,
        "severity": diagnostic.severity.value,
        "title": diagnostic.title,
        "label": diagnostic.label,
        "help": diagnostic.help,
        "notes": list(diagnostic.notes),
        "candidates": list(diagnostic.candidates),
        "span": None
        if span is None
        else {
            "source": span.source,
            "line": span.line,
            "column": span.column,
            "end_column": span.end_column,
            "text": span.text,
        },
    }


def print_json(document: dict[str, Any], exit_code: int, diagnostics: Iterable[Diagnostic] = ()) -> None:
    """The one document that `--json` prints."""
    whole = {
        "schema_version": SCHEMA_VERSION,
        "exit_code": int(exit_code),
        "diagnostics": [diagnostic_json(d) for d in diagnostics],
        **document,
    }
    print(json.dumps(whole, ensure_ascii=False, indent=1))


def report(diagnostics: Iterable[Diagnostic], exit_code: ExitCode, *, as_json: bool) -> None:
    """Tell what went wrong, on stderr or as JSON on stdout."""
    if as_json:
        print_json({}, exit_code, diagnostics)
        return
    colour = sys.stderr.isatty() and not os.environ.get("NO_COLOR")
    print("\n\n".join(render(d, colour=colour) for d in diagnostics), file=sys.stderr)


def usage_json(message: str) -> None:
    """A usage fault as JSON."""
    report((Diagnostic("E000", message, help="see `llmbt --help`"),), ExitCode.USAGE, as_json=True)


def internal_error(*, as_json: bool) -> None:
    """Our own bug: say so, and how to report it. The traceback goes to a file of the user's choosing, or stderr."""
    trace = traceback.format_exc()
    last = trace.strip().splitlines()[-1]
    wanted = os.environ.get("LLMBT_TRACEBACK")
    hint = "set LLMBT_TRACEBACK=FILE and run again, then open an issue with the command and that file"
    if wanted:
        with open(wanted, "a", encoding="utf-8") as out:  # noqa: PTH123
            out.write(trace)
        hint = f"the traceback is in {wanted}; open an issue with it and the command"
    fault = Diagnostic("E070", f"this is a bug in llmbt, not in your input: {last}", help=hint)
    report((fault,), ExitCode.INTERNAL, as_json=as_json)
