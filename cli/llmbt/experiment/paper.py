"""The paper's result tables, with our counts beside its own; and the same trials with everything counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from llmbt.experiment.cases import Experiment, Share
from llmbt.experiment.plan import Setting, factorial, setting_of
from llmbt.experiment.statistics import bootstrap_by_group, median_time
from llmbt.experiment.tables import Table, interval, rate, share
from llmbt.experiment.trial import Verdict

__all__ = ["counts", "in_the_main_setting", "paper_tables"]

Line = Mapping[str, Any]
LEFT_OUT = (Verdict.ACTION, Verdict.RECOGNITION)
"""What the paper does not count: "the success rates of actions and 3D recognition are not taken into account"."""
MOST_TOLD = 60
"""Failures that a table lists."""


def paper_tables(experiment: Experiment, lines: Sequence[Line], seed: int) -> tuple[Table, ...]:
    """All tables of an experiment's trials; `lines` in the order of the plan."""
    settings = {setting_of(x) for x in lines}
    if not settings:
        return ()
    mine = in_the_main_setting(lines)
    main = setting_of(mine[0])
    given = _given(lines)
    tables = [
        _as_the_paper(experiment, [x for x in mine if x["repeat"] == 0], given, main),
        _everything(experiment, mine, given, seed, main),
        _unclear(experiment, mine, given),
        _by_disturbance(mine, given),
        _failures(mine, given),
    ]
    if len(settings) > 1:
        tables.append(_factorial(lines, given))
    return tuple(tables)


def in_the_main_setting(lines: Sequence[Line]) -> list[Line]:
    """Those of one setting, of which all tables but the factorial are: physics, the truth and nominal scenes, or what
    was run that is nearest to it."""

    def far(setting: Setting) -> tuple[bool, bool, bool]:
        return setting.world != "bullet", setting.perception != "truth", setting.scenes != "nominal"

    main = min(map(setting_of, lines), key=far, default=None)
    return [x for x in lines if setting_of(x) == main]


def counts(experiment: Experiment, lines: Sequence[Line]) -> dict[str, Any]:
    """The numbers behind the tables, for `table.json`."""

    def verdicts(case: str, kind: str) -> dict[str, int]:
        return dict(sorted(Counter(x["verdict"] for x in lines if _of(x, case) and x["kind"] == kind).items()))

    return {c.name: {kind: verdicts(c.name, kind) for kind in ("clear", "unclear")} for c in experiment.cases}


def _of(line: Line, case: str) -> bool:
    return bool(line["case"] == case)


def _clear(line: Line) -> bool:
    return bool(line["kind"] == "clear")


def _is(*verdicts: Verdict) -> Callable[[Line], bool]:
    return lambda line: line["verdict"] in verdicts


def _many(lines: Iterable[Line], what: Callable[[Line], bool]) -> int:
    return sum(map(what, lines))


def _given(lines: Sequence[Line]) -> str:
    kinds = sorted({str(x.get("reply", "")) for x in lines} - {""})
    return f"given {' and '.join(kinds)} replies" if kinds else "without replies"


# -- as the paper counts -------------------------------------------------------------------------------------------


def _stages(lines: Sequence[Line]) -> tuple[Share, Share | None, Share, Share]:
    """Overall, reasoning, parser, update as (successes, of so many); reasoning None where nobody's was recorded.

    A parser is only asked what it can be held to: for authored replies those of clear requests, which are right by
    their making. From a recorded reply it cannot be told by itself whether wrong goals are the model's fault or the
    parser's: they count against reasoning there.
    """
    kept = [x for x in lines if not _is(*LEFT_OUT)(x)]
    right = [x for x in lines if x.get("goals_right") and _clear(x)]
    executed = [x for x in right if not _is(*LEFT_OUT)(x)]
    overall = _many(kept, lambda x: _clear(x) and _is(Verdict.SUCCESS)(x)), len(kept)
    update = _many(executed, _is(Verdict.SUCCESS)), len(executed)
    recorded = [x for x in lines if x.get("reply") == "recorded"]
    if recorded:
        good = _many(recorded, lambda x: _clear(x) and bool(x.get("goals_right")))
        return overall, (good, len(lines)), (good, good), update
    clear = [x for x in lines if _clear(x)]
    return overall, None, (len(right), len(clear)), update


