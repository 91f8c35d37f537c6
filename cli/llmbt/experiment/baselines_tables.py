"""What the comparison of methods comes to: success by disturbance, paired differences, and what each costs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import median
from typing import Any

from llmbt.experiment.scenario import CELLS, LIMITS, UNSOLVABLE_CELLS
from llmbt.experiment.statistics import holm, mcnemar, median_time
from llmbt.experiment.tables import Table, rate, share
from llmbt_runtime.baselines import EXECUTORS, STEPS_ONLY

__all__ = ["NOT_RUN", "OURS", "baseline_tables", "solved", "time_tables"]

Line = Mapping[str, Any]
OURS = "loop"
LLM = "replanning by a language model"
NOT_RUN = (
    f"{LLM.capitalize()} is not run: there is no model to ask here, and authored replies would only show what their "
    "author knows."
)
_TIE = (
    "A monitor that plans anew (`chain`) reaches what ours reaches, as it should: what differs is how often it plans, "
    "how long, and how much of the tree it changes."
)


def solved(line: Line) -> bool:
    """Whether the case's condition holds in the end, by the truth at rest."""
    return bool(line["verdict"] == "success")


def baseline_tables(lines: Sequence[Line], world: str) -> tuple[Table, ...]:
    """The tables of one world; none where nothing was run in it."""
    mine = [x for x in lines if x["world"] == world and x["cell"] in CELLS]
    never = [x for x in lines if x["world"] == world and x["cell"] in UNSOLVABLE_CELLS]
    tables = (_methods(world), _grid(mine, world), _paired(mine, world), _costs(mine, world)) if mine else ()
    return (*tables, _unsolvable(never, world)) if never else tables


def _cells(lines: Iterable[Line]) -> list[str]:
    there = {x["cell"] for x in lines}
    return [c for c in CELLS if c in there]


def _names(lines: Iterable[Line]) -> list[str]:
    there = {x["method"] for x in lines}
    return [m for m in EXECUTORS if m in there]


def _title(world: str) -> str:
    return {"symbolic": "in the world of facts", "bullet": "in physics"}[world]


def _methods(world: str) -> Table:
    limits = LIMITS[world]
    return Table(
        f"{world}_methods",
        f"The methods compared {_title(world)}",
        ("method", "what it is"),
        tuple((m, text) for m, text in EXECUTORS.items()),
        (
            "All have the same goals, world, skills, seeds and disturbances, and the same limits: "
            f"{limits.ticks} ticks of 0.1 s, {limits.expansions} expansions of a search, {limits.updates} changes of "
            f"the tree, {limits.nodes} nodes. Where something still moves, every method waits before it changes its "
            "tree.",
        ),
    )


def _grid(lines: Sequence[Line], world: str) -> Table:
    cells = _cells(lines)
    rows = []
    for method in _names(lines):
        mine = [x for x in lines if x["method"] == method]
        each = ([x for x in mine if x["cell"] == c] for c in cells)
        shares = (share(sum(map(solved, e)), len(e)) for e in each)
        rows.append((method, rate(sum(map(solved, mine)), len(mine)), *shares))
    rows.append((LLM, "not run", *("–" for _ in cells)))
    return Table(
        f"{world}_success",
        f"Success by disturbance, {_title(world)}",
        ("method", "all (Wilson 95 %)", *cells),
        tuple(rows),
        (
            "Success: the case's condition holds by the truth, at rest; the method's own verdict does not count. "
            + "; ".join(f"{c}: {CELLS[c]}" for c in cells)
            + ".",
            _TIE,
            NOT_RUN,
        ),
    )


def _pairs(lines: Sequence[Line], method: str, cell: str | None) -> tuple[int, int, int]:
    """Scenarios that only ours solved, that only the other did, and all."""
    by: dict[tuple[str, int], dict[str, bool]] = {}
    for x in lines:
        if x["method"] in (OURS, method) and cell in (None, x["cell"]):
            by.setdefault((x["cell"], x["number"]), {})[x["method"]] = solved(x)
    both = [d for d in by.values() if len(d) == 2]
    return (
        sum(d[OURS] and not d[method] for d in both),
        sum(d[method] and not d[OURS] for d in both),
        len(both),
    )


def _paired(lines: Sequence[Line], world: str) -> Table:
    names = [m for m in _names(lines) if m != OURS]
    cells: list[str | None] = [None, *_cells(lines)]
    found = {(m, c): _pairs(lines, m, c) for m in names for c in cells}
    adjusted = dict(zip(found, holm([mcnemar(a, b) for a, b, _ in found.values()]), strict=True))

    def told(method: str, cell: str | None) -> str:
        ours, theirs, n = found[method, cell]
        p = adjusted[method, cell]
        return "–" if not n else f"{ours} : {theirs}" + (f" (p {_p(p)})" if p < 0.05 else "")

    rows = []
    for m in names:
        ours, theirs, n = found[m, None]
        raw, holms = _p(mcnemar(ours, theirs)), _p(adjusted[m, None])
        rows.append((m, f"{ours} : {theirs} of {n}", raw, holms, *(told(m, c) for c in cells[1:])))
    return Table(
        f"{world}_paired",
        f"Each method against ours on the same scenarios, {_title(world)}",
        ("method", "only ours : only it", "McNemar, exact p", "Holm", *_cells(lines)),
        tuple(rows),
        (
            "Scenarios that only ours solved : only the other method solved. In brackets p below 0.05 by McNemar's "
            f"exact test; Holm's adjustment is over the {len(found)} comparisons of this table.",
        ),
    )


