"""Tables as values, and as Markdown, CSV, LaTeX and HTML."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from llmbt.experiment.statistics import wilson
from llmbt_ir.quoting import escape

__all__ = ["Table", "interval", "rate", "share"]


@dataclass(frozen=True, slots=True)
class Table:
    """A head and rows of text; `name` is what its files are called by, `notes` stand below it."""

    name: str
    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """For `table.json`."""
        return {
            "name": self.name,
            "title": self.title,
            "head": list(self.head),
            "rows": [list(r) for r in self.rows],
            "notes": list(self.notes),
        }

    def markdown(self, level: int = 2) -> str:
        """With its title as a heading."""

        def line(cells: Sequence[str]) -> str:
            return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"

        lines = [f"{'#' * level} {self.title}", "", line(self.head), "|" + "---|" * len(self.head)]
        lines += [line(r) for r in self.rows]
        for note in self.notes:
            lines += ["", note]
        return "\n".join(lines) + "\n"

    def csv(self) -> str:
        """Head and rows alone."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(self.head)
        writer.writerows(self.rows)
        return out.getvalue()

    def latex(self) -> str:
        """A floating table with booktabs rules; the notes stand in it."""
        columns = "l" + "r" * (len(self.head) - 1)
        lines = ["\\begin{table}", "\\centering", f"\\caption{{{_tex(self.title)}}}", f"\\label{{tab:{self.name}}}"]
        lines += [
            f"\\begin{{tabular}}{{{columns}}}",
            "\\toprule",
            " & ".join(map(_tex, self.head)) + " \\\\",
            "\\midrule",
        ]
        lines += [" & ".join(map(_tex, r)) + " \\\\" for r in self.rows]
        lines += ["\\bottomrule", "\\end{tabular}"]
        lines += [f"\\par\\smallskip\\footnotesize {_tex(n)}" for n in self.notes]
        return "\n".join([*lines, "\\end{table}"]) + "\n"

    def html(self) -> str:
        """A section."""
        head = "".join(f"<th>{escape(c)}</th>" for c in self.head)
        body = "\n".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in r) + "</tr>" for r in self.rows)
        notes = "".join(f"<p class='note'>{escape(n)}</p>" for n in self.notes)
        return (
            f"<section id='{escape(self.name)}'><h2>{escape(self.title)}</h2>"
            f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{notes}</section>"
        )


_TEX = {
    "\\": "\\textbackslash{}", "&": "\\&", "%": "\\%", "$": "\\$", "#": "\\#", "_": "\\_", "{": "\\{", "}": "\\}",
    "~": "\\textasciitilde{}", "^": "\\textasciicircum{}", "–": "--", "—": "---", "→": "$\\rightarrow$",
    "≥": "$\\geq$", "≤": "$\\leq$", "×": "$\\times$", "±": "$\\pm$",
}  # fmt: skip


def _tex(text: str) -> str:
    return "".join(_TEX.get(c, c) for c in text)


def share(good: int, n: int) -> str:
    """So many of so many; a dash of none."""
    return f"{good}/{n}" if n else "–"


def interval(low: float, high: float) -> str:
    """Per cent, from to."""
    return f"{100 * low:.0f}–{100 * high:.0f} %" if high - low >= 0.02 else f"{100 * low:.1f}–{100 * high:.1f} %"


def rate(good: int, n: int) -> str:
    """A share with its rate and Wilson's 95 % interval."""
    if not n:
        return "–"
    return f"{good}/{n} = {100 * good / n:.1f} % ({interval(*wilson(good, n))})"
