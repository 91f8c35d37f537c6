"""`make evidence`: long runs in physics, written to docs/evidence.md with their date and what they ran on."""

from __future__ import annotations

import argparse
import itertools
import platform
import statistics
import tempfile
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from math import hypot
from pathlib import Path
from typing import Any

from llmbt.compilation import Request, compile_into
from llmbt.execution import Order, execute_tree, load_tree, read_state
from llmbt.progress import Progress
from llmbt_compiler.reasoning.author import read_replies
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.scene import load_scene
from llmbt_ir.versions import VersionStore
from llmbt_runtime.update.rollout import Certificate, rollout

ROOT = Path(__file__).resolve().parents[2]
CANONICAL = "sort_by_colour"
DISTURBANCES = ("drop", "obstacle_at_place", "obstacle_at_pick", "placed_object_moved")
QUIET = Progress(quiet=True)
Case = tuple[str, str, int]
"""A dialogue's name, a disturbance, a seed."""


def compiled(name: str, folder: Path) -> tuple[str, Path]:
    """A shipped dialogue's scene and tree."""
    dialogue = next(d for d in read_replies(ROOT / "fixtures" / "replies" / "replies.xml") if d.name == name)
    into = folder / f"compiled-{name}"
    compile_into(Request(dialogue.request, dialogue.scene, answers=dialogue.answers), into, QUIET)
    return dialogue.scene, into / "tree.v000.xml"


def run(scene: str, tree: Path, into: Path, disturb: str, seed: int) -> dict[str, Any]:
    """One physical run."""
    order = Order(load_scene(scene), "bullet", seed, disturb)
    return execute_tree(tree.read_bytes(), str(tree), into, order, QUIET)


def versions_restart(scene: str, folder: Path) -> bool:
    """Whether every version reaches the goals from the state it was made for."""
    for version in VersionStore(folder).versions()[1:]:
        file, _, domain, goals = load_tree(version.path.read_bytes(), str(version.path), load_scene(scene))
        facts = read_state(version.path.with_suffix(".json"))
        if not isinstance(rollout(file.tree, domain.for_state(facts), facts, goals), Certificate):
            return False
    return True


def error_mm(result: dict[str, Any]) -> float:
    """The largest horizontal distance of a placed object from its place's centre."""
    worst = 0.0
    for goal in result["goals"]:
        if goal["name"] == "On" and goal["args"][1].startswith("position"):
            x, y, _ = result["objects"][goal["args"][0]]["xyz_m"]
            px, py, _ = result["places"][goal["args"][1]]["xyz_m"]
            worst = max(worst, 1000 * hypot(x - px, y - py))
    return worst


def rows(cases: list[Case], folder: Path) -> Iterator[tuple[Case, dict[str, Any], bool]]:
    """Run cases, telling each."""
    for k, (name, disturb, seed) in enumerate(cases, 1):
        scene, tree = compiled(name, folder / f"c{k}")
        into = folder / f"run{k}"
        start = time.monotonic()
        result = run(scene, tree, into, disturb, seed)
        restart = versions_restart(scene, into)
        seconds = time.monotonic() - start
        print(f"{k:3d}/{len(cases)} {name} {disturb} {seed}: {result['outcome']}, {seconds:.1f} s", flush=True)
        yield (name, disturb, seed), result, restart


def table(title: str, cases: list[Case], folder: Path) -> list[str]:
    """A table by request and disturbance."""
    found = list(rows(cases, folder))
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
        lines.append(
            f"| {name} | {disturb} | {won}/{len(rs)} | {'' if disturb == 'none' else f'{broke}/{len(rs)}'} | "
            f"{sum(ok for _, _, ok in rs)}/{len(rs)} | {statistics.median(r['updates'] for r in results):g} | "
            f"{max(r['sim_time_s'] for r in results):.1f} | "
            f"{statistics.median(r['wall_time_s'] for r in results):.1f} | {max(map(error_mm, results)):.1f} |"
        )
        for key, r, _ in rs:
            if r["outcome"] != "SUCCESS":
                lines.append(f"| | seed {key[2]} | {r['outcome']}: {r.get('reason', '')} | | | | | | |")
    return [*lines, ""]


def impossible(folder: Path) -> list[str]:
    """The request that cannot be carried out."""
    start = time.monotonic()
    try:
        compiled("two_on_one_position", folder)
    except LlmbtError as fault:
        seconds = time.monotonic() - start
        return [f"`two_on_one_position`: exit code {int(fault.exit_code)} in {seconds:.1f} s: {fault}", ""]
    raise AssertionError("it compiled")


def main() -> None:
    """Run everything and write the page."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seeds", type=int, default=5)
    options.add_argument("--random", type=int, default=20, help="further runs, with one to three random disturbances")
    options.add_argument("-o", "--out", type=Path, default=ROOT / "docs" / "evidence.md")
    chosen = options.parse_args()
    seeds = range(chosen.seeds)
    others = [d.name for d in read_replies(ROOT / "fixtures" / "replies" / "replies.xml")]
    others = [n for n in others if n not in (CANONICAL, "two_on_one_position")]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        lines = [
            "# Evidence",
            "",
            f"Written by `make evidence` on {datetime.now(UTC).date()}, Python {platform.python_version()}, "
            f"{platform.machine()}; physics simulated by pybullet, replies authored by hand. Wall times are of a "
            "shared machine.",
            "",
        ]
        canonical = [(CANONICAL, d, s) for d in ("none", *DISTURBANCES) for s in seeds]
        lines += table("The canonical request", canonical, folder / "a")
        lines += table("The other requests", [(n, "none", 0) for n in others], folder / "b")
        lines += ["One cannot be done:", "", *impossible(folder / "c")]
        random = [(CANONICAL, f"random:{1 + s % 3}", 100 + s) for s in range(chosen.random)]
        random.sort(key=lambda c: (c[1], c[2]))
        lines += table("Random disturbances, one to three in a run", random, folder / "d")
    chosen.out.write_text("\n".join(lines), encoding="utf-8")
    print(f"written: {chosen.out}")


if __name__ == "__main__":
    main()
