"""The figures of an experiment, as SVG and PNG: success by disturbance, growth of the trees, time to recover.

matplotlib is an extra (`pip install 'llm-bt[plots]'`); without it there are tables and no figures.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from llmbt.experiment.scenario import CELLS
from llmbt.experiment.statistics import survival, wilson

__all__ = ["Figure", "figures_of"]

Line = Mapping[str, Any]
PALETTE = ("#1b6ca8", "#d1495b", "#3a7d44", "#e09f3e", "#6a4c93", "#00798c", "#8d6b4b", "#444444")
LOOKS: Mapping[str, tuple[str, str]] = {
    "script": ("#b9c0c7", ":"),
    "retry": ("#98a1aa", "--"),
    "feasible": ("#5f6b76", "-"),
    "fixed": ("#e09f3e", "-"),
    "paper": ("#e58a9a", "--"),
    "paper-kind": ("#c22f45", "-"),
    "pa-bt": ("#6a4c93", "-"),
    "expansion": ("#8d6b4b", "-"),
    "chain": ("#3a7d44", "-"),
    "loop": ("#1b6ca8", "-"),
    "loop-uncertified": ("#1b6ca8", ":"),
    "loop-no-re-expansion": ("#4aa3df", "--"),
    "loop-chain": ("#4aa3df", "-."),
}
"""Colour and line of each method: related ones are alike, ours are blue."""


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure in both forms; the same lines give the same bytes on one machine."""

    name: str
    title: str
    svg: bytes
    png: bytes


def figures_of(lines: Sequence[Line], kind: str) -> tuple[Figure, ...]:
    """The figures for the lines of an experiment (`kind` paper or baselines); none where matplotlib is not there."""
    try:
        import matplotlib
    except ImportError:
        return ()
    matplotlib.use("Agg")
    matplotlib.rcParams.update({"svg.hashsalt": "llmbt", "font.size": 9, "axes.spines.top": False})
    matplotlib.rcParams.update({"axes.spines.right": False, "figure.dpi": 110})
    if kind == "paper":
        return tuple(_paper(lines))
    found: list[Figure] = []
    for world in ("symbolic", "bullet"):
        mine = [x for x in lines if x["world"] == world and x["cell"] in CELLS]
        if mine:
            found += _baselines(mine, world)
    return tuple(found)


def _drawn(name: str, title: str, figure: Any) -> Figure:
    import matplotlib.pyplot as plt

    figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    figure.tight_layout()
    svg, png = io.BytesIO(), io.BytesIO()
    figure.savefig(svg, format="svg", metadata={"Date": None})
    figure.savefig(png, format="png", metadata={"Software": None})
    plt.close(figure)
    return Figure(name, title, svg.getvalue(), png.getvalue())


# -- the paper's experiments ---------------------------------------------------------------------------------------


def _paper(lines: Sequence[Line]) -> Iterator[Figure]:
    executed = [x for x in lines if x.get("goals_right") and x["kind"] == "clear"]
    if not executed:
        return
    names = sorted({n for x in executed for n in x["drawn"]})
    shares = {n: [x["verdict"] == "success" for x in executed if n in x["drawn"]] for n in names}
    yield _drawn("success", "Success by disturbance (Wilson 95 %)", _dots({"": shares}, names))
    yield _drawn("growth", "Nodes of the tree, version by version", _versions(executed))
    happened = {
        n: [(d["recovered_at_s"], d["fired_at_s"], x["sim_time_s"]) for x in executed for d in x["disturbances"]
            if d["name"] == n]
        for n in names
    }  # fmt: skip
    yield _drawn("recovery", "Disturbances not yet recovered from", _recovery(happened))


def _versions(lines: Sequence[Line]) -> Any:
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(5, 3.2))
    for k, case in enumerate(dict.fromkeys(x["case"] for x in lines)):
        for number, line in enumerate(x for x in lines if x["case"] == case):
            sizes = line["nodes"]
            colour = PALETTE[k % len(PALETTE)]
            label = case if not number else None
            axis.plot(range(1, len(sizes) + 1), sizes, color=colour, alpha=0.35, linewidth=1, marker=".", label=label)
    axis.set_xlabel("version")
    axis.set_ylabel("nodes")
    axis.set_ylim(bottom=0)
    axis.legend(frameon=False, fontsize=7)
    return figure


# -- the comparison ------------------------------------------------------------------------------------------------


