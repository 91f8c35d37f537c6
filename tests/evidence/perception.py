"""`python -m tests.evidence.perception`: cargo runs by what the cameras see, written into docs/recognition.md.

The canonical request, with one to three random disturbances in a run. A run succeeds when the goals hold by the truth.
Finished runs are kept in a ledger, so that a long evaluation can be gone on with.
"""

from __future__ import annotations

import argparse
import json
import platform
import statistics
import tempfile
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from llmbt.execution import Order, execute_tree
from llmbt.progress import Progress
from llmbt_ir.scene import load_scene
from tests.evidence.__main__ import CANONICAL, ROOT, compiled

PAGE = ROOT / "docs" / "recognition.md"
BEGIN, END = "<!-- perception: begin -->", "<!-- perception: end -->"
FIRST_SEED = 1_000
"""What was looked at while this was developed had seeds below."""


def run(tree: Path, scene: str, seed: int, folder: Path) -> dict[str, Any]:
    """One run; what it came to."""
    order = Order(load_scene(scene), "bullet", seed, f"random:{1 + seed % 3}", perception="camera")
    found = execute_tree(tree.read_bytes(), str(tree), folder / str(seed), order, Progress(quiet=True))
    return {
        "seed": seed,
        "outcome": found["outcome"],
        "reason": found.get("reason", ""),
        "holds": all(g["holds"] for g in found["goals"]),
        "disturbances": [d["name"] for d in found["disturbances"]],
        "actions": len(found["actions"]),
        "looked": sum(a["name"] == "look" for a in found["actions"]),
        "updates": found["updates"],
        "sim_time_s": found["sim_time_s"],
        "wall_time_s": found["wall_time_s"],
    }


def table(rows: list[dict[str, Any]]) -> list[str]:
    """By the number of disturbances."""
    lines = [
        "| disturbances | SUCCESS | goals hold by the truth | actions | looks for a thing | simulated s | wall s |",
        "|---|---|---|---|---|---|---|",
    ]
    groups = [(str(n), [r for r in rows if 1 + r["seed"] % 3 == n]) for n in (1, 2, 3)]
    for name, group in [*groups, ("all", rows)]:
        if not group:
            continue
        won, holds = sum(r["outcome"] == "SUCCESS" for r in group), sum(r["holds"] for r in group)
        lines.append(
            f"| {name} | {won}/{len(group)} | {holds}/{len(group)} | "
            f"{statistics.median(r['actions'] for r in group):g} | {sum(r['looked'] for r in group)} | "
            f"{statistics.median(r['sim_time_s'] for r in group):.0f} | "
            f"{statistics.median(r['wall_time_s'] for r in group):.0f} |"
        )
    lost = [r for r in rows if r["outcome"] != "SUCCESS"]
    return [
        *lines,
        *[f"\nSeed {r['seed']} ({', '.join(r['disturbances'])}): {r['outcome']}, {r['reason']}" for r in lost],
    ]


def main() -> None:
    """Run what the ledger lacks, print, and write the table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--runs", type=int, default=100)
    options.add_argument("--first", type=int, default=FIRST_SEED)
    options.add_argument("--ledger", type=Path, default=Path("runs/perception.jsonl"))
    chosen = options.parse_args()
    chosen.ledger.parent.mkdir(parents=True, exist_ok=True)
    wanted = range(chosen.first, chosen.first + chosen.runs)
    done = [json.loads(line) for line in chosen.ledger.read_text().splitlines()] if chosen.ledger.exists() else []
    rows = {r["seed"]: r for r in done if r["seed"] in wanted}
    with tempfile.TemporaryDirectory() as scratch:
        scene, tree = compiled(CANONICAL, Path(scratch))
        for seed in wanted:
            if seed in rows:
                continue
            rows[seed] = run(tree, scene, seed, Path(scratch))
            with chosen.ledger.open("a", encoding="utf-8") as out:
                out.write(json.dumps(rows[seed]) + "\n")
            print(f"{len(rows)}/{chosen.runs}: {json.dumps(rows[seed])}", flush=True)
    lines = table([rows[s] for s in wanted])
    print("\n".join(lines))
    if chosen.first != FIRST_SEED:
        return
    told = (
        f"Written by `python -m tests.evidence.perception` on {datetime.now(UTC).date()}, Python "
        f"{platform.python_version()}, {platform.machine()}; the wall times are of a machine that others used, too."
    )
    head, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    tail = rest.split(END)[1]
    PAGE.write_text("\n".join([f"{head}{BEGIN}", "", told, "", *lines, "", f"{END}{tail}"]), encoding="utf-8")
    print(f"written: {PAGE}")


if __name__ == "__main__":
    main()
