"""What an experiment's folder holds once trials are in it: tables as numbers and in the forms people want, figures, and
one page with links to every trial."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from llmbt.experiment.adversary_table import adversary_tables
from llmbt.experiment.baselines_tables import baseline_tables, time_tables
from llmbt.experiment.cases import load_experiment
from llmbt.experiment.figures import figures_of
from llmbt.experiment.ledger import read_plan, read_trials
from llmbt.experiment.paper import counts, in_the_main_setting, paper_tables
from llmbt.experiment.study_page import study_page
from llmbt.experiment.tables import Table
from llmbt_ir.versions import write_atomic

__all__ = ["INDEX", "TABLE", "Results", "results_of", "write_results"]

TABLE, TIMING, INDEX = "table.json", "timing.json", "index.html"


@dataclass(frozen=True, slots=True)
class Results:
    """The plan's header, the tables, those of times apart (they do not repeat), and what `--json` prints."""

    header: Mapping[str, Any]
    tables: tuple[Table, ...]
    times: tuple[Table, ...]
    document: Mapping[str, Any]


def results_of(header: Mapping[str, Any], lines: Sequence[Mapping[str, Any]]) -> Results:
    """The tables of a plan's lines, in the plan's order."""
    if header["kind"] == "paper":
        experiment = load_experiment(str(header["source"]))
        tables, times = paper_tables(experiment, lines, int(header["seed"])), tuple[Table, ...]()
        numbers: Mapping[str, Any] = counts(experiment, in_the_main_setting(lines))
    else:
        tables = tuple(t for world in header["worlds"] for t in baseline_tables(lines, world))
        tables, times = tables + adversary_tables(lines), time_tables(lines, header["worlds"])
        numbers = {str(x["key"]): x["verdict"] for x in lines}
    told = {k: v for k, v in header.items() if k not in ("source", "order")}
    return Results(header, tables, times, {**told, "tables": [t.as_json() for t in tables], "counts": numbers})


def write_results(folder: Path) -> Results:
    """Write `table.json`, `timing.json`, `tables/`, `figures/` and `index.html` from the folder's plan and ledger.

    The same trials give the same bytes of `table.json`: no time of day, no wall time, no host. Of an experiment that is
    not over, of the trials that are. E405, E406 where the folder holds no experiment.
    """
    header = read_plan(folder)
    found = {str(x["key"]): x for x in read_trials(folder)}
    lines = [found[k] for k in header["order"] if k in found]
    results = results_of(header, lines)
    _json(folder / TABLE, results.document)
    if results.times:
        _json(folder / TIMING, {"tables": [t.as_json() for t in results.times]})
    for table in (*results.tables, *results.times):
        for suffix, text in (("md", table.markdown()), ("csv", table.csv()), ("tex", table.latex())):
            write_atomic(folder / "tables" / f"{table.name}.{suffix}", text.encode())
    shown = in_the_main_setting(lines) if header["kind"] == "paper" else lines
    figures = figures_of(shown, str(header["kind"]))
    for figure in figures:
        write_atomic(folder / "figures" / f"{figure.name}.svg", figure.svg)
        write_atomic(folder / "figures" / f"{figure.name}.png", figure.png)
    write_atomic(folder / INDEX, study_page(folder, header, (*results.tables, *results.times), figures, lines))
    return results


def _json(path: Path, document: Mapping[str, Any]) -> None:
    write_atomic(path, (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode())