def _baselines(lines: Sequence[Line], world: str) -> Iterator[Figure]:
    where = {"symbolic": "in the world of facts", "bullet": "in physics"}[world]
    methods = list(dict.fromkeys(x["method"] for x in lines))
    cells = list(dict.fromkeys(x["cell"] for x in lines))
    shares = {
        m: {c: [x["verdict"] == "success" for x in lines if x["method"] == m and x["cell"] == c] for c in cells}
        for m in methods
    }
    by_cell = {c: {m: shares[m][c] for m in methods} for c in cells}
    yield _drawn(f"{world}_success", f"Success by disturbance (Wilson 95 %), {where}", _dots(by_cell, methods))
    yield _drawn(f"{world}_growth", f"Median nodes of the tree over simulated time, {where}", _growth(lines, methods))
    happened = {
        m: [(d[3], d[2], x["sim_time_s"]) for x in lines if x["method"] == m for d in x["disturbances"]]
        for m in methods
    }
    yield _drawn(f"{world}_recovery", f"Disturbances not yet recovered from, {where}", _recovery(happened))


def _look(number: int, name: str) -> tuple[str, str]:
    return LOOKS.get(name, (PALETTE[number % len(PALETTE)], "-"))


def _dots(panels: Mapping[str, Mapping[str, Sequence[bool]]], names: Sequence[str]) -> Any:
    """A panel for each kind of disturbance, a line in it for each name: the rate with its interval."""
    import matplotlib.pyplot as plt

    wide = 1.9 + 1.25 * len(panels) if len(panels) > 1 else 5
    figure, axes = plt.subplots(1, len(panels), sharey=True, figsize=(wide, 0.9 + 0.22 * len(names)), squeeze=False)
    for axis, (panel, shares) in zip(axes[0], panels.items(), strict=True):
        for k, name in enumerate(names):
            tried = shares.get(name, ())
            if not tried:
                continue
            rate = sum(tried) / len(tried)
            low, high = wilson(sum(tried), len(tried))
            colour = _look(0, name)[0]
            axis.plot([low, high], [k, k], color=colour, linewidth=1.2)
            axis.plot([rate], [k], marker="o", color=colour, markersize=4)
        axis.set_xlim(-0.05, 1.05)
        axis.set_xticks([0, 0.5, 1], ["0", ".5", "1"], fontsize=7)
        axis.set_title(panel.replace("_", " "), fontsize=7)
        axis.grid(axis="x", linewidth=0.3)
    axes[0][0].set_yticks(range(len(names)), names, fontsize=7)
    axes[0][0].invert_yaxis()
    return figure


def _growth(lines: Sequence[Line], methods: Sequence[str]) -> Any:
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(6, 3.4))
    longest = max(x["sim_time_s"] for x in lines)
    times = [longest * i / 120 for i in range(121)]
    for k, method in enumerate(methods):
        runs = [x for x in lines if x["method"] == method and x["growth"] and x["verdict"] == "success"]
        if not runs:
            continue
        middle = []
        for t in times:
            sizes = sorted(_size_at(x, t) for x in runs)
            middle.append(sizes[len(sizes) // 2])
        colour, line = _look(k, method)
        axis.step(times, middle, where="post", color=colour, linestyle=line, label=method, linewidth=1.3)
    axis.set_yscale("log")
    axis.set_xlabel("simulated s (a run that is over keeps its last tree; successes only)")
    axis.set_ylabel("nodes")
    axis.legend(frameon=False, fontsize=6, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _size_at(line: Line, time_s: float) -> int:
    size = int(line["growth"][0][1])
    for at, nodes in line["growth"]:
        if at > time_s:
            break
        size = int(nodes)
    return size


def _recovery(happened: Mapping[str, Sequence[tuple[float | None, float, float]]]) -> Any:
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(6, 3.2))
    for k, (name, entries) in enumerate(happened.items()):
        ended = [over - fired for over, fired, _ in entries if over is not None]
        censored = [end - fired for over, fired, end in entries if over is None]
        steps = survival(ended, censored)
        if entries:
            last = max([*ended, *censored])
            xs, ys = [t for t, _ in steps], [s for _, s in steps]
            shares = [1.0, *ys, ys[-1] if ys else 1.0]
            colour, line = _look(k, name)
            axis.step([0.0, *xs, last], shares, where="post", color=colour, linestyle=line, label=name)
    axis.set_xlabel("simulated s since it came (symmetric log)")
    axis.set_xscale("symlog", linthresh=10)
    axis.set_ylabel("share (Kaplan-Meier)")
    axis.set_ylim(0, 1.03)
    axis.legend(frameon=False, fontsize=6, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
