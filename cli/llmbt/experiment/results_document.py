"""docs/results.md: the tables of several experiments, with when, where, with what and from which seeds they come."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from llmbt import __version__
from llmbt.experiment.ledger import read_plan, read_trials
from llmbt.experiment.results import results_of
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
from llmbt_runtime.baselines import EXECUTORS

__all__ = ["results_document"]

PACKAGES = ("pybullet", "numpy", "joblib", "lxml", "safetensors", "vcrpy")


def results_document(folders: Iterable[Path]) -> str:
    """The document. E405 where a folder holds no experiment, or none of its trials are over."""
    parts = ["# Results", "", *_provenance()]
    for folder in folders:
        header = read_plan(folder)
        found = {str(x["key"]): x for x in read_trials(folder)}
        lines = [found[k] for k in header["order"] if k in found]
        if not lines:
            raise LlmbtError(Diagnostic("E405", f"no trial of `{folder}` is over", Span(str(folder))))
        results = results_of(header, lines)
        parts += ["", f"## {_title(header)}", "", *_plan(header, lines), ""]
        for table in (*results.tables, *results.times):
            parts += [table.markdown(3)]
    return "\n".join(parts).rstrip() + "\n"


def _provenance() -> Iterator[str]:
    versions = ", ".join(f"{p} {importlib.metadata.version(p)}" for p in PACKAGES)
    yield "Written by `llmbt report DIR... --results docs/results.md`; nothing here is typed in. The commands that ran"
    yield "the trials stand with each part."
    yield ""
    yield f"- date: {datetime.now(UTC).date().isoformat()}"
    yield f"- llmbt {__version__}, Python {platform.python_version()}, {versions}"
    yield f"- machine: {_machine()}"


def _machine() -> str:
    """Processor and system, no name of the machine."""
    model = ""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                model = line.partition(":")[2].strip()
                break
    except OSError:
        model = platform.processor()
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} x {model or 'unknown processor'}, shared"


def _title(header: Mapping[str, Any]) -> str:
    name = str(header["experiment"])
    return f"Ways to execute compared ({name})" if header["kind"] == "baselines" else f"The paper's experiment: {name}"


def _plan(header: Mapping[str, Any], lines: list[Mapping[str, Any]]) -> Iterator[str]:
    n, planned = len(lines), int(header["n"])
    done = (
        f"{n} trials"
        if n == planned
        else f"{n} of the {planned} trials planned, in the plan's order (the others were not run)"
    )
    yield f"`{_command(header)}`: {done}."


def _command(header: Mapping[str, Any]) -> str:
    """How it was run, without what changes no result."""
    words = ["llmbt experiment"]
    if header["kind"] == "paper":
        words += [str(header["experiment"]), f"--repeat {header['repeat']}"]
        worlds = [str(s).partition(",")[0] for s in header["settings"]]
        words += ["--factorial"] if len(worlds) > 1 else [f"--world {worlds[0]}"]
    else:
        world = "both" if len(header["worlds"]) > 1 else header["worlds"][0]
        words += [f"baselines {header['experiment']}", f"--world {world}", f"--attacks {header['attacks']}"]
        words += [f"--method {m}" for m in header["methods"]] if len(header["methods"]) < len(EXECUTORS) else []
    if header["trials"] is not None:
        words.append(f"--trials {header['trials']}")
    return " ".join([*words, f"--seed {header['seed']}", "-o DIR"])
