"""What has been run already, for a long evaluation to be gone on with. Rows of other code do not count."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

__all__ = ["KEPT", "ROOT", "Row", "filled"]

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "runs" / "evidence"
"""Ledgers, and the folders of the runs that did not end as they should."""
_CODE = ("ir", "atl", "runtime", "compiler/llmbt_compiler/recognition", "scenes", "experiments/cases")

Row = dict[str, Any]


@cache
def code() -> str:
    """A digest of all that a run depends on."""
    digest = hashlib.sha256()
    for folder in _CODE:
        for file in sorted((ROOT / folder).rglob("*")):
            if file.suffix in (".py", ".xml", ".rng"):
                digest.update(str(file.relative_to(ROOT)).encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def filled(name: str, seeds: Iterable[int], run: Callable[[int], Row]) -> list[Row]:
    """A row for each seed: from the ledger of that name, or run now and noted in it."""
    file = KEPT / f"{name}.jsonl"
    file.parent.mkdir(parents=True, exist_ok=True)
    noted = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    known = {row["seed"]: row for row in noted if row["code"] == code()}
    seeds = list(seeds)
    found = []
    for k, seed in enumerate(seeds, 1):
        row = known.get(seed)
        if row is None:
            row = {"seed": seed, "code": code(), **run(seed)}
            with file.open("a", encoding="utf-8") as out:
                out.write(json.dumps(row) + "\n")
            print(f"{name} {k}/{len(seeds)}: {json.dumps(row)[:400]}", flush=True)
        found.append(row)
    return found
