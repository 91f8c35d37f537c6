"""Many executions in physics, one a seed, and what came of them."""

from __future__ import annotations

import shutil
import statistics
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import hypot
from pathlib import Path
from typing import Any

from llmbt.execution import Order, execute_tree
from llmbt.progress import Progress
from llmbt_runtime.disturbance import NAMES
from tests.evidence.ledger import KEPT, Row, filled
from tests.evidence.tasks import CANONICAL, Task, case, dialogue

__all__ = ["CAMPAIGNS", "Campaign"]

QUIET = Progress(quiet=True)


@dataclass(frozen=True)
class Campaign:
    """Runs of some tasks by turns.

    `disturb` says what disturbs the run of a seed; `outcome` how every run should end.
    """

    name: str
    title: str
    about: str
    tasks: tuple[Callable[[], Task], ...]
    first_seed: int
    runs: int
    disturb: Callable[[int], str]
    outcome: str = "SUCCESS"
    vary: bool = False
    perception: str = "truth"

    def lines(self, runs: int | None, first: int | None) -> list[str]:
        """Run what the ledger lacks, and tell."""
        begin = self.first_seed if first is None else first
        seeds = range(begin, begin + (self.runs if runs is None else runs))
        rows = filled(self.name, seeds, self.run)
        return [f"## {self.title}", "", f"{self.about} Seeds {seeds.start} to {seeds.stop - 1}.", "", *self.table(rows)]

    def run(self, seed: int) -> Row:
        """One run; its folder is kept where it did not end as it should."""
        task = self.tasks[seed % len(self.tasks)]()
        order = Order(task.scene, "bullet", seed, self.disturb(seed), vary=self.vary, perception=self.perception)
        row: Row = {"task": task.name, "disturb": order.disturb}
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "run"
            folder.mkdir()
            cpu = time.process_time()
            try:
                row |= told(execute_tree(task.tree, "tree.xml", folder, order, QUIET))
            except Exception:
                row |= {"outcome": "EXCEPTION", "reason": traceback.format_exc().splitlines()[-1]}
                (folder / "fault.txt").write_text(traceback.format_exc(), encoding="utf-8")
            row["cpu_s"] = round(time.process_time() - cpu, 2)
            kept = KEPT / "failed" / self.name / str(seed)
            shutil.rmtree(kept, ignore_errors=True)
            if not self.well(row):
                shutil.copytree(folder, kept)
        return row

    def well(self, row: Row) -> bool:
        """Whether a run ended as it should: a success only if the goals hold by the truth."""
        return bool(row["outcome"] == self.outcome and (self.outcome != "SUCCESS" or row["holds"]))

    def table(self, rows: list[Row]) -> list[str]:
        """By how many disturbances were asked for and by task; by disturbance; the failures with their reasons."""
        groups = [(f"`{d}`", [r for r in rows if r["disturb"] == d]) for d in dict.fromkeys(r["disturb"] for r in rows)]
        if len(self.tasks) > 1:
            names = dict.fromkeys(r["task"] for r in rows)
            groups += [(name, [r for r in rows if r["task"] == name]) for name in names]
        lines = [
            f"| | {self.outcome} | updates | actions (of these, failed) | simulated s: median, most | CPU s: "
            "median, most | placed within mm: median, worst |",
            "|---|---|---|---|---|---|---|",
        ]
        for name, some in [*sorted(groups), ("**all**", rows)]:
            ran = [r for r in some if "sim_time_s" in r] or [dict.fromkeys(("updates", "actions", "failed"), 0)]
            off = [mm for r in some for mm in r.get("off_mm", ())]
            sim, cpu = [r.get("sim_time_s", 0.0) for r in ran], [r.get("cpu_s", 0.0) for r in ran]
            median = statistics.median
            lines.append(
                f"| {name} | {sum(map(self.well, some))}/{len(some)} | {median(r['updates'] for r in ran):g} | "
                f"{sum(r['actions'] for r in ran)} ({sum(r['failed'] for r in ran)}) | "
                f"{median(sim):.0f}, {max(sim):.0f} | {median(cpu):.1f}, {max(cpu):.1f} | "
                f"{f'{median(off):.1f}, {max(off):.1f}' if off else ''} |"
            )
        came = [(r, d) for r in rows for d in r.get("disturbances", ())]
        if came:
            lines += ["", "| disturbance | came | in runs | of these as they should be |", "|---|---|---|---|"]
            for name in NAMES:
                mine = [r for r in rows if any(d == name for d in r.get("disturbances", ()))]
                if mine:
                    lines.append(
                        f"| {name} | {sum(d == name for _, d in came)} | {len(mine)} | {sum(map(self.well, mine))} |"
                    )
            drawn = sum(len(r.get("drawn", ())) for r in rows)
            lines += ["", f"Of {drawn} disturbances drawn, {len(came)} came about before the run's end."]
        lost = [r for r in rows if not self.well(r)]
        for r in lost:
            by = ", ".join(r.get("disturbances", ()))
            lines.append(f"\n- seed {r['seed']}, {r['task']} ({by}): {r['outcome']}: {r['reason']}")
        return lines


