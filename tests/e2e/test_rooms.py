"""docs/architecture.md has every room of the house, and no room that is not there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("ir/llmbt_ir", "atl/llmbt_atl", "compiler/llmbt_compiler", "runtime/llmbt_runtime", "cli/llmbt")
PARTS = {"scene_model", "main"}
"""Modules that are parts of another: the entry point, what `scene` is made of."""


def rooms(package: str) -> set[str]:
    found = {p.stem for p in (ROOT / package).glob("*.py")} - {"__init__"} - PARTS
    folders = {p.parent.name + "/" for p in (ROOT / package).glob("*/__init__.py")}
    return found | folders


def named() -> dict[str, set[str]]:
    """The rooms that the page's table names, by package."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    found: dict[str, set[str]] = {}
    package = ""
    for line in text.split("## The rooms")[1].split("## The stages")[0].splitlines():
        cells = [c.strip() for c in line.split("|")]
        if len(cells) == 5:
            package = cells[1] or package
            found.setdefault(package, set()).update(re.findall(r"`([\w/]+)`", cells[2]))
    return found


@pytest.mark.parametrize("package", PACKAGES)
def test_every_room_is_on_the_page(package: str) -> None:
    told = named()[package.split("/", maxsplit=1)[0]]
    inner = {f"{p.parent.parent.name}/{p.parent.name}/" for p in (ROOT / package).glob("*/*/__init__.py")}
    assert rooms(package) <= told
    assert told <= rooms(package) | inner
