"""Pages whose sections are written by the commands that print them."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

__all__ = ["told_by", "write_section"]


def told_by(command: str) -> str:
    """Where a section comes from."""
    today = datetime.now(UTC).date()
    return f"Written by `{command}` on {today}, Python {platform.python_version()}, {platform.machine()}."


def write_section(page: Path, name: str, lines: Sequence[str]) -> None:
    """Put lines between the two comments that bear a name; at the page's end where it has none."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    text = page.read_text(encoding="utf-8")
    if begin not in text:
        text = f"{text.rstrip()}\n\n{begin}\n{end}\n"
    head, rest = text.split(begin)
    tail = rest.split(end)[1]
    page.write_text("\n".join([f"{head}{begin}", "", *lines, "", f"{end}{tail}"]), encoding="utf-8")
    print(f"written: {page}, {name}", flush=True)
