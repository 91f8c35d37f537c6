"""`tree check` follows <include>s as BehaviorTree.CPP does, relative to the file that names them; circles are found."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from llmbt.main import main
from llmbt_ir.btcpp.check import RULES, check_document
from llmbt_ir.btcpp.document import read_document
from llmbt_ir.btcpp.includes import with_includes
from tests.tree.corpus import MODEL, other, tree

Files = dict[str, str]


def library(*trees: str, includes: tuple[str, ...] = (), model: str = "") -> str:
    named = "".join(f'<include path="{i}"/>\n' for i in includes)
    return f'<root BTCPP_format="4">\n{named}{"".join(trees)}{model}\n</root>\n'


def program(body: str, *includes: str, rest: str = MODEL) -> str:
    named = "".join(f'<include path="{i}"/>\n' for i in includes)
    return tree(body, rest).replace("<BehaviorTree", named + "<BehaviorTree", 1)


CASES: dict[str, tuple[tuple[str, ...], Files]] = {
    "found": ((), {"main.xml": program('<SubTree ID="B"/>', "lib/b.xml"), "lib/b.xml": library(other("B"))}),
    "relative_to_the_file_that_names_it": (
        (),
        {
            "main.xml": program('<SubTree ID="B"/>', "lib/b.xml"),
            "lib/b.xml": library(other("B", '<SubTree ID="C"/>'), includes=("deep/c.xml",)),
            "lib/deep/c.xml": library(other("C", '<SubTree ID="D"/>'), includes=("../../d.xml",)),
            "d.xml": library(other("D")),
        },
    ),
    "read_once": (
        (),
        {
            "main.xml": program('<Sequence><SubTree ID="B"/><SubTree ID="C"/></Sequence>', "b.xml", "c.xml"),
            "b.xml": library(other("B", '<SubTree ID="D"/>'), includes=("d.xml",)),
            "c.xml": library(other("C", '<SubTree ID="D"/>'), includes=("d.xml",)),
            "d.xml": library(other("D")),
        },
    ),
    "calls_back": (
        (),
        {
            "main.xml": program('<SubTree ID="B"/>', "b.xml", rest=MODEL + other("Mine")),
            "b.xml": library(other("B", '<SubTree ID="Mine"/>')),
        },
    ),
    "models_of_their_own": (
        (),
        {"main.xml": program('<SubTree ID="B"/>', "b.xml"), "b.xml": library(other("B"), model=MODEL)},
    ),
    "missing": (("T126",), {"main.xml": program("<Ok/>", "none.xml")}),
    "no_path": (("T126",), {"main.xml": program("<Ok/>", "x.xml").replace(' path="x.xml"', "")}),
    "broken": (("T126",), {"main.xml": program("<Ok/>", "b.xml"), "b.xml": "<root>"}),
    "no_tree_file": (("T126",), {"main.xml": program("<Ok/>", "b.xml"), "b.xml": "<scene/>"}),
    "still_not_there": (
        ("T116",),
        {"main.xml": program('<SubTree ID="C"/>', "b.xml"), "b.xml": library(other("B"))},
    ),
    "fault_inside": (
        ("T114",),
        {"main.xml": program('<SubTree ID="B"/>', "b.xml"), "b.xml": library(other("B", "<Sequence/>"))},
    ),
    "unknown_inside": (
        ("T109",),
        {"main.xml": program('<SubTree ID="B"/>', "b.xml"), "b.xml": library(other("B", "<Onn/>"))},
    ),
    "circle_of_files": (
        ("T127",),
        {"main.xml": program('<SubTree ID="B"/>', "b.xml"), "b.xml": library(other("B"), includes=("main.xml",))},
    ),
    "circle_of_trees": (
        ("T117",),
        {
            "main.xml": program('<SubTree ID="B"/>', "b.xml"),
            "b.xml": library(other("B", '<SubTree ID="Main"/>')),
        },
    ),
    "overridden": (
        ("T105",),
        {"main.xml": program('<SubTree ID="B"/>', "b.xml", rest=MODEL + other("B")), "b.xml": library(other("B"))},
    ),
    "ros_package": (
        ("T215",),
        {"main.xml": program('<SubTree ID="B"/>', "b.xml").replace("<include", '<include ros_pkg="p"')},
    ),
}
LOADS = ("overridden",)
"""T105 between files: 4.8.2 takes the later one silently."""


def put(folder: Path, files: Files) -> Path:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder / "main.xml"


@pytest.mark.parametrize("name", CASES)
def test_what_is_found(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wanted, files = CASES[name]
    path = put(tmp_path, files)
    errors = any(c[1] == "1" for c in wanted)
    assert main(["tree", "check", str(path), "--json"]) == (6 if errors else 0)
    found = json.loads(capsys.readouterr().out)["diagnostics"]
    assert {d["code"] for d in found} == set(wanted)
    assert {d["code"] for d in found} <= set(RULES)
    for d in found:
        text = Path(d["span"]["source"]).read_text().splitlines()[d["span"]["line"] - 1]
        assert d["span"]["text"] == text


ENGINE = """
import sys, behaviortreepy as bt
factory = bt.BehaviorTreeFactory()
factory.register_simple_condition("Ok", lambda node: bt.NodeStatus.SUCCESS)
try:
    tree = factory.create_tree_from_file(sys.argv[1])
    print(tree.tick_exactly_once().name)
