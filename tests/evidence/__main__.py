"""`make evidence`: long runs in physics; each part writes its section of docs/evidence.md.

A run that has been done with the same code is taken from runs/evidence, where the folders of failures are kept, too.
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from llmbt.execution import Order, execute_tree, load_tree, read_state
from llmbt.progress import Progress
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.scene import Scene
from llmbt_ir.versions import VersionStore
from llmbt_runtime.update.rollout import Certificate, rollout
from tests.evidence import recognition
from tests.evidence.campaign import CAMPAIGNS, offsets_mm
from tests.evidence.grasping import grasping
from tests.evidence.ledger import ROOT
from tests.evidence.page import told_by, write_section
from tests.evidence.tasks import CANONICAL, dialogue, dialogues

PAGE = ROOT / "docs" / "evidence.md"
DISTURBANCES = ("drop", "obstacle_at_place", "obstacle_at_pick", "placed_object_moved")
Case = tuple[str, str, int]
"""A dialogue's name, a disturbance, a seed."""


def versions_restart(scene: Scene, folder: Path) -> bool:
    """Whether every version reaches the goals from the state it was made for."""
    for version in VersionStore(folder).versions()[1:]:
        file, _, domain, goals = load_tree(version.path.read_bytes(), str(version.path), scene)
        facts = read_state(version.path.with_suffix(".json"))
        if not isinstance(rollout(file.tree, domain.for_state(facts), facts, goals), Certificate):
            return False
    return True


def rows(cases: list[Case]) -> Iterator[tuple[Case, dict[str, Any], bool]]:
    """Run cases, telling each."""
    for k, (name, disturb, seed) in enumerate(cases, 1):
        task = dialogue(name)
        start = time.monotonic()
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            order = Order(task.scene, "bullet", seed, disturb)
            result = execute_tree(task.tree, "tree.xml", folder, order, Progress(quiet=True))
            restart = versions_restart(task.scene, folder)
        seconds = time.monotonic() - start
        print(f"{k:3d}/{len(cases)} {name} {disturb} {seed}: {result['outcome']}, {seconds:.1f} s", flush=True)
        yield (name, disturb, seed), result, restart


def table(title: str, cases: list[Case]) -> list[str]:
    """A table by request and disturbance."""
    found = list(rows(cases))
    lines = [
        f"## {title}",
        "",
        "| request | disturbance | SUCCESS | it came in time and broke a fact | every version restarts | updates | "
        "simulated s (most) | wall s (median) | placed within mm (worst) |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for (name, disturb), group in itertools.groupby(found, key=lambda f: f[0][:2]):
        rs = list(group)
        results = [r for _, r, _ in rs]
        won = sum(r["outcome"] == "SUCCESS" for r in results)
        broke = sum(bool(r["disturbances"]) and all(d["broke"] for d in r["disturbances"]) for r in results)
        off = max((mm for r in results for mm in offsets_mm(r)), default=0.0)
        lines.append(
            f"| {name} | {disturb} | {won}/{len(rs)} | {'' if disturb == 'none' else f'{broke}/{len(rs)}'} | "
            f"{sum(ok for _, _, ok in rs)}/{len(rs)} | {statistics.median(r['updates'] for r in results):g} | "
            f"{max(r['sim_time_s'] for r in results):.1f} | "
            f"{statistics.median(r['wall_time_s'] for r in results):.1f} | {off:.1f} |"
        )
        for key, r, _ in rs:
            if r["outcome"] != "SUCCESS":
                lines.append(f"| | seed {key[2]} | {r['outcome']}: {r.get('reason', '')} | | | | | | |")
    return lines


def canonical(runs: int | None, first: int | None) -> list[str]:
    """The canonical request with each disturbance of the paper's."""
    seeds = range(first or 0, (first or 0) + (runs or 5))
    return table("The canonical request", [(CANONICAL, d, s) for d in ("none", *DISTURBANCES) for s in seeds])


def requests(_runs: int | None, _first: int | None) -> list[str]:
    """The other shipped requests, and the one that cannot be carried out."""
    others = [n for n in dialogues() if n not in (CANONICAL, "two_on_one_position")]
    lines = table("The other requests", [(n, "none", 0) for n in others])
    start = time.monotonic()
    try:
        dialogue("two_on_one_position")
    except LlmbtError as fault:
        seconds = time.monotonic() - start
        told = f"exit code {int(fault.exit_code)} in {seconds:.1f} s: {fault}"
        return [*lines, "", f"One cannot be done: `two_on_one_position`: {told}"]
    raise AssertionError("it compiled")


PARTS: dict[str, Callable[[int | None, int | None], list[str]]] = {
    "canonical": canonical,
    "requests": requests,
    "grasping": grasping,
    **{c.name: c.lines for c in CAMPAIGNS},
}


def main() -> None:
    """Run parts and write their sections."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--only", nargs="+", choices=[*PARTS, "recognition"], help="parts; all of them if left out")
    options.add_argument("--runs", type=int, help="so many seeds a part; nothing is written but with --write")
    options.add_argument("--first", type=int, help="the first seed; nothing is written but with --write")
    options.add_argument("--write", action="store_true")
    chosen = options.parse_args()
    usual = chosen.runs is None and chosen.first is None
    for name, part in PARTS.items():
        if chosen.only and name not in chosen.only:
            continue
        lines = part(chosen.runs, chosen.first)
        print("\n".join(lines), flush=True)
        if usual or chosen.write:
            more = "".join(f" --{o} {v}" for o in ("runs", "first") if (v := getattr(chosen, o)) is not None)
            told = told_by(f"python -m tests.evidence --only {name}{more}")
            write_section(PAGE, name, [*lines, "", f"*{told}*"])
    if not chosen.only or "recognition" in chosen.only:
        recognition.written()


if __name__ == "__main__":
    main()
