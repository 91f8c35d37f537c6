"""`python -m tests.requests`: of the requests in fixtures/requests, how many are decided rightly, by part and kind."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tests.requests.cases import PARTS, read_cases
from tests.requests.decide import Judged, judge

KINDS = ("complete", "ambiguous", "impossible")


def main() -> int:
    """Decide, print the table and what is wrong; 1 where anything is."""
    parser = argparse.ArgumentParser(prog="python -m tests.requests", description=__doc__)
    parser.add_argument("--part", choices=PARTS, default=None, help="this part alone")
    parser.add_argument("--id", dest="ids", action="append", default=[], help="this request alone; may be repeated")
    parser.add_argument("--verbose", action="store_true", help="say what is decided about each")
    options = parser.parse_args()
    judged: dict[str, list[Judged]] = {}
    with tempfile.TemporaryDirectory() as scratch:
        for part in [options.part] if options.part else PARTS:
            for case in read_cases(part):
                if options.ids and case.id not in options.ids:
                    continue
                found = judge(case, Path(scratch) / part / case.id)
                judged.setdefault(part, []).append(found)
                if options.verbose or not found.right:
                    tell(found)
    print(table(judged))
    return int(any(not j.right for rows in judged.values() for j in rows))


def tell(judged: Judged) -> None:
    """What was decided, on stderr."""
    case = judged.case
    print(f"{case.id} ({case.kind}, {case.scene}): {judged.wrong or 'right'}\n    {case.text}", file=sys.stderr)
    print(f"    {judged.first}", file=sys.stderr)
    if judged.then is not None:
        print(f"    then {judged.then}", file=sys.stderr)


def table(judged: dict[str, list[Judged]]) -> str:
    """Markdown: a row for each part and kind."""
    rows = ["| part | kind | requests | right | wrong |", "|---|---|---|---|---|"]
    for part, found in judged.items():
        for kind in (*KINDS, "all"):
            of_kind = [j for j in found if kind in (j.case.kind, "all")]
            if of_kind:
                rows.append(f"| {part} | {kind} | {len(of_kind)} | {_right(of_kind)} | {_why(of_kind)} |")
    return "\n".join(["Replies authored by hand; no model was asked.", "", *rows])


def _right(found: Sequence[Judged]) -> str:
    n = sum(j.right for j in found)
    return f"{n} ({100 * n / len(found):.0f} %)"


def _why(found: Sequence[Judged]) -> str:
    reasons = [j.wrong for j in found if j.wrong]
    return ", ".join(f"{reasons.count(r)} {r}" for r in dict.fromkeys(reasons))


if __name__ == "__main__":
    raise SystemExit(main())