def _as_the_paper(experiment: Experiment, lines: Sequence[Line], given: str, setting: Setting) -> Table:
    reported = experiment.reported
    theirs = list(reported.rows) if reported else []
    rows = []
    for k, case in enumerate(experiment.cases):
        row = [share(*s) for s in theirs[k]] if k < len(theirs) else ["–"] * 4
        rows.append((f"{k + 1} {case.name}", *_row([x for x in lines if _of(x, case.name)]), *row))
    sums = [share(sum(r[k][0] for r in theirs), sum(r[k][1] for r in theirs)) for k in range(4)]
    rows.append(("all", *_row(lines), *sums))
    head = ("case", "overall", "reasoning", "parser", "BTs Update", "asked", "refused", "left out")
    notes = [
        "Left out, as in the paper: trials that failed by an action or by recognition. Asked: the compiler asked back, "
        "which is no success; refused: it ended with a diagnostic. A quarter of a case's requests are unclear or wrong "
        "on purpose. Parser: of the clear requests, whose replies are right by their making.",
        f"{setting}. Columns from `reported` on: {reported.by if reported else 'nobody'}; printed as reported, made "
        "with other users, another model, robot and scenes, so nothing is tested against them.",
        *_footnotes(experiment),
    ]
    return Table(
        f"{experiment.name}_as_the_paper",
        f"{experiment.title}, as the paper counts, {given}",
        (*head, "reported: overall", "reasoning", "parser", "BTs Update"),
        tuple(rows),
        tuple(notes),
    )


def _row(lines: Sequence[Line]) -> tuple[str, ...]:
    overall, reasoning, parser, update = _stages(lines)
    left_out = _many(lines, _is(*LEFT_OUT))
    asked, refused = _many(lines, _is(Verdict.ASKED)), _many(lines, _is(Verdict.REFUSED))
    told = share(*reasoning) if reasoning else "authored"
    return rate(*overall), told, rate(*parser), rate(*update), str(asked), str(refused), str(left_out)


def _footnotes(experiment: Experiment) -> list[str]:
    """Where the reported figures do not add up, found by adding, and what the experiment's file says of them."""
    if experiment.reported is None:
        return []
    notes = []
    for k, (overall, reasoning, parser, update) in enumerate(experiment.reported.rows, 1):
        if reasoning[0] != parser[1]:
            notes.append(f"Reported, case {k}: {reasoning[0]} right replies, but {parser[1]} of them parsed.")
        if parser[0] != update[1]:
            notes.append(f"Reported, case {k}: {parser[0]} right trees, but {update[1]} of them executed.")
        if overall[0] != update[0]:
            notes.append(f"Reported, case {k}: {update[0]} executed, but {overall[0]} overall.")
    return [*notes, *experiment.reported.notes]


# -- everything counted --------------------------------------------------------------------------------------------


def _everything(experiment: Experiment, lines: Sequence[Line], given: str, seed: int, setting: Setting) -> Table:
    others = [v for v in Verdict if v is not Verdict.SUCCESS]
    rows = []
    groups: dict[str, list[bool]] = {}
    for k, case in enumerate(experiment.cases, 1):
        mine = [x for x in lines if _of(x, case.name) and _clear(x)]
        groups[case.name] = [_is(Verdict.SUCCESS)(x) for x in mine]
        good = sum(groups[case.name])
        rows.append((f"{k} {case.name}", rate(good, len(mine)), "", *(str(_many(mine, _is(v))) for v in others)))
    clear = [x for x in lines if _clear(x)]
    by_case = interval(*bootstrap_by_group(groups, seed=seed))
    good = _many(clear, _is(Verdict.SUCCESS))
    rows.append(("all", rate(good, len(clear)), by_case, *(str(_many(clear, _is(v))) for v in others)))
    return Table(
        f"{experiment.name}_everything",
        f"{experiment.title}, clear requests, everything counted, {given}",
        ("case", "success (Wilson 95 %)", "bootstrap by case", *(v.value for v in others)),
        tuple(rows),
        (
            f"{setting}. A trial is a success when the case's condition holds by the truth, at rest. All else is a "
            "failure: a question or a diagnostic to a clear request, goals that do not mean the case (parser), the "
            "loop's end short of them (update), actions that failed until nothing led on (action), a claim that the "
            "truth denies (truth), a bug of ours (fault).",
            *experiment.notes,
        ),
    )


