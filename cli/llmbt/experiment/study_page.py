"""An experiment as one HTML page: tables, figures, and every trial with a link to its own page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from llmbt.experiment.figures import Figure
from llmbt.experiment.run_page import data_uri, rendered
from llmbt.experiment.tables import Table

__all__ = ["study_page"]

Line = Mapping[str, Any]
WELL = {"success": "good", "asked": "warn", "refused": "warn"}


def study_page(
    folder: Path, header: Line, tables: Sequence[Table], figures: Sequence[Figure], lines: Sequence[Line]
) -> bytes:
    """The page. Links go to files in `folder` only, so that the folder can be moved as it is."""
    told = [
        (name, str(header[name]))
        for name in ("experiment", "seed", "repeat", "trials", "settings", "worlds", "n", "llmbt_version")
        if header.get(name) is not None
    ]
    paper = header["kind"] == "paper"
    rows = [_row(folder, x, paper) for x in sorted(lines, key=_order)]
    values = {
        "title": f"{header['experiment']}: {'trials' if paper else 'ways to execute compared'}",
        "facts": told,
        "tables": [t.html() for t in tables],
        "figures": [{"title": f.title, "picture": data_uri(f.svg)} for f in figures],
        "rows": rows if paper else [r for r in rows if r["tone"] == "bad"][:400],
        "head": ("trial", "request", "disturbance", "says", "verdict") if paper else ("trial", "ended", "verdict"),
        "without": "" if paper else "Of the comparison the failures alone, 400 at most; trials.jsonl holds all.",
    }
    return rendered("study.html.jinja2", values)


def _order(line: Line) -> tuple[bool, str]:
    unclear = line.get("kind") == "unclear"
    well = line["verdict"] in (("asked", "refused") if unclear else ("success",))
    return well, str(line["key"])


def _row(folder: Path, line: Line, paper: bool) -> dict[str, Any]:
    page = f"trials/{line['key']}.html"
    well = _order(line)[0]
    cells: tuple[str, ...] = (str(line["reason"])[:160],) if not paper else ()
    if paper:
        says = line.get("says") or line.get("reason") or ""
        cells = (f"{line['kind']}, {line['register']}", ", ".join(line.get("drawn", ())), str(says)[:160])
    return {
        "key": line["key"],
        "link": page if (folder / page).exists() else "",
        "cells": cells,
        "verdict": line["verdict"],
        "tone": WELL.get(line["verdict"], "bad") if well else "bad",
    }
