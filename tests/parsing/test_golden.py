"""Golden pairs: labelled steps and the goals, notes and diagnostics they give.

A file under golden/ has blocks: ``## title``, the steps one a line, ``=>``, the result. The part of the
file's name before the first underscore says which map. `LLMBT_UPDATE_GOLDEN=1 pytest tests/parsing` writes
the results anew.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from llmbt_atl.library import Library
from llmbt_compiler.parsing import parse
from llmbt_ir.semantic_map import SemanticMap
from tests.parsing.labelled import shown, steps

FOLDER = Path(__file__).parent / "golden"


def blocks(file: Path) -> Iterator[tuple[str, list[str], list[str]]]:
    for block in ("\n" + file.read_text("utf-8")).split("\n## ")[1:]:
        title, *lines = block.splitlines()
        at = lines.index("=>")
        yield title.strip(), lines[:at], [line for line in lines[at + 1 :] if line and line != "=>"]


CASES = [(f, t, g, e) for f in sorted(FOLDER.glob("*.txt")) for t, g, e in blocks(f)]


@pytest.mark.parametrize(("file", "title", "given", "expected"), CASES, ids=[f"{c[0].stem}-{c[1]}" for c in CASES])
def test_golden(file: Path, title: str, given: list[str], expected: list[str], request: pytest.FixtureRequest) -> None:
    scene: tuple[SemanticMap, Library] = request.getfixturevalue(file.stem.split("_")[0])
    assert shown(parse(steps(*given), *scene)) == expected


def update() -> None:
    """Write the results of all blocks anew."""
    from llmbt_atl.library import load_library, parse_library
    from llmbt_compiler.parsing.evaluate import read_scene
    from tests.parsing.conftest import FIXTURES, HOUSEHOLD, cargo_map, household_map

    cargo = load_library("cargo_sorting")
    scenes = {
        "cargo": (cargo_map(), cargo),
        "swapped": (cargo_map(at={"object_1": "position_12", "object_3": "position_22"}), cargo),
        "shelf": read_scene(FIXTURES, "shelf"),
        "depot": read_scene(FIXTURES, "depot"),
        "flat": read_scene(FIXTURES, "home"),
        "home": (household_map(), parse_library(HOUSEHOLD, "mini_household.xml")),
    }
    for file in sorted(FOLDER.glob("*.txt")):
        scene = scenes[file.stem.split("_")[0]]
        out = []
        for title, given, _ in blocks(file):
            result = shown(parse(steps(*given), *scene))
            out.append("\n".join([f"## {title}", *given, "=>", *result]) + "\n")
        file.write_text("\n".join(out), "utf-8")


if os.environ.get("LLMBT_UPDATE_GOLDEN"):
    update()
