"""The linter: one faulty file for each code, files without fault, and what it prints."""

from __future__ import annotations

import json
import re
from pathlib import Path
from urllib.parse import unquote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt.main import main
from llmbt_ir.btcpp.check import RULES, check_document
from llmbt_ir.btcpp.document import parse_document
from llmbt_ir.diagnostics import Severity
from llmbt_ir.tree import Tree
from llmbt_ir.tree_xml import write_tree
from tests.strategies import SIGNATURES, deep_tree, trees
from tests.tree.corpus import CLEAN, CORPUS, GUARD, MODEL, SEQ, other, tree
from tests.tree.test_includes import CASES


def codes(xml: str) -> list[str]:
    return [d.code for d in check_document(parse_document(xml.encode()))]


@pytest.mark.parametrize("name", CORPUS)
def test_each_fault_is_found(name: str) -> None:
    wanted, xml = CORPUS[name]
    found = check_document(parse_document(xml.encode(), "t.xml"))
    assert set(wanted) <= {d.code for d in found}
    for d in found:
        assert d.code in RULES
        assert d.span is not None and d.span.line > 0 and d.span.source == "t.xml"
        assert (d.severity is Severity.ERROR) == (d.code[1] == "1")


@pytest.mark.parametrize("name", [n for n, (c, _) in CORPUS.items() if c[0][1] == "2"])
def test_what_loads_has_no_error(name: str) -> None:
    assert all(c[1] == "2" for c in codes(CORPUS[name][1]))


@pytest.mark.parametrize("name", CLEAN)
def test_nothing_is_found_where_nothing_is_wrong(name: str) -> None:
    assert codes(CLEAN[name]) == []


def test_every_code_has_a_file() -> None:
    """But the one for what is no XML: see test_loose.py."""
    assert {c for wanted, _ in (*CORPUS.values(), *CASES.values()) for c in wanted} == set(RULES) - {"T216"}


def test_the_line_the_columns_and_the_suggestion() -> None:
    (found,) = check_document(parse_document(tree('  <On target="a" plase="b" place="c"/>').encode(), "t.xml"))
    assert found.span is not None
    text = found.span.text
    assert (found.span.line, text[found.span.column - 1 : found.span.end_column - 1]) == (3, 'plase="b"')
    assert found.help == "did you mean place?"


@given(trees())
def test_what_we_write_loads(made: Tree) -> None:
    found = check_document(parse_document(write_tree(made, SIGNATURES)))
    assert [d for d in found if d.severity is Severity.ERROR] == []


def test_a_grown_tree_is_clean(runs: Path) -> None:
    for path in sorted(runs.glob("*/tree.v*.xml")):
        assert check_document(parse_document(path.read_bytes())) == (), path
        assert main(["tree", "check", str(path), "--library", "cargo_sorting", "--strict"]) == 0


def test_with_a_library_the_post_condition_itself_is_wanted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = (
        '<TreeNodesModel><Condition ID="Holding"><input_port name="target"/></Condition><Condition ID="HandEmpty"/>'
        '<Action ID="pick"><input_port name="target"/><input_port name="place"/></Action></TreeNodesModel>'
    )
    body = '<ReactiveFallback><{}/><pick target="object_1" place="workbench"/></ReactiveFallback>'
    path = tmp_path / "t.xml"
    path.write_text(tree(body.format('Holding target="object_1"'), model))
    assert main(["tree", "check", str(path), "--library", "cargo_sorting", "--strict"]) == 0
    path.write_text(tree(body.format("HandEmpty"), model))
    assert main(["tree", "check", str(path), "--strict"]) == 0
    capsys.readouterr()
    assert main(["tree", "check", str(path), "--library", "cargo_sorting", "--strict"]) == 6
    assert "Holding(target=object_1)" in capsys.readouterr().out


def test_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "t.xml"
    for body, plain, strict in ((GUARD, 0, 0), (SEQ.format("<Ok/><Ok/>"), 0, 6), ("<Inverter/>", 6, 6)):
        path.write_text(tree(body))
        assert main(["tree", "check", str(path)]) == plain
        assert main(["tree", "check", str(path), "--strict"]) == strict
    path.write_text("<root")
    assert main(["tree", "check", str(path)]) == 1
    assert main(["tree", "check", str(tmp_path / "none.xml")]) == 1


