"""docs/requests.md, section by section: each with the command that printed it, and the date."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path

from tests.requests import ambik, experiments, faults
from tests.requests.__main__ import decided, parts, table

__all__ = ["write"]

DOC = Path(__file__).parents[2] / "docs" / "requests.md"
_SECTION = "<!-- {mark} {name} -->"


def write(names: Sequence[str], ambik_file: Path | None) -> int:
    """Count anew what is named (all of it where nothing is, AmbiK where its file is given) and put the figures into
    docs/requests.md. What stands around them stays as it is."""
    counts: dict[str, tuple[str, Callable[[], str]]] = {
        "requests": ("python -m tests.requests", _requests),
        "experiments": ("python -m tests.requests --experiments", experiments.counted),
        "faults": ("python -m tests.requests.faults", lambda: faults.counted(faults.replies())[0]),
    }
    if ambik_file is not None:
        counts["ambik"] = (
            "python -m tests.requests.ambik ambik_test.csv",
            lambda: ambik.counted(ambik.read(ambik_file)),
        )
    for name in names or counts:
        command, count = counts[name]
        print(f"{name} ...", file=sys.stderr, flush=True)
        body = f"Printed by `{command}` on {datetime.now(UTC).date().isoformat()}:\n\n{count()}"
        DOC.write_text(replaced(DOC.read_text(encoding="utf-8"), name, body), encoding="utf-8")
    return 0


def replaced(text: str, name: str, body: str) -> str:
    """A document with what stands between a section's marks exchanged. ValueError where it has no such section."""
    begin, end = (_SECTION.format(mark=mark, name=name) for mark in ("begin", "end"))
    pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    if len(pattern.findall(text)) != 1:
        raise ValueError(f"{DOC.name} has no section {name}")
    return pattern.sub(lambda _: f"{begin}\n{body}\n{end}", text)


def _requests() -> str:
    return table({part: decided(cases) for part, cases in parts().items()})
