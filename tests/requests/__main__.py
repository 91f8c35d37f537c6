"""`python -m tests.requests`: of the requests in fixtures/requests, how many are decided rightly, by part and kind."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from tests.requests.blind import read_blind
from tests.requests.cases import BLIND, BLIND2, BLIND3, BLIND4, BLIND5, DEV, DEV2, DEV3, OTHERS, Case, read_open
from tests.requests.decide import Decision, Judged, judge

KINDS = ("complete", "ambiguous", "impossible")
AUTHORED = "Replies authored by hand; no model was asked."


def main() -> int:
    """Decide, print the table and, of the open part, what is wrong; 1 where anything is."""
    parser = argparse.ArgumentParser(prog="python -m tests.requests", description=__doc__)
    parser.add_argument("--blind", type=Path, metavar="FILE", help="requests as JSON lines, not the shipped ones")
    parser.add_argument("--ids", action="store_true", help="with --blind: name what is wrong, by id and reason")
    parser.add_argument("--id", dest="chosen", action="append", default=[], help="this request alone; may be repeated")
    parser.add_argument("--experiments", action="store_true", help="the requests of experiments/ instead (2 minutes)")
    sections = ("requests", "experiments", "faults", "ambik")
    told = "put figures into docs/requests.md: these, or all (10 minutes)"
    parser.add_argument("--write", nargs="*", choices=sections, metavar="SECTION", help=told)
    parser.add_argument("--ambik", type=Path, metavar="FILE", help="with --write: AmbiK's ambik_test.csv, counted too")
    parser.add_argument("--verbose", action="store_true", help="say what is decided about each")
    options = parser.parse_args()
    if options.write is not None:
        from tests.requests.document import write

        return write(options.write, options.ambik)
    if options.experiments:
        from tests.requests.experiments import counted

        print(counted(verbose=options.verbose))
        return 0
    judged = {
        part: decided([c for c in cases if not options.chosen or c.id in options.chosen])
        for part, cases in parts(options.blind).items()
    }
    for part, found in judged.items():
        for each in found:
            if options.verbose or (part == "open" and each.wrong):
                tell(each)
            elif options.ids and each.wrong:
                print(f"{each.case.id} ({each.case.kind}): {each.wrong}", file=sys.stderr)
    print(f"{AUTHORED}\n\n{table(judged)}")
    return int(any(not j.right for rows in judged.values() for j in rows))


def parts(blind: Path | None = None) -> dict[str, tuple[Case, ...]]:
    """The requests to decide: those of a file alone, or the open ones, those that were blind until they were counted,
    and another author's, by which the code was mended."""
    if blind is not None:
        return {"blind": read_blind(blind)}
    more = {
        "once blind": (BLIND,),
        "once blind, second": (BLIND2,),
        "once blind, third": BLIND3,
        "once blind, fourth": BLIND4,
        "once blind, fifth": BLIND5,
        "development": (DEV,),
        "development, second": (DEV2,),
        "development, third": (DEV3,),
        "development, scenes of others": OTHERS,
    }
    read = {name: tuple(c for path in paths if path.exists() for c in read_blind(path)) for name, paths in more.items()}
    return {"open": read_open(), **{name: cases for name, cases in read.items() if cases}}


def decided(cases: Sequence[Case]) -> list[Judged]:
    """Every case judged, in a folder of its own that is gone afterwards."""
    with tempfile.TemporaryDirectory() as scratch:
        return [_judged(case, Path(scratch) / str(n)) for n, case in enumerate(cases)]


def _judged(case: Case, folder: Path) -> Judged:
    """A fault of the program's own is a wrong decision, and ends no count."""
    try:
        return judge(case, folder)
    except Exception as fault:
        return Judged(case, Decision(70, reason=repr(fault)), wrong=f"the program breaks off ({type(fault).__name__})")


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
    return "\n".join(rows)


def _right(found: Sequence[Judged]) -> str:
    n = sum(j.right for j in found)
    return f"{n} ({100 * n / len(found):.0f} %)"


def _why(found: Sequence[Judged]) -> str:
    reasons = [j.wrong for j in found if j.wrong]
    return ", ".join(f"{reasons.count(r)} {r}" for r in dict.fromkeys(reasons))


if __name__ == "__main__":
    raise SystemExit(main())