except Exception as fault:
    print("refused:", fault)
"""


@pytest.mark.parametrize("name", [n for n in CASES if n not in ("circle_of_trees", "unknown_inside")])
def test_what_behaviortree_cpp_says(name: str, tmp_path: Path) -> None:
    """4.8.2 refuses what has an error, runs what has none; files in a circle end its process."""
    wanted, files = CASES[name]
    path = put(tmp_path, {k: v.replace(MODEL, "") for k, v in files.items()})
    done = subprocess.run(
        [sys.executable, "-c", ENGINE, str(path)], capture_output=True, text=True, timeout=60, check=False
    )
    if wanted == ("T127",):
        assert done.returncode < 0
        return
    assert done.returncode == 0, done.stderr
    refused = "refused:" in done.stdout
    assert refused == (bool(wanted) and name not in LOADS), done.stdout


def test_which_of_two_trees_counts(tmp_path: Path) -> None:
    """That of the including file; of two included files the later one's. A tree that fails tells which it was."""
    fails, holds = other("B", "<AlwaysFailure/>"), other("B", "<AlwaysSuccess/>")
    for files, wanted in (
        ({"main.xml": program('<SubTree ID="B"/>', "b.xml", rest=holds), "b.xml": library(fails)}, "SUCCESS"),
        (
            {"main.xml": program('<SubTree ID="B"/>', "b.xml", "c.xml", rest=""), "b.xml": library(fails)}
            | {"c.xml": library(holds)},
            "SUCCESS",
        ),
    ):
        path = put(tmp_path, files)
        done = subprocess.run(
            [sys.executable, "-c", ENGINE, str(path)], capture_output=True, text=True, timeout=60, check=False
        )
        assert wanted in done.stdout
        document, faults = with_includes(read_document(path), path)
        assert not faults
        counted = document.kids(document.by_id["B"])
        assert document[counted[0]].tag == "AlwaysSuccess"


def test_many_files_and_a_bound(tmp_path: Path) -> None:
    """A chain of 900 files is followed; of 1,100 it is said where it was given up."""
    for n, wanted in ((900, []), (1_100, ["T126"])):
        files = {"main.xml": program('<SubTree ID="T1"/>', "t1.xml")}
        for k in range(1, n):
            more = (f"t{k + 1}.xml",) if k + 1 < n else ()
            files[f"t{k}.xml"] = library(other(f"T{k}"), includes=more)
        path = put(tmp_path, files)
        document, faults = with_includes(read_document(path), path)
        assert [f.code for f in (*faults, *check_document(document))] == wanted


def test_a_program_that_includes_is_executed(tmp_path: Path) -> None:
    bring = other("Bring", '<pick target="{what}" place="sorting_area"/>')
    path = put(
        tmp_path,
        {"main.xml": program('<SubTree ID="Bring" what="object_1"/>', "lib/bring.xml", rest="")}
        | {"lib/bring.xml": library(bring)},
    )
    command = ["execute", str(path), "--scene", "cargo_sorting", "--world", "symbolic", "-q", "--no-update"]
    assert main([*command, "-o", str(tmp_path / "out")]) == 0
    (tmp_path / "lib" / "bring.xml").unlink()
    assert main([*command, "-o", str(tmp_path / "other")]) == 1