def _p(p: float) -> str:
    return f"{p:.3f}" if p >= 0.001 else "< 0.001"


def _costs(lines: Sequence[Line], world: str) -> Table:
    rows = []
    for cell in _cells(lines):
        for method in _names(lines):
            mine = [x for x in lines if x["method"] == method and x["cell"] == cell]
            won = [x for x in mine if solved(x)]
            ended, never = _recovery(mine)
            time = median_time(ended, never)
            no_tree = method in STEPS_ONLY
            rows.append(
                (
                    cell,
                    method,
                    share(len(won), len(mine)),
                    _mean(won, "actions"),
                    _mean(mine, "planner_calls"),
                    "–" if no_tree else _mean(won, "updates"),
                    "–" if no_tree or not won else f"{median(x['nodes'] for x in won):.0f}",
                    "–" if no_tree else _changed(won),
                    "–" if time is None else f"{time:.1f}",
                    share(len(never), len(ended) + len(never)),
                )
            )
    return Table(
        f"{world}_costs",
        f"What each method costs, {_title(world)}",
        (
            "disturbance", "method", "success", "actions", "planner calls", "updates", "nodes", "nodes changed",
            "s to recover", "never",
        ),
        tuple(rows),
        (
            "Actions and updates: means over the trials that succeeded; nodes: the median of the largest tree of each; "
            "planner calls: mean over all trials (calls of the complete search, or whatever makes the whole plan; the "
            "local rule makes none). Nodes changed: median over successes of all nodes added, removed, moved or "
            "changed from the first disturbance on. Seconds (simulated) to recover: Kaplan-Meier median, censored at "
            "the end of the run; never: of the disturbances that came about those that were not recovered from.",
        ),
    )  # fmt: skip


def _unsolvable(lines: Sequence[Line], world: str) -> Table:
    """Of the scenarios in which the thing did happen: a run that was over before it may rightly succeed."""
    rows = []
    for method in _names(lines):
        mine = [x for x in lines if x["method"] == method and x["disturbances"]]
        said = [x for x in mine if x["outcome"] == "UNSOLVABLE"]
        right = [x for x in said if any(x["disturbances"][0][1] in goal for goal in x["blamed"])]
        each = ([x for x in right if x["cell"] == c] for c in UNSOLVABLE_CELLS)
        of = ([x for x in mine if x["cell"] == c] for c in UNSOLVABLE_CELLS)
        rows.append(
            (
                method,
                rate(len(right), len(mine)),
                *(share(len(e), len(o)) for e, o in zip(each, of, strict=True)),
                str(len(said) - len(right)),
                str(sum(map(solved, mine))),
            )
        )
    return Table(
        f"{world}_unsolvable",
        f"What cannot be done any more, {_title(world)}",
        ("method", "says so, and why (Wilson 95 %)", *UNSOLVABLE_CELLS, "another reason", "reached all the same"),
        tuple(rows),
        (
            "Right: the run ends as UNSOLVABLE and names a goal about the thing or the place in question. Counted are "
            "the runs in which it happened. Reached all the same: by another way than the compiled goals say, where a "
            "case leaves one open. " + "; ".join(f"{c}: {told}" for c, told in UNSOLVABLE_CELLS.items()) + ".",
        ),
    )


def _mean(lines: Sequence[Line], name: str) -> str:
    values = [x[name] for x in lines if x[name] is not None]
    return f"{sum(values) / len(values):.1f}" if values else "–"


def _recovery(lines: Sequence[Line]) -> tuple[list[float], list[float]]:
    """How long it took, and of those that never recovered, how long they were watched."""
    happened = [(d, x) for x in lines for d in x["disturbances"]]
    ended = [d[3] - d[2] for d, _ in happened if d[3] is not None]
    return ended, [x["sim_time_s"] - d[2] for d, x in happened if d[3] is None]


def _changed(lines: Sequence[Line]) -> str:
    hit = [(min(d[2] for d in x["disturbances"]), x) for x in lines if x["disturbances"]]
    sizes = [sum(n for at, n in x["changes"] if at >= since) for since, x in hit]
    return f"{median(sizes):.0f}" if sizes else "–"


def time_tables(lines: Sequence[Line], worlds: Iterable[str]) -> tuple[Table, ...]:
    """CPU time spent on planning and updating: the tables that do not repeat, so they are kept apart."""
    return tuple(
        _times([x for x in lines if x["world"] == w], w) for w in worlds if any(x["world"] == w for x in lines)
    )


def _times(mine: Sequence[Line], world: str) -> Table:

    def row(values: Callable[[Line], float], of: Sequence[Line]) -> tuple[str, str]:
        ms = sorted(1000 * values(x) for x in of)
        return f"{median(ms):.1f}", f"{ms[-1]:.1f}"

    rows = []
    for method in _names(mine):
        of = [x for x in mine if x["method"] == method]
        rows.append((method, str(len(of)), *row(lambda x: x["planning_s"], of)))
    return Table(
        f"{world}_planning_time",
        f"CPU time spent on planning and updating in a run, {_title(world)}",
        ("method", "runs", "median ms", "most ms"),
        tuple(rows),
        ("Of one process on a shared machine, grounding included; steps and trees of the first plan too.",),
    )
