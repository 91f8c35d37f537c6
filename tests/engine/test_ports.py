"""Ports that point to the blackboard, in trees that grow: resolved as in trees that are ticked as they stand."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from llmbt.main import main
from llmbt_ir.btcpp.document import parse_document
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree_xml import parse_tree
from llmbt_runtime.engine.load import program_of_document

SIGNATURES = Signatures({"On": ("target", "place"), "Free": ("place",)}, {"pick": ("target", "place")})
VALUES = ("milk", "bar", "{a}", "{b}", "{=}", " {a} ", "{@a}", "{_p}")


def random_file(seed: int) -> str:
    """Trees that call those after them with some ports, remapped, by _autoremap, by a model's default."""
    rng = random.Random(seed)

    def leaf() -> str:
        ports = (rng.choice(VALUES), rng.choice(VALUES))
        if rng.random() < 0.4:
            return f'<Inverter><Free place="{ports[0]}"/></Inverter>'
        return f'<{rng.choice(["On", "pick"])} target="{ports[0]}" place="{ports[1]}"/>'

    def call(after: int) -> str:
        given = "".join(f' {k}="{rng.choice(VALUES)}"' for k in ("a", "b", "place") if rng.random() < 0.7)
        remap = rng.choice(("", ' _autoremap="true"', ' _autoremap="0"'))
        return f'<SubTree ID="T{rng.randint(after + 1, 3)}"{given}{remap}/>'

    trees = ""
    for k in range(4):
        inside = "".join(call(k) if k < 3 and rng.random() < 0.5 else leaf() for _ in range(rng.randint(1, 3)))
        trees += f'<BehaviorTree ID="T{k}"><ReactiveSequence>{inside}</ReactiveSequence></BehaviorTree>'
    model = '<TreeNodesModel><SubTree ID="T2"><input_port name="b" default="shelf"/></SubTree></TreeNodesModel>'
    return f'<root BTCPP_format="4" main_tree_to_execute="T0">{trees}{model}</root>'


def test_ports_are_what_they_are_where_the_tree_does_not_grow() -> None:
    """The oracle is the loader of the engine, which is compared with BehaviorTree.CPP."""
    resolved = refused = 0
    for seed in range(600):
        xml = random_file(seed).encode()
        try:
            program = program_of_document(parse_document(xml), SIGNATURES)
        except LlmbtError as fault:
            assert {d.code for d in fault.diagnostics} == {"E086"}
            with pytest.raises(LlmbtError) as ours:
                parse_tree(xml, "x.xml", SIGNATURES)
            assert {d.code for d in ours.value.diagnostics} == {"E086"}
            refused += 1
            continue
        tree = parse_tree(xml, "x.xml", SIGNATURES).tree
        leaves = [n.condition.fact if n.condition else n.action for n in tree.preorder() if not n.children]
        assert leaves == [n.condition or n.action for n in program.nodes if not n.children]
        resolved += "{" in xml.decode()
    assert resolved > 20 and refused > 20


SHARED = """<root BTCPP_format="4" main_tree_to_execute="Main">
<BehaviorTree ID="Main"><ReactiveSequence>
  <SubTree ID="Put" what="object_1" where="position_12"/>
  <SubTree ID="Put" what="object_2" {second}/>
</ReactiveSequence></BehaviorTree>
<BehaviorTree ID="Put"><ReactiveFallback>
  <On target="{what}" place="{where}"/>
</ReactiveFallback></BehaviorTree></root>
"""


def test_a_shared_subtree_grows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """And the run can be told, though the file has no TreeNodesModel and names no goals."""
    (tmp_path / "hand.xml").write_text(SHARED.replace("{second}", 'where="position_13"'))
    command = ["execute", str(tmp_path / "hand.xml"), "--scene", "cargo_sorting", "-o", str(tmp_path / "out")]
    assert main([*command, "--world", "symbolic"]) == 0
    capsys.readouterr()
    assert main(["tree", "log", str(tmp_path / "out")]) == 0
    log = capsys.readouterr().out
    assert "On(object_1, position_12), On(object_2, position_13) hold" in log
    assert "v000  the goals alone, 5 nodes" in log
    assert main(["tree", "why", str(tmp_path / "out"), "pick(object_2, sorting_area)"]) == 0
    assert "v000, the tree that was given" in capsys.readouterr().out


def test_an_entry_that_nothing_writes_names_the_node(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "hand.xml").write_text(SHARED.replace("{second}", ""))
    command = ["execute", str(tmp_path / "hand.xml"), "--scene", "cargo_sorting", "-o", str(tmp_path / "out")]
    assert main([*command, "--world", "symbolic"]) == 1
    said = capsys.readouterr().err
    assert "E086" in said and "<On>: nothing writes the blackboard entry `where`" in said and "line 7" in said
