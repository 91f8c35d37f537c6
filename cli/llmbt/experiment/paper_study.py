"""One of the paper's experiments from beginning to end: the plan, its trials, the tables."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from llmbt import __version__
from llmbt.experiment.cases import Experiment, cassette_of, experiment_names
from llmbt.experiment.paper import counts, paper_tables
from llmbt.experiment.paper_job import PaperJob, work
from llmbt.experiment.plan import Setting, plan, sample
from llmbt.experiment.results import write_results
from llmbt.experiment.study import Study, run_study
from llmbt.experiment.tables import Table
from llmbt.experiment.workers import Pool

__all__ = ["Found", "PaperOrder", "run_paper"]


@dataclass(frozen=True, slots=True)
class PaperOrder:
    """What is asked for: `repeat` seeds of each clear request, `trials` of them all, under each of the settings."""

    seed: int = 0
    repeat: int = 1
    trials: int | None = None
    settings: tuple[Setting, ...] = (Setting(),)
    keep: bool = False


@dataclass(frozen=True, slots=True)
class Found:
    """The tables, and what `--json` prints."""

    tables: tuple[Table, ...]
    document: Mapping[str, Any]


def run_paper(
    experiment: Experiment,
    order: PaperOrder,
    folder: Path,
    pool: Pool,
    *,
    resume: bool = False,
    force: bool = False,
    quiet: bool = False,
) -> Found:
    """Run what is left of an experiment's plan in `folder`, and write its results there. Errors as `run_study`."""
    trials = plan(experiment, seed=order.seed, repeat=order.repeat, settings=order.settings)
    if order.trials is not None:
        trials = sample(trials, order.trials, order.seed)
    header = _header(experiment, order, len(trials))
    source = experiment.name if experiment.name in experiment_names() else str(Path(experiment.source).resolve())
    study = Study(folder, header, pool, resume, force, quiet)
    lines = run_study(study, [PaperJob(t, source, order.keep) for t in trials], work)
    tables = paper_tables(experiment, lines, order.seed)
    numbers = counts(experiment, lines)
    write_results(folder, header, tables, numbers)
    return Found(tables, {**header, "tables": [t.as_json() for t in tables], "counts": numbers})


def _header(experiment: Experiment, order: PaperOrder, n: int) -> dict[str, Any]:
    """What makes two plans the same: the options, the version, the very cases and recordings."""
    files = [Path(c.source) for c in experiment.cases]
    files += [p for c in experiment.cases for r in c.requests if (p := cassette_of(c, r)).exists()]
    told = hashlib.sha256(b"\0".join(p.read_bytes() for p in files)).hexdigest()
    return {
        "schema_version": 1,
        "kind": "paper",
        "experiment": experiment.name,
        "seed": order.seed,
        "repeat": order.repeat,
        "trials": order.trials,
        "settings": [str(s) for s in order.settings],
        "n": n,
        "cases_sha256": told,
        "llmbt_version": __version__,
    }
