"""`llmbt execute --no-update`: a tree of anybody's hand, ticked as it stands, in the world of facts and in physics."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from llmbt.main import main
from llmbt_ir.condition import Condition
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import GoalRecord, Provenance, write_tree
from llmbt_runtime.record import signatures_of
from tests.strategies import CANONICAL, cargo_library

BRING = """
  <BehaviorTree ID="Bring">
    <Fallback>
      <On target="{what}" place="{to}"/>
      <RetryUntilSuccessful num_attempts="3">
        <Timeout msec="60000">
          <Sequence><pick target="{what}" place="{from}"/><place target="{what}" place="{=}"/></Sequence>
        </Timeout>
      </RetryUntilSuccessful>
    </Fallback>
  </BehaviorTree>""".replace("{=}", "{to}")
HAND = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence>
      <SubTree ID="Bring" what="object_1" from="sorting_area" to="position_12"/>
      <Delay delay_msec="500"><SubTree ID="Bring" what="object_2" from="sorting_area" to="position_13"/></Delay>
    </Sequence>
  </BehaviorTree>BRING
</root>
""".replace("BRING", BRING)


def execute(tmp_path: Path, xml: str | bytes, *options: str, code: int = 0, world: str = "symbolic") -> dict[str, Any]:
    file, out = tmp_path / "hand.xml", tmp_path / "out"
    file.write_bytes(xml.encode() if isinstance(xml, str) else xml)
    command = ["execute", str(file), "--scene", "cargo_sorting", "--world", world, "-o", str(out), "--force", "-q"]
    assert main([*command, "--no-update", *options]) == code
    document: dict[str, Any] = json.loads((out / "result.json").read_text())
    return document


def done(document: dict[str, Any]) -> list[str]:
    return [f"{a['name']}({', '.join(a['args'])}) {a['result']}" for a in document["actions"]]


def main_tree(body: str) -> str:
    return f'<root BTCPP_format="4"><BehaviorTree ID="Main">{body}</BehaviorTree></root>'


