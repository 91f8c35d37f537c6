"""The rows as tables to read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from statistics import fmean, median

from llmbt_runtime.baselines import METHODS
from llmbt_runtime.episodes import EVENTS, KINDS
from llmbt_runtime.outcome import Outcome
from tests.suite.measure import Row


def table(head: Sequence[str], body: Iterable[Sequence[object]]) -> str:
    """Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "|".join("---" for _ in head) + "|"]
    lines += ["| " + " | ".join(map(str, row)) + " |" for row in body]
    return "\n".join(lines) + "\n"


def share(rows: Iterable[Row], what: Callable[[Row], bool]) -> str:
    """So many of so many."""
    rows = list(rows)
    return f"{sum(map(what, rows))}/{len(rows)}" if rows else "-"


def _methods(rows: list[Row]) -> list[str]:
    return [m for m in METHODS if any(r.method == m for r in rows)]


def summary(rows: list[Row]) -> str:
    """One line a method."""
    body = []
    for m in _methods(rows):
        mine = [r for r in rows if r.method == m]
        won = [r for r in mine if r.solved]
        body.append(
            (
                m,
                share((r for r in mine if r.solvable is True), lambda r: r.solved),
                share((r for r in mine if r.solvable is False), lambda r: r.right),
                share((r for r in mine if r.solvable is None), lambda r: r.solved),
                sum(r.wrong for r in mine),
                sum(r.stuck for r in mine),
                sum(r.outcome is Outcome.BUDGET and not r.stuck for r in mine),
                f"{median(r.nodes for r in won):.0f}" if won else "-",
                f"{fmean(r.actions for r in won):.1f}" if won else "-",
                f"{fmean(r.planner_calls for r in mine):.2f}",
                f"{fmean(r.ms for r in mine):.1f}",
            )
        )
    head = (
        "method", "solved / solvable", "UNSOLVABLE / unsolvable", "solved / open", "wrong verdicts", "stuck", "budget",
        "nodes (median)", "actions (mean)", "planner calls (mean)", "ms (mean)",
    )  # fmt: skip
    return table(head, body)


def grid(rows: list[Row], solvable: bool, what: Callable[[Row], bool]) -> str:
    """A line for each kind and number of events, a column for each method."""
    methods = _methods(rows)
    body = []
    for kind in KINDS:
        for events in EVENTS:
            cell = [r for r in rows if r.kind == kind and r.events == events and r.solvable is solvable]
            if cell:
                body.append((kind, events, *(share((r for r in cell if r.method == m), what) for m in methods)))
    return table(("kind", "events", *methods), body)


def costs(rows: list[Row]) -> str:
    """Of the whole loop: a line for each kind."""
    body = []
    for kind in KINDS:
        mine = [r for r in rows if r.kind == kind and r.method == "loop"]
        if mine:
            body.append(
                (
                    kind,
                    f"{median(r.nodes for r in mine):.0f}",
                    max(r.nodes for r in mine),
                    f"{fmean(r.actions for r in mine):.1f}",
                    f"{fmean(r.updates for r in mine):.2f}",
                    f"{fmean(r.planner_calls for r in mine):.2f}",
                    f"{fmean(r.ms for r in mine):.1f}",
                    f"{max(r.ms for r in mine):.0f}",
                )
            )
    head = ("kind", "nodes (median)", "nodes (most)", "actions", "updates", "planner calls", "ms", "ms (most)")
    return table(head, body)


def document(rows: list[Row], problems: int, seconds: float, generating: float) -> str:
    """The whole report."""
    mine = [r for r in rows if r.method == "loop"]
    broken = [v for r in mine for v in r.violations]
    per_minute = 60_000 / fmean(r.ms for r in mine) if mine else 0
    return "\n".join(
        [
            f"{problems} problems, {len(rows)} runs, {seconds:.0f} s (making the problems {generating:.0f} s); "
            f"the whole loop: {per_minute:.0f} episodes a minute; violations: {len(broken)}\n",
            summary(rows),
            "solved / solvable\n",
            grid(rows, True, lambda r: r.solved),
            "UNSOLVABLE / unsolvable\n",
            grid(rows, False, lambda r: r.right),
            costs(rows),
        ]
    )
