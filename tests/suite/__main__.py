"""`python -m tests.suite`: the table of outcomes by kind of problem, number of events and method."""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from llmbt_runtime.baselines import METHODS
from llmbt_runtime.episodes import EVENTS, KINDS, episode
from tests.suite.measure import Row, measure
from tests.suite.table import document

DOC = Path(__file__).parents[2] / "docs" / "suite.md"


def main() -> int:
    """Measure, print, and with `--write` keep the table; 1 where a claim is violated."""
    parser = argparse.ArgumentParser(prog="python -m tests.suite", description=__doc__)
    parser.add_argument("--n", type=int, default=2_000, help="at least so many problems")
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--methods", nargs="*", default=list(METHODS), choices=list(METHODS))
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--write", action="store_true", help=f"write {DOC.name}")
    options = parser.parse_args()
    cells = [(k, e, r) for k in options.kinds for e in EVENTS for r in (False, True)]
    each = -(-options.n // len(cells))
    rows: list[Row] = []
    began, generating = time.monotonic(), 0.0
    for done, (kind, events, rough) in enumerate(cells, 1):
        for seed in range(options.first, options.first + each):
            start = time.process_time()
            problem = episode(kind, seed, events=events, rough=rough)
            generating += time.process_time() - start
            for method in options.methods:
                row = measure(problem, events, method)
                rows.append(row)
                for v in row.violations:
                    print(f"violation: {kind} seed {seed} events {events} rough {rough}: {v}", file=sys.stderr)
        print(f"{done}/{len(cells)} {kind} {events} {time.monotonic() - began:.0f} s", file=sys.stderr)
    text = document(rows, each * len(cells), time.monotonic() - began, time.process_time(), generating)
    print(text)
    if options.write:
        DOC.write_text(text, encoding="utf-8")
    return int(any(r.violations for r in rows))


if __name__ == "__main__":
    raise SystemExit(main())
