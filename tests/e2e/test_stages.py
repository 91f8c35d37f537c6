"""Every stage's artifact of every shipped request, against golden files: a change of behaviour shows."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from llmbt_compiler.reasoning.author import read_replies

ROOT = Path(__file__).resolve().parents[2]
DIALOGUES = {d.name: d for d in read_replies(ROOT / "fixtures" / "replies" / "replies.xml")}
EXIT = {"two_on_one_position": 3}
ARTIFACTS = ("map.xml", "prompt.json", "reply.json", "steps.json", "keywords.json", "conditions.json", "tree.v000.xml")


def without_confidence(text):
    """Confidences are floats and differ between processors; labels and spans do not."""
    document = json.loads(text)
    for step in document["steps"]:
        for name in ("confidence", "probability", "readings"):
            step.pop(name)
        for span in step["spans"]:
            span.pop("confidence")
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


@pytest.mark.parametrize("name", sorted(DIALOGUES))
def test_every_artifact(llmbt, golden, tmp_path, name):
    dialogue = DIALOGUES[name]
    answers = [x for a in dialogue.answers for x in ("--answer", a)]
    answer = llmbt("compile", dialogue.request, "--scene", dialogue.scene, "-o", tmp_path / "out", *answers)
    assert answer.code == EXIT.get(name, 0)
    for artifact in ARTIFACTS:
        path = tmp_path / "out" / artifact
        if artifact.startswith("tree") and answer.code:
            assert not path.exists(), "a tree only after success"
            continue
        text = path.read_text(encoding="utf-8")
        golden(f"{name}/{artifact}", without_confidence(text) if artifact == "keywords.json" else text)


@pytest.mark.parametrize("stage", ["map", "prompt", "reason", "filter", "keywords", "parse"])
def test_stop_after_prints_what_the_stage_made(llmbt, tmp_path, stage):
    dialogue = DIALOGUES["red_block_only"]
    answer = llmbt("compile", dialogue.request, "--scene", dialogue.scene, "--stop-after", stage)
    assert answer.code == 0
    assert answer.out.strip()


def test_start_from_reads_what_the_stage_before_left(llmbt, tmp_path):
    """An edited step changes the goal, and only what comes after it runs again."""
    dialogue, out = DIALOGUES["red_block_only"], tmp_path / "out"
    order = [dialogue.request, "--scene", dialogue.scene, "-o", out]
    assert llmbt("compile", *order, "--stop-after", "filter").code == 0
    steps = (out / "steps.json").read_text()
    (out / "steps.json").write_text(steps.replace("position 32", "position 34"))
    assert llmbt("compile", *order, "--start-from", "keywords").code == 0
    assert "position_34" in (out / "tree.v000.xml").read_text()


def test_the_reference_tagger_gives_the_same_tree(llmbt, tmp_path):
    dialogue = DIALOGUES["sort_by_colour"]
    trees = []
    for tagger in ("default", "torch"):
        out = tmp_path / tagger
        order = [dialogue.request, "--scene", dialogue.scene, "-o", out, "--tagger", tagger]
        assert llmbt("compile", *order).code == 0
        trees.append((out / "tree.v000.xml").read_bytes())
    assert trees[0] == trees[1]