def test_json_and_sarif(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "t.xml"
    path.write_text(tree(SEQ.format("<Ok/><Ok/><Sequence/>")))
    assert main(["tree", "check", str(path), "--json"]) == 6
    told = json.loads(capsys.readouterr().out)
    assert (told["exit_code"], told["errors"], told["warnings"]) == (6, 1, 2)
    assert [d["code"] for d in told["diagnostics"]] == ["T204", "T114", "T202"]
    assert main(["tree", "check", str(path), "--sarif"]) == 6
    log = json.loads(capsys.readouterr().out)
    (run,) = log["runs"]
    rules = run["tool"]["driver"]["rules"]
    assert log["version"] == "2.1.0"
    assert {r["level"] for r in run["results"]} == {"error", "warning"}
    for result in run["results"]:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
        place = result["locations"][0]["physicalLocation"]
        assert place["region"]["startLine"] == 3
        assert place["artifactLocation"]["uri"] == str(path)


def test_sarif_names_any_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its paths are URIs, its columns and lines count from 1, and a file that cannot be read is a result too."""
    odd = tmp_path / "a b#ü%.xml"
    odd.write_text(tree(SEQ.format("<Ok/><Ok/>")), encoding="utf-8")
    (tmp_path / "cut.xml").write_text("<root")
    assert main(["tree", "check", str(odd), str(tmp_path / "cut.xml"), str(tmp_path / "none.xml"), "--sarif"]) == 1
    (run,) = json.loads(capsys.readouterr().out)["runs"]
    rules = run["tool"]["driver"]["rules"]
    assert len({r["id"] for r in rules}) == len(rules)
    assert [r["ruleId"] for r in run["results"]] == ["T204", "E003", "E001"]
    places = [r["locations"][0]["physicalLocation"] for r in run["results"]]
    uris = [p["artifactLocation"]["uri"] for p in places]
    assert all(re.fullmatch(r"[A-Za-z0-9/._~%-]+", u) for u in uris)
    assert unquote(uris[0]) == str(odd)
    for region in (p["region"] for p in places if "region" in p):
        assert region["startLine"] >= 1 and region.get("startColumn", 1) >= 1
        assert region.get("endColumn", 2) > region.get("startColumn", 1)
    assert main(["tree", "check", str(tmp_path / "cut.xml"), str(odd), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert (told["exit_code"], [d["code"] for d in told["diagnostics"]]) == (1, ["E003", "T204"])


def test_names_of_version_3_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "v3.xml"
    path.write_text(
        '<root main_tree_to_execute="M"><BehaviorTree ID="M"><SequenceStar><SubTreePlus ID="X" __autoremap="true"/>'
        '</SequenceStar></BehaviorTree><BehaviorTree ID="X"><AlwaysSuccess/></BehaviorTree></root>'
    )
    assert main(["tree", "check", str(path)]) == 6
    said = capsys.readouterr().out
    assert "in version 4 it is SequenceWithMemory" in said and "in version 4 it is SubTree" in said
    assert "error[T109]: <SubTreePlus> is a node of version 3" in said and "T201" in said


def test_deep_and_long() -> None:
    """5,000 levels in one tree, 20,000 nodes side by side, SubTrees 1,000 deep."""
    deep = tree("<Inverter>" * 4_999 + "<Ok/>" + "</Inverter>" * 4_999)
    assert codes(deep) == ["T108"]
    assert codes(tree(SEQ.format("<ReactiveFallback><Ok/><act/></ReactiveFallback>" * 5_000))) == []
    chain = "".join(other(f"B{i}", f'<SubTree ID="B{i + 1}"/>') for i in range(1_000)) + other("B1000")
    assert codes(tree('<SubTree ID="B0"/>', MODEL + chain)) == []
    split = write_tree(deep_tree(5_000), SIGNATURES)
    assert not [d for d in check_document(parse_document(split)) if d.severity is Severity.ERROR]


@given(st.text(alphabet='<>/="ab ?!-&;', max_size=60))
def test_no_text_is_too_odd(text: str) -> None:
    from llmbt_ir.diagnostics import LlmbtError

    try:
        check_document(parse_document(f'<root BTCPP_format="4">{text}</root>'.encode()))
    except LlmbtError as fault:
        assert fault.diagnostics[0].code in ("E003", "E005")
