"""`python -m tests.suite`: the table of outcomes by kind of problem, number of events and method."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from llmbt_runtime.baselines import METHODS
from llmbt_runtime.episodes import EVENTS, KINDS, episode
from tests.suite.measure import Row, measure
from tests.suite.table import document

DOC = Path(__file__).parents[2] / "docs" / "suite.md"


Cell = tuple[str, int, bool]


@dataclass(frozen=True)
class Done:
    """The rows of one cell, and the seconds of one core that making its problems and the whole of it took."""

    rows: list[Row]
    generating_s: float
    cpu_s: float


def run(cell: Cell, seeds: range, methods: Sequence[str]) -> Done:
    """All problems of a kind with so many events, smooth or rough, by all methods."""
    kind, events, rough = cell
    began, generating, rows = time.process_time(), 0.0, list[Row]()
    for seed in seeds:
        start = time.process_time()
        problem = episode(kind, seed, events=events, rough=rough)
        generating += time.process_time() - start
        for method in methods:
            row = measure(problem, events, method)
            rows.append(row)
            for v in row.violations:
                print(f"violation: {kind} seed {seed} events {events} rough {rough}: {v}", file=sys.stderr)
    return Done(rows, generating, time.process_time() - began)


def main() -> int:
    """Measure, print, and with `--write` keep the table; 1 where a claim is violated."""
    parser = argparse.ArgumentParser(prog="python -m tests.suite", description=__doc__)
    parser.add_argument("--n", type=int, default=2_000, help="at least so many problems")
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--methods", nargs="*", default=list(METHODS), choices=list(METHODS))
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--workers", type=int, default=1, help="processes; the table is the same but for its times")
    parser.add_argument("--write", action="store_true", help=f"write {DOC.name}")
    options = parser.parse_args()
    cells: list[Cell] = [(k, e, r) for k in options.kinds for e in EVENTS for r in (False, True)]
    each = -(-options.n // len(cells))
    work = partial(run, seeds=range(options.first, options.first + each), methods=options.methods)
    began, found = time.monotonic(), list[Done]()
    with ProcessPoolExecutor(options.workers) as pool:
        for number, (cell, done) in enumerate(zip(cells, pool.map(work, cells), strict=True), 1):
            found.append(done)
            print(f"{number}/{len(cells)} {cell[0]} {cell[1]} {time.monotonic() - began:.0f} s", file=sys.stderr)
    rows = [r for d in found for r in d.rows]
    clock, cpu = time.monotonic() - began, sum(d.cpu_s for d in found)
    text = document(rows, each * len(cells), clock, cpu, sum(d.generating_s for d in found))
    print(text)
    if options.write:
        DOC.write_text(text, encoding="utf-8")
    return int(any(r.violations for r in rows))


if __name__ == "__main__":
    raise SystemExit(main())
