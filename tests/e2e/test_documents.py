"""The documents say what the code says."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
ROOMS = ("ir", "atl", "compiler", "runtime", "cli")


def test_every_code_is_documented():
    used = set()
    for room in ROOMS:
        for path in (ROOT / room).rglob("*.py"):
            used.update(re.findall(r'"([EWT]\d{3})"', path.read_text(encoding="utf-8")))
    pages = (ROOT / "docs" / "diagnostics.md").read_text() + (ROOT / "docs" / "trees.md").read_text()
    documented = set(re.findall(r"[EWT]\d{3}", pages))
    assert used <= documented, sorted(used - documented)
    assert {d for d in documented if d[0] != "T"} <= used, sorted(documented - used)


def test_links_lead_somewhere():
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]:
        for target in re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_no_path_of_a_machine():
    for page in [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "Makefile", ROOT / "pyproject.toml"]:
        assert not re.search(r"/(root|work|home/\w+)/", page.read_text(encoding="utf-8")), page.name