def _failures(lines: Sequence[Line], given: str) -> Table:
    """The trials of clear requests that were no success, each with what it says of itself."""
    failed = [x for x in lines if _clear(x) and not _is(Verdict.SUCCESS)(x)]
    return Table(
        "failures",
        f"What failed, {given}",
        ("trial", "disturbance", "verdict", "ended", "what it says"),
        tuple(
            (
                str(x["key"]),
                ", ".join(x.get("drawn", ())) or "–",
                str(x["verdict"]),
                str(x.get("outcome", "–")),
                str(x.get("says") or x.get("reason") or "–")[:200],
            )
            for x in failed[:MOST_TOLD]
        ),
        (f"{len(failed)} trials; the run of each is kept whole in `runs/`.",),
    )


def _unclear(experiment: Experiment, lines: Sequence[Line], given: str) -> Table:
    rows = []
    for name in (*(c.name for c in experiment.cases), None):
        mine = [x for x in lines if not _clear(x) and (name is None or _of(x, name))]
        asked = [x for x in mine if _is(Verdict.ASKED)(x)]
        refused = _many(mine, _is(Verdict.REFUSED))
        acted = _many(mine, lambda x: bool(x.get("actions")))
        rows.append(
            (
                name or "all",
                rate(len(asked) + refused, len(mine)),
                str(_many(asked, lambda x: x.get("by") == "reply")),
                str(_many(asked, lambda x: x.get("by") != "reply")),
                str(refused),
                str(acted),
            )
        )
    return Table(
        f"{experiment.name}_unclear",
        f"{experiment.title}, requests that are unclear or wrong on purpose, {given}",
        (
            "case", "a question or a diagnostic", "the reply asks", "our check asks", "our check refuses",
            "acted all the same",
        ),
        tuple(rows),
        (
            "Where the reply asks, the author of the case wrote the question; only the other columns say something of "
            "this program.",
        ),
    )  # fmt: skip


def _by_disturbance(lines: Sequence[Line], given: str) -> Table:
    """Of the trials that were executed with the right goals."""
    executed = [x for x in lines if x.get("goals_right") and _clear(x)]
    names = sorted({n for x in executed for n in x["drawn"]})
    rows = []
    for name in names:
        mine = [x for x in executed if name in x["drawn"]]
        happened = [d | {"end_s": x["sim_time_s"]} for x in mine for d in x["disturbances"] if d["name"] == name]
        over = [d["recovered_at_s"] - d["fired_at_s"] for d in happened if d["recovered_at_s"] is not None]
        never = [d["end_s"] - d["fired_at_s"] for d in happened if d["recovered_at_s"] is None]
        median = median_time(over, never)
        rows.append(
            (
                name,
                rate(_many(mine, _is(Verdict.SUCCESS)), len(mine)),
                share(len(happened), len(mine)),
                "–" if median is None else f"{median:.1f}",
                str(len(never)),
                _mean([x["updates"] for x in mine]),
                _mean([x["actions"] for x in mine]),
                _mean([x["planner_calls"] for x in mine]),
            )
        )
    return Table(
        "by_disturbance",
        f"By disturbance, {given}",
        (
            "disturbance", "success", "came about", "median s to recover", "of them never", "updates (mean)",
            "actions (mean)", "planner calls (mean)",
        ),
        tuple(rows),
        (
            "One disturbance a trial, drawn by its seed from those that apply, fired on an event of the task. Seconds "
            "(simulated) until what it broke holds again, or the goal about it does (Kaplan-Meier; never: censored at "
            "the end). A disturbance that never came about found no moment for it.",
        ),
    )  # fmt: skip


def _mean(values: Sequence[float]) -> str:
    return f"{sum(values) / len(values):.2f}" if values else "–"


def _factorial(lines: Sequence[Line], given: str) -> Table:
    rows = []
    for setting in factorial():
        mine = [x for x in lines if setting_of(x) == setting and _clear(x)]
        told = rate(_many(mine, _is(Verdict.SUCCESS)), len(mine)) if mine else "not run"
        failed = Counter(str(x["verdict"]) for x in mine if not _is(Verdict.SUCCESS)(x))
        why = ", ".join(f"{n} {v}" for v, n in sorted(failed.items())) or "–"
        rows.append((setting.world, setting.perception, setting.scenes, told, why))
    return Table(
        "factorial",
        f"By what the trials are run in, clear requests, everything counted, {given}",
        ("world", "perception", "scenes", "success", "failures"),
        tuple(rows),
        (
            "The same trials, requests, seeds and disturbances in every line. Physics and camera: conditions and "
            "skills go by what is recognised on the way; facts and camera: the world begins with the facts recognised "
            "before it. Varied: poses, sizes, masses and friction of the things differ from the scene's by the trial's "
            "seed; the request is compiled from the map of the nominal scene, to which its reply was given.",
        ),
    )
