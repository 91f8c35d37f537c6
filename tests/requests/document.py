"""docs/requests.md, section by section: each with the command that printed it, and the date."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from tests.requests import ambik, experiments, faults
from tests.requests.__main__ import decided, parts, table

__all__ = ["write"]

DOC = Path(__file__).parents[2] / "docs" / "requests.md"
_SECTION = "<!-- {mark} {name} -->"


def write(ambik_file: Path | None) -> int:
    """Count everything anew and put the figures into docs/requests.md; what stands around them stays as it is, and so
    do the figures of AmbiK where its file is not given."""
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
    text = DOC.read_text(encoding="utf-8")
    for name, (command, count) in counts.items():
        print(f"{name} ...", file=sys.stderr, flush=True)
        date = datetime.now(UTC).date().isoformat()
        text = replaced(text, name, f"Printed by `{command}` on {date}:\n\n{count()}")
        DOC.write_text(text, encoding="utf-8")
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
