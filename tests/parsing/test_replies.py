"""Replies as a whole: filter, shipped tagger and parser on the cargo scene, against golden files.

``NAME.txt`` is a reply, ``NAME.expected`` what it comes to; those named hostile_* end in a diagnostic or in goals that
only speak of the map. `LLMBT_UPDATE_GOLDEN=1 pytest tests/parsing/test_replies.py` writes the results anew.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from llmbt_atl.library import Library
from llmbt_compiler.keywords.tagger import Tagger, load_tagger
from llmbt_compiler.parsing import Extent, LabelledStep, parse
from llmbt_compiler.reasoning.filter import filter_steps
from llmbt_compiler.reasoning.steps import Question
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.semantic_map import SemanticMap
from tests.parsing.labelled import shown

FOLDER = Path(__file__).parent / "replies"
REPLIES = sorted(FOLDER.glob("*.txt"))
Scene = tuple[SemanticMap, Library]


@pytest.fixture(scope="module")
def tagger() -> Tagger:
    return load_tagger()


def outcome(reply: str, tagger: Tagger, scene: Scene) -> list[str]:
    """A line for each goal, note and diagnostic."""
    try:
        steps = filter_steps(reply)
    except LlmbtError as fault:
        return [f"{d.code}: {d.title}" for d in fault.diagnostics] + [f"exit {int(fault.exit_code)}"]
    if isinstance(steps, Question):
        return [f"asks: {steps.text}"]
    tagged = tagger.tag([s.text for s in steps.steps])
    labelled = [
        LabelledStep.of(s.number, t, Extent(s.start, s.end), s.runs) for s, t in zip(steps.steps, tagged, strict=True)
    ]
    return shown(parse(labelled, *scene))


@pytest.mark.parametrize("path", REPLIES, ids=[p.stem for p in REPLIES])
def test_golden(path: Path, tagger: Tagger, cargo: Scene) -> None:
    found = "\n".join(outcome(path.read_text("utf-8"), tagger, cargo)) + "\n"
    expected = path.with_suffix(".expected")
    if os.environ.get("LLMBT_UPDATE_GOLDEN"):
        expected.write_text(found, "utf-8")
    assert found == expected.read_text("utf-8")


HOSTILE = {
    "empty": "",
    "a megabyte": "1. Pick up object 1.\n" * 50_000,
    "binary": bytes(range(256)).decode("latin-1"),
    "markup": "**\n---\n```\n| | |\n" * 50,
    "many steps": "".join(f"{i}. Place object 1 on position 11.\n" for i in range(1, 400)),
    "a step of a thousand words": "1. Place object 1 on position 11 " + "and then " * 1000 + "stop.",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_is_no_reply_is_a_diagnostic(name: str, tagger: Tagger, cargo: Scene) -> None:
    lines = outcome(HOSTILE[name], tagger, cargo)
    assert lines[-1] != "exit 0"
    assert any(line[0] == "E" for line in lines)
