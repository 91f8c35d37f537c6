"""The rows as tables to read."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from statistics import fmean, median

from llmbt_runtime.baselines import METHODS
from llmbt_runtime.episodes import EVENTS, KINDS
from llmbt_runtime.outcome import Outcome
from tests.suite.measure import Row
from tests.suite.scenes import scenes


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
        unknown = [r for r in mine if r.solvable is None]
        body.append(
            (
                m,
                share((r for r in mine if r.solvable is True), lambda r: r.solved),
                share((r for r in mine if r.solvable is False), lambda r: r.right),
                f"{sum(r.solved for r in unknown)} + {sum(r.right for r in unknown)} / {len(unknown)}",
                sum(r.wrong for r in mine),
                sum(r.stuck for r in mine),
                sum(r.outcome is Outcome.BUDGET and not r.stuck for r in mine),
                sum(r.reason.startswith("a tree of") for r in mine),
                sum(r.outcome is Outcome.ACTION_FAILED for r in mine),
                f"{median(r.nodes for r in won):.0f}" if won else "-",
                f"{fmean(r.actions for r in won):.1f}" if won else "-",
                f"{fmean(r.planner_calls for r in mine):.2f}",
                f"{fmean(r.ms for r in mine):.1f}",
            )
        )
    head = (
        "method", "solved / solvable", "UNSOLVABLE / unsolvable", "solved + UNSOLVABLE / open", "wrong verdicts",
        "stuck", "budget", "of it nodes", "ACTION_FAILED", "nodes (median)",
        "actions (mean)", "planner calls (mean)", "ms (mean)",
    )  # fmt: skip
    return table(head, body)


def same(rows: list[Row]) -> str:
    """Nodes and actions on the problems that all of the better methods solved, so that they can be compared."""
    methods = [m for m in _methods(rows) if not m.startswith("paper")]
    by_problem: dict[tuple[object, ...], dict[str, Row]] = {}
    for r in rows:
        by_problem.setdefault((r.kind, r.events, r.rough, r.seed), {})[r.method] = r
    all_won = [d for d in by_problem.values() if all(m in d and d[m].solved for m in methods)]
    if not all_won or len(methods) < 2:
        return ""
    body = [
        (
            m,
            f"{median(d[m].nodes for d in all_won):.0f}",
            f"{fmean(d[m].nodes for d in all_won):.1f}",
            max(d[m].nodes for d in all_won),
            f"{fmean(d[m].actions for d in all_won):.1f}",
        )
        for m in methods
    ]
    head = ("method", "nodes (median)", "nodes (mean)", "nodes (most)", "actions (mean)")
    return f"On the {len(all_won)} problems that {', '.join(methods)} all solved:\n\n" + table(head, body)


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
    """Of the whole loop: a line for each kind and number of events."""
    body = []
    for kind in KINDS:
        for events in EVENTS:
            mine = [r for r in rows if r.kind == kind and r.events == events and r.method == "loop"]
            if mine:
                body.append(
                    (
                        kind,
                        events,
                        f"{fmean(r.fired for r in mine):.1f}",
                        f"{fmean(r.failed for r in mine):.1f}",
                        f"{median(r.nodes for r in mine):.0f}",
                        max(r.nodes for r in mine),
                        f"{fmean(r.actions for r in mine):.1f}",
                        f"{fmean(r.updates for r in mine):.2f}",
                        f"{fmean(r.moves for r in mine):.2f}",
                        f"{fmean(r.planner_calls for r in mine):.2f}",
                        sum(r.linked for r in mine),
                        sum(r.chained for r in mine),
                        f"{fmean(r.ms for r in mine):.1f}",
                    )
                )
    head = (
        "kind", "events", "fired", "failures", "nodes (median)", "nodes (most)", "actions", "updates", "moves",
        "planner calls", "links", "chains", "ms",
    )  # fmt: skip
    return table(head, body)


def readability() -> str:
    """Nodes on the paper's scenes beside the smallest tree by hand."""
    body = []
    for s in scenes():
        nodes = len(s.grown())
        body.append((s.name, nodes, len(s.by_hand), f"{nodes / len(s.by_hand):.2f}"))
    return table(("scene", "certified tree", "by hand", "ratio"), body)


