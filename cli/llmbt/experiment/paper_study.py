"""One of the paper's experiments from beginning to end: the plan, its trials, the tables."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from llmbt import __version__
from llmbt.experiment.cases import Experiment, cassette_of, experiment_names
from llmbt.experiment.paper_job import PaperJob, work
from llmbt.experiment.plan import Setting, plan, sample
from llmbt.experiment.results import Results, write_results
from llmbt.experiment.study import Study, run_study
from llmbt.experiment.workers import Pool

__all__ = ["PaperOrder", "run_paper"]


@dataclass(frozen=True, slots=True)
class PaperOrder:
    """What is asked for: `repeat` seeds of each clear request, `trials` of them all, under each of the settings."""

    seed: int = 0
    repeat: int = 1
    trials: int | None = None
    settings: tuple[Setting, ...] = (Setting(),)
    keep: bool = False


def run_paper(
    experiment: Experiment,
    order: PaperOrder,
    folder: Path,
    pool: Pool,
    *,
    resume: bool = False,
    force: bool = False,
    quiet: bool = False,
) -> Results:
    """Run what is left of an experiment's plan in `folder`, and write its results there. Errors as `run_study`."""
    trials = plan(experiment, seed=order.seed, repeat=order.repeat, settings=order.settings)
    if order.trials is not None:
        trials = sample(trials, order.trials, order.seed)
    source = experiment.name if experiment.name in experiment_names() else str(Path(experiment.source).resolve())
    jobs = [PaperJob(t, source, order.keep) for t in trials]
    header = _header(experiment, order) | {"source": source, "n": len(jobs), "order": [j.key for j in jobs]}
    run_study(Study(folder, header, pool, resume, force, quiet), jobs, work)
    return write_results(folder)


def _header(experiment: Experiment, order: PaperOrder) -> dict[str, Any]:
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
        "cases_sha256": told,
        "llmbt_version": __version__,
    }
