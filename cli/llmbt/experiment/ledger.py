"""What an experiment has found so far: one append-only file, a line a trial, that can be read while it grows."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from llmbt.folders import fresh_folder
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span
from llmbt_ir.versions import write_atomic

__all__ = ["PLAN", "TRIALS", "Ledger", "read_plan", "read_trials"]

PLAN, TRIALS = "plan.json", "trials.jsonl"


class Ledger:
    """The results in a folder. One process writes; lines are whole, on the disk once `add` returns, never changed."""

    def __init__(self, folder: Path, lines: Mapping[str, Mapping[str, Any]]) -> None:
        self.folder = folder
        self.lines = dict(lines)

    @classmethod
    def begin(cls, folder: Path, header: Mapping[str, Any], *, force: bool = False) -> Ledger:
        """An empty ledger for a plan, in an empty folder. E010 where it is not empty."""
        fresh_folder(folder, force=force)
        write_atomic(folder / PLAN, (json.dumps(header, indent=1, ensure_ascii=False) + "\n").encode())
        return cls(folder, {})

    @classmethod
    def go_on(cls, folder: Path, header: Mapping[str, Any]) -> Ledger:
        """The ledger of a plan that was begun: the very same plan. E404 where it is another, or none.

        A last line that is not whole is what a kill leaves; it is taken away, and its trial is run again.
        """
        begun = read_plan(folder)
        other = sorted(k for k in {*begun, *header} if begun.get(k) != header.get(k))
        if other:
            raise LlmbtError(
                Diagnostic(
                    "E404",
                    f"`{folder}` holds another plan: {', '.join(other)} differ",
                    Span(str(folder / PLAN)),
                    help="resume with the options it was begun with, or give another folder",
                ),
                exit_code=ExitCode.USAGE,
            )
        path = folder / TRIALS
        if path.exists():
            data = path.read_bytes()
            whole = data.rfind(b"\n") + 1
            if whole < len(data):
                with path.open("r+b") as file:
                    file.truncate(whole)
        return cls(folder, {str(line["key"]): line for line in read_trials(folder)})

    def add(self, line: Mapping[str, Any]) -> None:
        """Append a trial's line. ValueError where the trial is there already: none is counted twice."""
        key = str(line["key"])
        if key in self.lines:
            raise ValueError(f"the trial {key} is there already")
        whole = json.dumps(line, ensure_ascii=False) + "\n"
        with (self.folder / TRIALS).open("ab", buffering=0) as out:
            out.write(whole.encode())
            os.fsync(out.fileno())
        self.lines[key] = line


def read_plan(folder: Path) -> Mapping[str, Any]:
    """The plan of an experiment's folder. E405 where it is no such folder."""
    try:
        found = json.loads((folder / PLAN).read_bytes())
    except (OSError, ValueError):
        found = None
    if not isinstance(found, dict) or "kind" not in found:
        hint = "give the folder that an `llmbt experiment` was run into"
        raise LlmbtError(Diagnostic("E405", f"`{folder}` holds no experiment", Span(str(folder)), help=hint))
    return found


def read_trials(folder: Path) -> Iterator[Mapping[str, Any]]:
    """The whole lines of a ledger, in the order in which the trials ended. E406 a line that is none."""
    path = folder / TRIALS
    if not path.exists():
        return
    for number, line in enumerate(path.read_bytes().split(b"\n")[:-1], 1):
        try:
            found = json.loads(line)
            found["key"]
        except (ValueError, TypeError, KeyError):
            title = "a line of the ledger is damaged"
            raise LlmbtError(Diagnostic("E406", title, Span(str(path), number), help="remove the line")) from None
        yield found