def test_a_tree_with_memory_subtrees_and_decorators(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = execute(tmp_path, HAND)
    assert document["outcome"] == "SUCCESS"
    assert document["update"] is False
    assert (document["goals"], document["updates"], document["versions"]) == ([], 0, 1)
    assert done(document) == [
        "pick(object_1, sorting_area) SUCCESS",
        "place(object_1, position_12) SUCCESS",
        "pick(object_2, sorting_area) SUCCESS",
        "place(object_2, position_13) SUCCESS",
    ]
    first, second = document["actions"][1], document["actions"][2]
    assert second["started_s"] - first["ended_s"] == pytest.approx(0.5)
    capsys.readouterr()
    assert main(["tree", "log", str(tmp_path / "out")]) == 0
    log = capsys.readouterr().out
    assert "v000  the tree as it was given, ticked as it stands" in log
    assert "place(object_2, position_13): SUCCESS" in log and "SUCCESS; no goals are stated (" in log
    (tmp_path / "out" / "result.json").unlink()
    assert main(["tree", "log", str(tmp_path / "out")]) == 0
    assert "the run was killed" in capsys.readouterr().out
    assert main(["tree", "why", str(tmp_path / "out"), "pick(object_1, sorting_area)"]) == 1
    assert "ticked as it stands" in capsys.readouterr().err


def test_a_retry_is_what_makes_up_for_a_drop_in_physics(tmp_path: Path) -> None:
    document = execute(tmp_path, HAND, "--disturb", "drop", "--seed", "1", world="bullet")
    assert document["outcome"] == "SUCCESS"
    assert [d["name"] for d in document["disturbances"]] == ["drop"]
    lines = done(document)
    assert len(lines) == 6
    dropped = next(line for line in lines if line.endswith("FAILURE"))
    assert lines.count(dropped.replace("FAILURE", "SUCCESS")) == 1


def test_a_timeout_halts_in_simulated_time(tmp_path: Path) -> None:
    body = '<Timeout msec="200"><pick target="object_1" place="sorting_area"/></Timeout>'
    document = execute(tmp_path, main_tree(body), "--seed", "1", code=3)
    assert document["outcome"] == "TREE_FAILED"
    (action,) = document["actions"]
    assert (action["result"], action["reason"]) == ("HALTED", "the tree halted it")
    assert action["ended_s"] == pytest.approx(0.2)
    assert document["reason"] == "the tree returned FAILURE: Timeout ran out (line 1)"


def test_a_reactive_tree_halts_before_it_starts(tmp_path: Path) -> None:
    """While object_1 is carried, it is lost: the pick takes over from the place. The world of facts refuses to start an
    action while another is under way."""
    body = """<ReactiveSequence>
      <ReactiveFallback><Holding target="object_1"/><On target="object_1" place="position_12"/>
        <ReactiveSequence><On target="object_1" place="sorting_area"/><pick target="object_1" place="sorting_area"/>
        </ReactiveSequence><pick target="object_1" place="workbench"/></ReactiveFallback>
      <ReactiveFallback><On target="object_1" place="position_12"/>
        <place target="object_1" place="position_12"/></ReactiveFallback></ReactiveSequence>"""
    document = execute(tmp_path, main_tree(body), "--disturb", "drop")
    assert document["outcome"] == "SUCCESS"
    assert "place(object_1, position_12) HALTED" in done(document)
    times = [(a["started_s"], a["ended_s"]) for a in document["actions"]]
    assert all(end <= start for (_, end), (start, _) in pairwise(times))


def test_what_failed_is_named(tmp_path: Path) -> None:
    body = '<Sequence>\n<HandEmpty/>\n<On target="object_1" place="position_12"/></Sequence>'
    document = execute(tmp_path, main_tree(body), code=3)
    assert document["outcome"] == "TREE_FAILED"
    assert document["reason"] == "the tree returned FAILURE: On(object_1, position_12) did not hold (line 3)"


def test_a_tree_that_never_ends(tmp_path: Path) -> None:
    body = '<RetryUntilSuccessful num_attempts="-1"><Holding target="object_1"/></RetryUntilSuccessful>'
    document = execute(tmp_path, main_tree(body), code=3)
    assert (document["outcome"], document["ticks"]) == ("BUDGET", 20_000)


def test_the_goals_that_a_tree_of_ours_names_are_held_against_the_truth(tmp_path: Path) -> None:
    """Whatever the root returns."""
    goals = tuple(GoalRecord(f"g{i}", c) for i, c in enumerate(CANONICAL, 1))
    xml = write_tree(goal_tree((CANONICAL,)), signatures_of(cargo_library()), Provenance(goals=goals))
    document = execute(tmp_path, xml, code=3)
    assert document["reason"] == "the tree returned FAILURE: On(object_1, position_12) did not hold (line 5)"
    idle = goal_tree(((Condition("HandEmpty"),),))
    told = write_tree(idle, signatures_of(cargo_library()), Provenance(goals=goals[:1]))
    document = execute(tmp_path, told, code=3)
    assert document["reason"] == "the tree returned SUCCESS, and On(object_1, position_12) does not hold"
    assert [g["holds"] for g in document["goals"]] == [False]


@pytest.mark.parametrize(
    ("body", "code", "said"),
    [
        ("<Parallel><HandEmpty/></Parallel>", 1, "this engine does not run <Parallel>"),
        ('<HandEmpty _skipIf="x == 1"/>', 1, "`_skipIf` holds a script"),
        ('<pick target="objct_1" place="sorting_area"/>', 1, "scene `cargo_sorting` has no `objct_1`"),
        ('<pick target="{what}" place="sorting_area"/>', 1, "nothing writes the blackboard entry `what`"),
        ("<Grasp/>", 1, "unknown node `Grasp`"),
    ],
)
def test_what_cannot_be_ticked(
    body: str, code: int, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "x.xml"
    file.write_text(main_tree(body))
    command = ["execute", str(file), "--scene", "cargo_sorting", "--world", "symbolic", "-o", str(tmp_path / "o")]
    assert main([*command, "--no-update"]) == code
    error = capsys.readouterr().err
    assert said in error
    assert "x.xml" in error


def test_without_the_option_a_tree_that_cannot_grow_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "hand.xml"
    command = ["execute", str(file), "--scene", "cargo_sorting", "--world", "symbolic", "-o", str(tmp_path / "o")]
    for body in ("<Sequence><HandEmpty/></Sequence>", '<Repeat num_cycles="2"><HandEmpty/></Repeat>'):
        file.write_text(main_tree(body))
        assert main(command) == 1
        error = capsys.readouterr().err
        assert "E052" in error
        assert "llmbt execute --no-update" in error