def told(document: dict[str, Any]) -> Row:
    """What a row says of a run."""
    return {
        "outcome": document["outcome"],
        "reason": document.get("reason", ""),
        "holds": any(
            all(g["holds"] for g in document["goals"] if g.get("alternative", 1) == k)
            for k in {g.get("alternative", 1) for g in document["goals"]}
        ),
        "drawn": document["drawn"],
        "disturbances": [d["name"] for d in document["disturbances"]],
        "updates": document["updates"],
        "actions": len(document["actions"]),
        "failed": sum(a["result"] == "FAILURE" for a in document["actions"]),
        "looked": sum(a["name"] == "look" for a in document["actions"]),
        "sim_time_s": document["sim_time_s"],
        "wall_time_s": document["wall_time_s"],
        "off_mm": offsets_mm(document),
    }


def offsets_mm(document: dict[str, Any]) -> list[float]:
    """How far things that goals put onto slots are from the middles of these."""
    found = []
    for goal in document["goals"]:
        if goal["holds"] and goal["name"] == "On" and goal["args"][1].startswith("position"):
            x, y, _ = document["objects"][goal["args"][0]]["xyz_m"]
            px, py, _ = document["places"][goal["args"][1]]["xyz_m"]
            found.append(round(1000 * hypot(x - px, y - py), 2))
    return found


def _random(seed: int) -> str:
    return f"random:{1 + seed % 3}"


_CARGO = (lambda: dialogue(CANONICAL),)
_HOUSEHOLD = tuple(
    partial(case, f"household/{name}.xml")
    for name in ("thirsty", "milk_behind_obstacle", "several_things", "clear_table", "guest_snack")
)
_VARIED = (
    "Things' poses (1.5 cm, 0.25 rad), sizes (6 %), masses (20 %), friction (15 %) and the cameras varied by the seed."
)
_UNSOLVABLE = ("object_taken", "impossible")

CAMPAIGNS = (
    Campaign(
        "cargo",
        "Cargo, one to three random disturbances in a run",
        "The canonical request.",
        _CARGO,
        20_000,
        100,
        _random,
    ),
    Campaign(
        "household",
        "Household, one to three random disturbances in a run",
        "The success conditions of the household experiment's five cases by turns.",
        _HOUSEHOLD,
        30_000,
        100,
        _random,
    ),
    Campaign("cargo-varied", "The same cargo runs, varied", _VARIED, _CARGO, 20_000, 100, _random, vary=True),
    Campaign(
        "household-varied", "The same household runs, varied", _VARIED, _HOUSEHOLD, 30_000, 100, _random, vary=True
    ),
    Campaign(
        "cargo-unsolvable",
        "Cargo: what cannot be solved",
        "Each should end as UNSOLVABLE, with the reason.",
        _CARGO,
        21_000,
        20,
        lambda seed: _UNSOLVABLE[seed % 2],
        "UNSOLVABLE",
    ),
    Campaign(
        "household-unsolvable",
        "Household: what cannot be solved",
        "Each should end as UNSOLVABLE, with the reason.",
        _HOUSEHOLD[2:4],
        31_000,
        20,
        lambda seed: _UNSOLVABLE[seed // 2 % 2],
        "UNSOLVABLE",
    ),
    Campaign(
        "camera",
        "Cargo with `--perception camera`",
        "Conditions and skills go by what is recognised and felt; the outcome is judged by the physics' truth.",
        _CARGO,
        22_000,
        100,
        _random,
        perception="camera",
    ),
    Campaign(
        "camera-varied",
        "The same with cameras and things varied",
        _VARIED,
        _CARGO,
        22_000,
        20,
        _random,
        vary=True,
        perception="camera",
    ),
)
