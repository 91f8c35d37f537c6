"""10,000 levels through every command: nothing recurses on depth; and what a .btlog cannot hold."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from llmbt.exports.btlog import btlog, number, read_btlog
from llmbt.main import main
from llmbt.replay import Moment
from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.tree import Kind, Node, Tree
from llmbt_ir.tree_xml import TreeFile, parse_tree, write_tree
from llmbt_runtime.tick import tick
from tests.strategies import SIGNATURES, deep_tree
from tests.tree.corpus import tree

LEVELS = 10_000


def told(capsys: pytest.CaptureFixture[str], *arguments: str | Path, code: int = 0) -> str:
    capsys.readouterr()
    assert main(["tree", *map(str, arguments)]) == code
    return capsys.readouterr().out


@pytest.fixture(scope="module")
def deep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of ours, one in which the deepest leaf is another, and one of another hand in a single tree."""
    folder = tmp_path_factory.mktemp("deep")
    made = deep_tree(LEVELS)
    other = made.with_nodes(replace(made["end"], action=ActionCall("a1")))
    (folder / "a.xml").write_bytes(write_tree(made, SIGNATURES))
    (folder / "b.xml").write_bytes(write_tree(other, SIGNATURES))
    for name, to in (("foreign.xml", "x"), ("elsewhere.xml", "y")):
        body = "<Inverter>" * LEVELS + f'<go to="{to}"/>' + "</Inverter>" * LEVELS
        (folder / name).write_text(tree(body))
    return folder


@pytest.mark.slow
def test_ten_thousand_levels(deep: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a, b = deep / "a.xml", deep / "b.xml"
    shown = told(capsys, "show", a).splitlines()
    assert len(shown) == 2 * LEVELS - 1
    assert shown[-1].endswith("└─ [wave]")
    assert told(capsys, "diff", a, b, code=6).splitlines()[-1] == "1 changed"
    assert [e["id"] for e in json.loads(told(capsys, "diff", a, b, "--json", code=6))["changed"]] == ["end"]
    assert told(capsys, "diff", a, a) == ""
    assert told(capsys, "check", a) == "0 errors, 0 warnings in 1 file\n"
    for form in ("svg", "dot", "mermaid"):
        out = deep / f"out.{form}"
        assert main(["tree", "export", str(a), "--format", form, "-o", str(out)]) == 0
        assert "[wave]" in out.read_text() or "wave" in out.read_text()
    assert main(["tree", "export", str(a), "--format", "btcpp", "-o", str(deep / "plugin")]) == 0
    assert (deep / "plugin" / "tree.xml").read_bytes() == a.read_bytes()


@pytest.mark.slow
def test_ten_thousand_levels_of_another_hand(deep: Path, capsys: pytest.CaptureFixture[str]) -> None:
    foreign, other = deep / "foreign.xml", deep / "elsewhere.xml"
    assert len(told(capsys, "show", foreign).splitlines()) == LEVELS + 2
    assert told(capsys, "diff", foreign, other, code=6).splitlines()[-1] == "1 changed"
    assert [d["code"] for d in json.loads(told(capsys, "check", foreign, "--json", code=6))["diagnostics"]] == ["T108"]


def test_a_recording_of_a_deep_tree(tmp_path: Path) -> None:
    """Nodes are numbered through the SubTrees that it is split into."""
    made = deep_tree(2_000)
    file = parse_tree(write_tree(made, SIGNATURES), "t.xml")
    facts = frozenset({Condition("P0")})
    assert tick(made, facts).action == "end"
    xml, _, rows = read_btlog(btlog(file, [Moment(0.0, facts, "end")]))
    numbers = number(file).numbers
    assert xml.count(b"<BehaviorTree ") == 11
    assert len({n for one in numbers.values() for n in one}) == max(n for one in numbers.values() for n in one)
    assert {uid for _, uid, status in rows if status == 1} >= {numbers["end"][-1], numbers[made.root][0]}


def test_what_a_recording_cannot_hold() -> None:
    """Its node numbers have 16 bits."""
    for leaves in (65_534, 65_535):
        ids = tuple(f"l{i}" for i in range(leaves))
        nodes = [Node("r", Kind.SEQUENCE, ids), *(Node(i, Kind.CONDITION, condition=Condition("P0")) for i in ids)]
        file = TreeFile(Tree("r", {n.id: n for n in nodes}), {}, "t.xml", SIGNATURES)
        if leaves == 65_534:
            assert len(number(file).numbers) == 65_535
        else:
            with pytest.raises(LlmbtError) as fault:
                number(file)
            assert [d.code for d in fault.value.diagnostics] == ["E084"]