def document(rows: list[Row], problems: int, seconds: float, cpu: float, generating: float) -> str:
    """The whole report."""
    mine = [r for r in rows if r.method == "loop"]
    broken = [v for r in mine for v in r.violations]
    per_minute = 60_000 / fmean(r.ms for r in mine) if mine else 0
    methods = "\n".join(f"- `{m}`: {METHODS[m]}" for m in _methods(rows))
    kinds = "\n".join(f"- `{k}`: {KINDS[k][1]}" for k in KINDS if any(r.kind == k for r in rows))
    return HEAD.format(
        problems=problems,
        runs=len(rows),
        cpu=f"{cpu / 60:.1f}",
        minutes=f"{seconds / 60:.1f}",
        generating=f"{generating:.0f}",
        per_minute=f"{per_minute:,.0f}",
        violations=len(broken),
        loops=len(mine),
        verified=sum(r.verified for r in mine),
        methods=methods,
        kinds=kinds,
        summary=summary(rows),
        same=same(rows),
        solved=grid(rows, True, lambda r: r.solved),
        unsolvable=grid(rows, False, lambda r: r.right),
        costs=costs(rows),
        scenes=readability(),
    )


HEAD = """# The suite

Written by `python -m tests.suite --write`; nothing here is typed in. All of it is in the symbolic world: facts, exact
effects, events on a schedule. It says how methods update a tree, nothing about physics.

{problems} problems, {runs} runs: {cpu} minutes of one core, {minutes} minutes by the clock of a busy machine (of that
{generating} s for making and labelling the problems).
The whole loop does {per_minute} episodes a minute (CPU time of one process, grounding and search included).
**Violations of what is claimed of the whole loop: {violations} in {loops} runs.**

## What is measured

{methods}

{kinds}

Each kind comes with 0, 1, 3 and 10 dated events (somebody's legal actions, things that move, fall, turn up, facts that
change), and each of these with actions of one tick that never fail, and with actions of 1 to 8 ticks of which one in
ten fails. An event fires at the first tick from its date on at which it can; some come too late.
They are chosen so that they could happen if all went well until then, at most four different ones in an episode.

*Solvable*: whoever keeps clear of dead ends of his own making reaches the goals, whatever the events do and whenever
they fire. *Unsolvable*: no actions and events together reach them. *Open*: it depends on what happens when; there a
verdict is judged from the state in which it was given. {verified} of {loops} labels come from looking at every state
(`episodes/truth.py`, which uses nothing of the search), the others from how the problem was made (more than 6,000
states). *Stuck*: the method knows no further change and claims nothing. *Budget*: 600 ticks, 100 changes of the tree,
1,000 nodes or 20,000 expansions. Ten failures in a row exclude an action here, not three: these failures are dice.

Checked of every run of the whole loop: no more actions after the last event or failure than the certificate from there
lists, and those; searches made (counted outside) at most one, and one for each event and failure, times the
alternatives of the goals; every installed version, restarted from its state in a fresh world, reaches the goals by the
certificate's actions without a change; no node lost but by a version that says so; SUCCESS on every solvable problem;
UNSOLVABLE exactly where looking at every state says so.

## Outcomes

{summary}
{same}
`paper` is Algorithm 1 as printed. What breaks it is listed in `baselines/paper.py`; with two goals of one condition its
same-type rule puts the second goal's subtree into the first's, where it is not ticked any more once the first holds.

### Solved, of the solvable

{solved}
### UNSOLVABLE, of the unsolvable

{unsolvable}
### The whole loop

`moves`: subtrees moved by the local rule, and goals that came before others, in the versions of a run. `links` and
`chains`: runs with a version made of a plan, along its causal links, or as a chain where these do not nest.

{costs}
## Readability

Nodes of the certified trees on the paper's scenes, beside the smallest tree in the same shape that a person would write
(`tests/suite/minimal/*.txt`; each of those is rolled out, too). The disturbances happen to an installed tree, which
keeps what it has: a dropped object gets a further way to be picked up.

{scenes}"""
