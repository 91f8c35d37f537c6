"""A trial of the paper's experiments as a worker runs it: in a folder of its own, kept where it failed."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from llmbt.experiment.cases import Experiment, load_experiment
from llmbt.experiment.plan import Trial
from llmbt.experiment.run_page import run_page
from llmbt.experiment.study import Done
from llmbt.experiment.trial import Verdict, run_trial
from llmbt_ir.diagnostics import LlmbtError

__all__ = ["PaperJob", "work"]


@dataclass(frozen=True, slots=True)
class PaperJob:
    """A trial, and where its experiment is read from. `keep`: the run's folder also of a trial that went well."""

    trial: Trial
    source: str
    keep: bool = False

    @property
    def key(self) -> str:
        """The trial's name."""
        return self.trial.key


@cache
def _experiment(source: str) -> Experiment:
    return load_experiment(source)


def work(job: PaperJob) -> Done:
    """Run a trial; its line, its page, and its run's folder where it failed."""
    try:
        case = next(c for c in _experiment(job.source).cases if c.name == job.trial.case)
        with tempfile.TemporaryDirectory(prefix="llmbt-") as made:
            folder = Path(made)
            line = run_trial(job.trial, case, folder)
            text = next(r.text for r in case.requests if r.id == job.trial.request)
            files = {f"trials/{job.key}.html": run_page(folder, line=line, text=text, every_tree=False)}
            if job.keep or not _as_it_should_be(line["kind"], line["verdict"]):
                files |= {f"runs/{job.key}/{p.name}": p.read_bytes() for p in sorted(folder.iterdir())}
    except LlmbtError as fault:
        return Done(job.key, fault=fault.diagnostics, exit_code=fault.exit_code)
    return Done(job.key, line, files)


def _as_it_should_be(kind: str, verdict: str) -> bool:
    wanted = (Verdict.SUCCESS,) if kind == "clear" else (Verdict.ASKED, Verdict.REFUSED)
    return verdict in wanted
