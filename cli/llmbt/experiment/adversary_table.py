"""What broke which method: for each the simplest event found, and what the others make of that event."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from llmbt.experiment.baselines_tables import OURS, solved
from llmbt.experiment.scenario import ATTACKS
from llmbt.experiment.tables import Table, rate, share
from llmbt_runtime.baselines import EXECUTORS

__all__ = ["adversary_tables"]

Line = Mapping[str, Any]


def adversary_tables(lines: Sequence[Line]) -> tuple[Table, ...]:
    """Two tables, or none where nothing was searched for."""
    mine = [x for x in lines if x["cell"] in ATTACKS]
    if not mine:
        return ()
    by: dict[tuple[str, int], dict[str, Line]] = {}
    for x in mine:
        by.setdefault((x["cell"], x["number"]), {})[x["method"]] = x
    fired = [d for d in by.values() if any(x["disturbances"] for x in d.values())]
    solvable = [d for d in fired if any(map(solved, d.values()))]
    methods = [m for m in EXECUTORS if any(m in d for d in fired)]
    return _counts(mine, solvable, fired, methods), _breaking(solvable, methods)


def _counts(
    lines: Sequence[Line], solvable: list[dict[str, Line]], fired: list[dict[str, Line]], methods: list[str]
) -> Table:
    rows = []
    for m in methods:
        mine = [d[m] for d in solvable if m in d]
        won = sum(map(solved, mine))
        each = ([x for x in mine if x["cell"] == c] for c in ATTACKS)
        rows.append((m, rate(won, len(mine)), *(share(sum(map(solved, e)), len(e)) for e in each)))
    n = len({(x["cell"], x["number"]) for x in lines})
    return Table(
        "adversarial_success",
        "Success against events made to break a method, in the world of facts",
        ("method", "all (Wilson 95 %)", *(c.replace("_", " ") for c in ATTACKS)),
        tuple(rows),
        (
            f"{n} scenarios drawn; in {len(fired)} of them an event came about under some method, and {len(solvable)} "
            "of these were solved by some method, so that they can be; those are counted here.",
        ),
    )


def _breaking(solvable: list[dict[str, Line]], methods: list[str]) -> Table:
    rows = []
    for m in methods:
        broken = [d for d in solvable if m in d and not solved(d[m])]
        if not broken:
            rows.append((m, "none found", "", ""))
            continue
        simplest = min(broken, key=_simplicity)
        rest = [o for o in methods if o != m and o in simplest]
        others = [o for o in rest if solved(simplest[o])]
        rows.append((m, _says(simplest[m]), simplest[m]["reason"], _list(others, rest)))
    return Table(
        "adversarial_events",
        "The simplest event found that breaks each method",
        ("method", "what happens", "how it ends", "who succeeds all the same"),
        tuple(rows),
        ("Simplest: fewest events, then those that most methods survive. Found by trying, not proved to be least.",),
    )


def _simplicity(scenario: dict[str, Line]) -> tuple[int, int, int]:
    any_line = next(iter(scenario.values()))
    return ATTACKS[any_line["cell"]], -sum(map(solved, scenario.values())), any_line["number"]


def _says(line: Line) -> str:
    return f"{line['case']}: " + "; ".join(str(event[0]) for event in line["events"])


def _list(some: list[str], rest: list[str]) -> str:
    if len(some) == len(rest):
        return "all others"
    return ", ".join(some) + (f" (ours {'too' if OURS in some else 'not'})" if OURS in rest else "")
