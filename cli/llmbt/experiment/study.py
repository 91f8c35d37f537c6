"""Running a plan: trials go out to the workers, lines come into the ledger, and go on where they were left."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, TypeVar

from llmbt.experiment.ledger import PLAN, TRIALS, Ledger
from llmbt.experiment.workers import Pool, run_all
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span
from llmbt_ir.versions import write_atomic

__all__ = ["Done", "Job", "Study", "run_study"]

Line = Mapping[str, Any]


class Job(Protocol):
    """What a worker gets: picklable, with the trial's name."""

    @property
    def key(self) -> str:
        """The trial's name within its plan."""


J = TypeVar("J", bound=Job)


@dataclass(frozen=True, slots=True)
class Done:
    """What a worker gives back: a line for the ledger, and files for the experiment's folder. A worker needs no folder
    in common with whoever started it. `fault`: what makes the whole experiment stop, with its exit code."""

    key: str
    line: Line = field(default_factory=dict)
    files: Mapping[str, bytes] = field(default_factory=dict)
    fault: tuple[Diagnostic, ...] = ()
    exit_code: ExitCode = ExitCode.BAD_INPUT


@dataclass(frozen=True, slots=True)
class Study:
    """Where and how a plan is run. `header` says which plan it is; a ledger of another cannot be gone on with."""

    folder: Path
    header: Line
    pool: Pool = field(default_factory=Pool)
    resume: bool = False
    force: bool = False
    quiet: bool = False


def run_study(study: Study, jobs: Sequence[J], work: Callable[[J], Done]) -> tuple[Line, ...]:
    """The lines of all trials, in the order of the plan. Those in the ledger already are not run again.

    Files of a trial are on the disk before its line is. Errors: those of the ledger and of the pool, and what a worker
    says makes the whole impossible (a missing recording).
    """
    if study.resume and (study.folder / PLAN).exists():
        ledger = Ledger.go_on(study.folder, study.header)
    else:
        ledger = Ledger.begin(study.folder, study.header, force=study.force)
    keys = {job.key for job in jobs}
    if len(keys) != len(jobs):
        raise ValueError("two trials of a plan have one name")
    strange = ledger.lines.keys() - keys
    if strange:
        title = f"the ledger holds trials that the plan lacks: {', '.join(sorted(strange)[:3])}"
        raise LlmbtError(Diagnostic("E404", title, Span(str(study.folder / TRIALS))), exit_code=ExitCode.USAGE)
    left = [job for job in jobs if job.key not in ledger.lines]
    with _bar(len(jobs), len(ledger.lines), quiet=study.quiet) as show:
        for done in run_all(left, work, study.pool):
            if done.fault:
                raise LlmbtError(*done.fault, exit_code=done.exit_code)
            for name, data in done.files.items():
                write_atomic(study.folder / name, data)
            ledger.add(done.line)
            show(done.line)
    return tuple(ledger.lines[job.key] for job in jobs)


@contextmanager
def _bar(total: int, there: int, *, quiet: bool) -> Iterator[Callable[[Line], None]]:
    """A bar over the trials with the time left, and how they ended, on stderr."""
    if quiet:
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn())
    counts: Counter[str] = Counter()
    with Progress(*columns, TextColumn("{task.description}"), console=Console(file=sys.stderr)) as bar:
        task = bar.add_task("", total=total, completed=there)

        def show(line: Line) -> None:
            counts[str(line.get("verdict", ""))] += 1
            bar.update(task, advance=1, description=", ".join(f"{n} {k}" for k, n in counts.most_common() if k))

        yield show
