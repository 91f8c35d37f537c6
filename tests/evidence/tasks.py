"""What is executed again and again: compiled requests, and the success conditions of the experiments' cases."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from llmbt.compilation import Request, compile_into
from llmbt.experiment.cases import read_case
from llmbt.progress import Progress
from llmbt.recorded import goal_records
from llmbt_compiler.reasoning.author import read_replies
from llmbt_ir.scene import Scene, load_scene
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import Provenance, write_tree
from llmbt_runtime.record import signatures_of
from tests.evidence.ledger import ROOT

__all__ = ["CANONICAL", "Task", "case", "dialogue", "dialogues"]

CANONICAL = "sort_by_colour"


@dataclass(frozen=True)
class Task:
    """A scene and a first tree."""

    name: str
    scene: Scene
    tree: bytes


def dialogues() -> tuple[str, ...]:
    """The shipped dialogues' names."""
    return tuple(d.name for d in read_replies(ROOT / "fixtures" / "replies" / "replies.xml"))


@cache
def dialogue(name: str) -> Task:
    """A shipped dialogue, compiled from its recording."""
    found = next(d for d in read_replies(ROOT / "fixtures" / "replies" / "replies.xml") if d.name == name)
    with tempfile.TemporaryDirectory() as scratch:
        into = Path(scratch) / "compiled"
        compile_into(Request(found.request, found.scene, answers=found.answers), into, Progress(quiet=True))
        return Task(name, load_scene(found.scene), (into / "tree.v000.xml").read_bytes())


@cache
def case(file: str) -> Task:
    """A case of the experiments: a tree that states its success and does nothing yet."""
    found = read_case(ROOT / "experiments" / "cases" / file)
    stated = Provenance(goals=goal_records(found.success))
    return Task(found.name, found.scene, write_tree(goal_tree(found.success), signatures_of(found.library), stated))
