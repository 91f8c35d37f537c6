"""`tree log` and `tree why`: a run can be retold from them alone."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from llmbt.history import origin, read_run
from llmbt.main import main
from llmbt_ir.diff import apply, diff
from llmbt_ir.tree_xml import read_tree


def told(capsys: pytest.CaptureFixture[str], *arguments: str | Path, code: int = 0) -> str:
    capsys.readouterr()
    assert main(["tree", *map(str, arguments)]) == code
    return capsys.readouterr().out


def test_the_log(runs: Path, golden: Callable[[str, str], None], capsys: pytest.CaptureFixture[str]) -> None:
    golden("log_drop.txt", told(capsys, "log", runs / "drop"))
    golden("log_move.txt", told(capsys, "log", runs / "obstacle_at_place", "v002", "--patch"))


def test_a_reader_can_retell_the_run(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What result.json says happened is in the log, in its order, under the version that did it."""
    for name in ("drop", "obstacle_at_place"):
        text = told(capsys, "log", runs / name)
        result = json.loads((runs / name / "result.json").read_text())
        at = 0
        for action in result["actions"]:
            line = f"{action['started_s']}-{action['ended_s']} s"
            at = text.index(line, at)
            assert f"{action['name']}({', '.join(action['args'])}): {action['result']}" in text[at:].splitlines()[0]
        (disturbance,) = result["disturbances"]
        assert f"{disturbance['fired_at_s']} s" in text
        assert f"disturbance: {disturbance['name']} of {disturbance['target']}" in text
        for k in range(result["versions"]):
            assert f"\nv{k:03d}  " in text
        assert f"{result['outcome']}; 6 of 6 goals hold ({result['ticks']} ticks" in text
        for goal in result["goals"]:
            assert f"{goal['name']}({', '.join(goal['args'])})   step " in text


def test_the_log_as_json(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = json.loads(told(capsys, "log", runs / "drop", "--json", "--patch"))
    names = [v["version"] for v in document["versions"]]
    assert names == ["v000", "v001", "v002"]
    last = document["versions"][-1]
    assert (last["tick"], last["failed_condition"]) == (12, "Holding(object_1)")
    assert last["observed"]["ended"] == ["Holding(object_1)"]
    assert last["steps"][0]["action"] == "pick(object_1, workbench)"
    assert last["certificate"]["actions"][0] == "pick(object_1, workbench)"
    assert [e["node"] for e in last["patch"]["added"]][-1] == "[pick(object_1, workbench)]"
    assert [e["kind"] for e in last["events"]][-1] == "outcome"
    trees = [read_tree(runs / "drop" / f"tree.{n}.xml").tree for n in names]
    for before, after in zip(trees, trees[1:], strict=False):
        assert apply(diff(before, after), before) == after


def test_why_leads_back_to_the_words(
    runs: Path, golden: Callable[[str, str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    golden("why_drop.txt", told(capsys, "why", runs / "drop", "pick(object_1, workbench)"))
    golden("why_move.txt", told(capsys, "why", runs / "obstacle_at_place", "[put_down(object_1, sorting_area)]"))
    document = json.loads(told(capsys, "why", runs / "drop", "g1.e2e24976f11d", "--json"))
    (chain,) = document["chains"]
    assert [link["label"] for link in chain["links"]] == [
        "pick(object_1, workbench)",
        "Holding(object_1)",
        "On(object_1, position_12)",
    ]
    assert chain["asked_for_by"]["reply_text"] == "place it on position 12"
    reply = json.loads((runs / "drop" / "reply.json").read_text())["text"]
    start, end = chain["asked_for_by"]["reply_span"]
    assert reply[start:end] == "place it on position 12"


def test_every_node_of_every_version_has_an_origin(runs: Path) -> None:
    """Each chain ends at a goal, or at the root, and each link names the edit that made its node."""
    for folder in sorted(runs.iterdir()):
        run = read_run(folder)
        goals = {g.node for g in run.stages[0].file.provenance.goals}
        for stage in run.stages:
            for node in stage.tree.preorder():
                (chain,) = origin(run, node.id)
                assert chain[-1].node in goals or chain[-1].node == "root"
                assert all(link.step is not None for link in chain[:-1])


def test_nodes_that_are_not_there(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told(capsys, "why", runs / "drop", "pick(object_1, workbrench)", code=5)
    told(capsys, "why", runs / "drop", "\x00", code=1)
    told(capsys, "why", runs / "drop", "root")
    assert told(capsys, "why", runs / "drop", "HandEmpty").count("asked for by") == 5


def test_folders_that_are_no_runs(runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told(capsys, "log", tmp_path, code=1)
    told(capsys, "log", tmp_path / "none", code=1)
    told(capsys, "log", runs / "drop", "v009", code=1)
    assert "v002" in told(capsys, "log", runs / "drop", "2")


def test_a_killed_run_is_told_as_far_as_it_went(runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(runs / "drop", tmp_path / "killed")
    for name in ("events.jsonl", "result.json", "reply.json", "conditions.json", "steps.json"):
        (tmp_path / "killed" / name).unlink()
    text = told(capsys, "log", tmp_path / "killed")
    assert "v002  tick 12" in text and "the run was killed" in text
    assert "step 1: place it on position 12" in told(capsys, "why", tmp_path / "killed", "g1")


def test_a_damaged_folder_is_a_diagnostic(runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(runs / "drop", tmp_path / "x")
    (tmp_path / "x" / "events.jsonl").write_text('{"kind": "started"}\n')
    told(capsys, "log", tmp_path / "x", code=1)
    (tmp_path / "x" / "events.jsonl").unlink()
    (tmp_path / "x" / "result.json").write_text("{")
    told(capsys, "log", tmp_path / "x", code=1)
    with (tmp_path / "x" / "tree.v001.xml").open("a") as out:
        out.write(" ")
    told(capsys, "log", tmp_path / "x", code=1)


def test_a_tree_executed_elsewhere(runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its goals keep the words; the folder has no request."""
    tree = runs / "drop" / "tree.v001.xml"
    assert (
        main(["execute", str(tree), "--scene", "cargo_sorting", "-o", str(tmp_path / "y"), "--world", "symbolic", "-q"])
        == 0
    )
    assert "SUCCESS; 6 of 6 goals hold" in told(capsys, "log", tmp_path / "y")
    assert "place it on position 12" in told(capsys, "why", tmp_path / "y", "g1")
