"""Files of any engine: read without loss, matched, and compared on the command line."""

from __future__ import annotations

import io
import json
import os
import random
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from llmbt.main import main
from llmbt_ir.btcpp.document import parse_document
from llmbt_ir.btcpp.match import matched_tables
from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.diff import apply_table, diff, diff_tables
from llmbt_ir.tree import Kind, Node, Tree
from llmbt_ir.tree_xml import parse_tree, write_tree
from tests.strategies import SIGNATURES, deep_tree, trees
from tests.tree.corpus import CLEAN, CORPUS, GUARD, MODEL, SEQ, other, tree

FOREIGN = """<?xml version="1.0"?>
<!-- by hand -->
<root main_tree_to_execute="A" BTCPP_format="4"><include path="x.xml"/>
 <BehaviorTree ID="A"><Sequence name="a &quot;b&quot; &amp; c"><!-- first --><Script code=" a := 'x&#10;y' "/>
   <SubTree ID="B" goal="{g}" _autoremap="true"/><RetryUntilSuccessful num_attempts="3"><Drive to="2;3"/>
 </RetryUntilSuccessful></Sequence></BehaviorTree><BehaviorTree ID="B"><AlwaysSuccess/></BehaviorTree>
 <TreeNodesModel><Action ID="Drive"><input_port name="to" type="Pose2D" default="0;0"> a &lt; b </input_port></Action>
 </TreeNodesModel><?note x y?><Other>text <b>mixed</b> tail</Other></root>
"""


# -- reading -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("xml", [FOREIGN, *CLEAN.values(), *(x for _, x in CORPUS.values())])
def test_nothing_is_lost(xml: str) -> None:
    document = parse_document(xml.encode())
    again = parse_document(document.write())
    assert again == document
    assert again.write() == document.write()
    parser = etree.XMLParser(huge_tree=True)
    roots = [etree.fromstring(x, parser) for x in (xml.encode(), document.write())]
    canonical = [etree.tostring(r, method="c14n2", strip_text=True) for r in roots]
    assert canonical[0] == canonical[1]


@given(
    st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=10),
    st.text(st.characters(codec="ascii"), max_size=10),
)
def test_texts_and_values_are_kept(text: str, value: str) -> None:
    root = etree.Element("root")
    try:
        root.set("a", value)
        etree.SubElement(root, "b").text = text
    except ValueError:
        return
    document = parse_document(etree.tostring(root))
    assert document[document.root].get("a") == value
    assert parse_document(document.write()) == document


# -- matching ------------------------------------------------------------------------------------------------------


def changes(first: str, second: str) -> list[tuple[str, str]]:
    """(what, label) of the differences; the diff applied to the first gives the second."""
    a, b = matched_tables(parse_document(first.encode()), parse_document(second.encode()))
    edit = diff_tables(a, b)
    assert apply_table(edit, a) == b
    return [(type(e).__name__, e.content.label()) for e in edit]


def without_ids(data: bytes) -> str:
    """As an editor writes it: other attribute order, layout, no `_id`, no provenance, explicit syntax."""
    root = etree.fromstring(data)
    for element in root.iter():
        pairs = sorted(((k, v) for k, v in element.attrib.items() if k != "_id"), reverse=True)
        element.attrib.clear()
        element.attrib.update(dict(pairs))
        if element.tag in SIGNATURES.conditions or element.tag in SIGNATURES.actions:
            element.set("name", element.tag)
    for extra in root.findall("Provenance"):
        root.remove(extra)
    root.insert(0, etree.Comment("saved"))
    return etree.tostring(root, pretty_print=True).decode()


@given(trees())
def test_what_an_editor_saves_is_the_same_tree(made: Tree) -> None:
    data = write_tree(made, SIGNATURES)
    assert changes(data.decode(), without_ids(data)) == []


@given(trees(), trees())
def test_any_two_files_can_be_compared(first: Tree, second: Tree) -> None:
    a, b = (without_ids(write_tree(t, SIGNATURES)) for t in (first, second))
    changes(a, b)


def distinct(rng: random.Random, depth: int = 3) -> Tree:
    """A tree in which no two leaves are alike."""
    nodes: dict[str, Node] = {}

    def grow(level: int) -> str:
        id_ = f"n{len(nodes)}"
        nodes[id_] = Node(id_, Kind.CONDITION, condition=Condition("On", (id_, "place")))
        if level and (level == depth or rng.random() < 0.6):
            kind = rng.choice([Kind.SEQUENCE, Kind.FALLBACK])
            nodes[id_] = Node(id_, kind, tuple(grow(level - 1) for _ in range(rng.randint(2, 4))))
        return id_

    return Tree(grow(depth), nodes)


@pytest.mark.parametrize("seed", range(200))
def test_an_edit_is_named_without_ids_too(seed: int) -> None:
    """Where leaves can be told apart: one that is added, removed or changed, or moved to another parent."""
    rng = random.Random(seed)
    first = distinct(rng)
    leaves = [n.id for n in first.preorder() if n.condition and len(first[first.parents[n.id]].children) > 2]
    composites = [n.id for n in first.preorder() if n.children]
    where = first[rng.choice(composites)]
    new = Node("new", Kind.ACTION, action=ActionCall("wave"))
    at = rng.randint(0, len(where.children))
    second = first.with_nodes(new, replace(where, children=(*where.children[:at], "new", *where.children[at:])))
    wanted = [("Added", "wave")]
    if leaves and seed % 4:
        leaf = rng.choice(leaves)
        label = f"On(place=place, target={leaf})"
        parent = first.parents[leaf]
        away = first.without(leaf)
        if seed % 4 == 1:
            second, wanted = away, [("Removed", label)]
        elif seed % 4 == 2:
            other = Node(leaf, Kind.CONDITION, condition=Condition("On", (leaf, "elsewhere")))
            second, wanted = first.with_nodes(other), [("Changed", f"On(place=elsewhere, target={leaf})")]
        elif len(composites) > 1:
            there = away[rng.choice([c for c in composites if c != parent])]
            second = away.with_nodes(first[leaf], replace(there, children=(*there.children, leaf)))
            wanted = [("Moved", label)]
    a, b = (without_ids(write_tree(Tree(t.root, {n.id: n for n in t.preorder()}), SIGNATURES)) for t in (first, second))
    assert changes(a, b) == wanted


def alike(rng: random.Random) -> Tree:
    """A tree with many equal leaves and branches."""
    nodes: dict[str, Node] = {}

    def grow(level: int) -> str:
        id_ = f"n{len(nodes)}"
        nodes[id_] = Node(id_, Kind.CONDITION, condition=Condition("On", (rng.choice("ab"), "place")))
        if level and (level == 3 or rng.random() < 0.5):
            nodes[id_] = Node(id_, rng.choice([Kind.SEQUENCE, Kind.FALLBACK]), tuple(grow(level - 1) for _ in range(3)))
        return id_

    return Tree(grow(3), nodes)


def test_a_branch_is_moved_among_equal_ones() -> None:
    """Without ids: whatever is paired, the diff leads from the one to the other, and where nothing tells equal nodes
    apart it is small all the same, but for one in twenty."""
    small = 0
    for seed in range(150):
        rng = random.Random(seed)
        first = alike(rng)
        moved = rng.choice([n.id for n in first.preorder()][1:])
        branch = {n.id: n for n in first.preorder(moved)}
        rest = first.without(moved)
        there = rest[rng.choice([n.id for n in rest.preorder() if n.kind is not Kind.CONDITION])]
        second = rest.with_nodes(*branch.values(), replace(there, children=(*there.children, moved)))
        trees_ = (Tree(t.root, {n.id: n for n in t.preorder()}) for t in (first, second))
        a, b = (parse_document(without_ids(write_tree(t, SIGNATURES)).encode()) for t in trees_)
        one, two = matched_tables(a, b)
        edit = diff_tables(one, two)
        assert apply_table(edit, one) == two
        assert len(edit.added) == len(edit.removed)
        small += len(edit.added) + len(edit.moved) + len(edit.changed) <= 2 * len(branch) + 1
    assert small > 142


TWO = '<On target="a" place="b"/><Ok/>'


@pytest.mark.parametrize(
    ("first", "second", "wanted"),
    [
        (SEQ.format(TWO), SEQ.format(TWO + "<act/>"), [("Added", "act")]),
        (SEQ.format(TWO), SEQ.format("<Ok/>"), [("Removed", "On(place=b, target=a)")]),
        (SEQ.format(TWO), SEQ.format(TWO.replace('"b"', '"c"')), [("Changed", "On(place=c, target=a)")]),
        (SEQ.format(TWO + "<act/>"), SEQ.format("<act/>" + TWO), [("Moved", "act")]),
        (SEQ.format(TWO), f"<Sequence>{TWO}</Sequence>", [("Changed", "Sequence")]),
        (SEQ.format("<act/>"), SEQ.format('<Action ID="act" name="act"/>'), []),
        (SEQ.format("<act/>"), SEQ.format('<act _note="x"/>'), []),
        (SEQ.format("<act/>"), SEQ.format('<act _skipIf="x"/>'), [("Changed", "act(_skipIf=x)")]),
        (
            SEQ.format(TWO),
            SEQ.format(f"<ReactiveFallback>{TWO[:26]}<act/></ReactiveFallback><Ok/>"),
            [("Added", "ReactiveFallback"), ("Added", "act"), ("Moved", "On(place=b, target=a)")],
        ),
    ],
)
def test_files_without_ids(first: str, second: str, wanted: list[tuple[str, str]]) -> None:
    assert changes(tree(first), tree(second)) == wanted


def test_the_order_of_trees_and_the_named_main_tree_are_no_difference() -> None:
    alone = tree(GUARD)
    assert changes(alone, alone.replace(' main_tree_to_execute="Main"', "")) == []
    two = tree(GUARD, MODEL + other("B"))
    turned = tree(GUARD, MODEL).replace("<BehaviorTree", other("B") + "<BehaviorTree", 1)
    assert changes(two, turned) == []


# -- the command ---------------------------------------------------------------------------------------------------


def test_exit_codes_and_json(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    v1, v2 = (str(kept / "drop" / f"tree.v00{k}.xml") for k in (1, 2))
    assert main(["tree", "diff", v1, v1]) == 0
    assert capsys.readouterr().out == ""
    assert main(["tree", "diff", v1, v2]) == 6
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line[0] != " "][-2:] == [
        "+ │     │     └─ [pick(object_1, workbench)]",
        "5 added",
    ]
    assert main(["tree", "diff", v1, v2, "--json"]) == 6
    told = json.loads(capsys.readouterr().out)
    assert [e["node"] for e in told["added"]] == [
        "->", "(HandEmpty)", "(On(object_1, workbench))", "(Clear(object_1))", "[pick(object_1, workbench)]",
    ]  # fmt: skip
    assert (told["removed"], told["moved"], told["changed"], told["same"]) == ([], [], [], False)
    assert main(["tree", "diff", v1, v1, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["same"] is True
    assert main(["tree", "diff", v1, str(kept / "drop" / "map.xml")]) == 1
    assert main(["tree", "diff", v1, str(tmp_path / "none")]) == 1


def test_a_move_and_a_removal_are_drawn(kept: Path, golden: object, capsys: pytest.CaptureFixture[str]) -> None:
    v1, v2 = (str(kept / "obstacle_at_place" / f"tree.v00{k}.xml") for k in (1, 2))
    assert main(["tree", "diff", v1, v2]) == 6
    assert main(["tree", "diff", v2, v1, "--colour", "always"]) == 6
    golden("moved.txt", capsys.readouterr().out)  # type: ignore[operator]


def test_a_rewritten_file_is_the_same(runs: Path, tmp_path: Path) -> None:
    """Layout, attribute order and dropped ids; and splitting a deep tree elsewhere."""
    v1 = runs / "drop" / "tree.v001.xml"
    saved = tmp_path / "saved.xml"
    saved.write_text(without_ids(v1.read_bytes()))
    assert main(["tree", "diff", str(v1), str(saved)]) == 0
    deep = tmp_path / "deep.xml"
    deep.write_bytes(write_tree(deep_tree(230), SIGNATURES))
    whole = deep.read_text()
    branch = parse_document(whole.encode())
    assert len(branch.trees) == 2
    joined = tmp_path / "joined.xml"
    top = etree.fromstring(whole.encode())
    subtree = top.find(".//SubTree")
    assert subtree is not None
    below = next(t for t in top.iterfind("BehaviorTree") if t.get("ID") == subtree.get("ID"))
    subtree.getparent().replace(subtree, below[0])  # type: ignore[union-attr]
    top.remove(below)
    joined.write_bytes(etree.tostring(top))
    assert parse_tree(joined.read_bytes(), "t").tree == deep_tree(230)
    assert main(["tree", "diff", str(deep), str(joined)]) == 0


def test_the_git_driver_of_the_docs(kept: Path, tmp_path: Path) -> None:
    """The three lines of docs/trees.md, in a repository."""
    text = (Path(__file__).parents[2] / "docs" / "trees.md").read_text()
    lines = [
        line.strip()
        for line in text.splitlines()
        if line.startswith("    ") and ("gitattributes" in line or "git config" in line)
    ]
    assert len(lines) == 2
    env = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "HOME": str(tmp_path)}
    env |= dict.fromkeys(("GIT_AUTHOR_NAME", "GIT_COMMITTER_NAME", "EMAIL"), "x")

    def sh(command: str) -> str:
        done = subprocess.run(
            command, shell=True, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=60, check=False
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    sh("git init -q . && " + " && ".join(lines))
    (tmp_path / "tree.xml").write_bytes((kept / "drop" / "tree.v001.xml").read_bytes())
    sh("git add -A && git commit -qm one")
    (tmp_path / "tree.xml").write_bytes((kept / "drop" / "tree.v002.xml").read_bytes())
    (tmp_path / "new.xml").write_bytes((kept / "drop" / "tree.v000.xml").read_bytes())
    sh("git add -AN")
    shown = sh("git diff")
    assert "[pick(object_1, workbench)]" in shown
    assert "5 added" in shown and "added" in shown.replace("5 added", "", 1)


def git_lines(tmp_path: Path, first: bytes, second: bytes) -> list[str]:
    """The lines that a plain `git diff` shows as added or taken away."""
    for name, data in (("a.xml", first), ("b.xml", second)):
        (tmp_path / name).write_bytes(data)
    command = ["git", "diff", "--no-index", "--unified=0", "a.xml", "b.xml"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode in (0, 1), done.stderr
    return [d for d in done.stdout.splitlines() if d[0] in "+-" and d[:3] not in ("+++", "---")]


def test_a_plain_git_diff_of_two_versions_is_small(kept: Path, tmp_path: Path) -> None:
    """One node a line, attributes in a fixed order: the tree's part is the five nodes that came, and a closing tag."""
    v1, v2 = ((kept / "drop" / f"tree.v00{k}.xml").read_bytes().split(b"<TreeNodesModel>")[0] for k in (1, 2))
    changed = git_lines(tmp_path, v1, v2)
    assert len(changed) == 6
    assert {d[0] for d in changed} == {"+"}


@pytest.mark.parametrize("seed", range(0, 60, 4))
def test_a_plain_git_diff_is_no_larger_than_the_edit(seed: int, tmp_path: Path) -> None:
    """A line for each node that came, went or is another, and one more for a composite's closing tag."""
    rng = random.Random(seed)
    first = distinct(rng)
    second = first
    for id_ in [n.id for n in first.preorder()][1 :: max(1, len(first) // 3)]:
        if id_ not in second.nodes or len(second[second.parents[id_]].children) < 2:
            continue
        if rng.random() < 0.5:
            second = second.without(id_)
        elif not second[id_].children:
            second = second.with_nodes(Node(id_, Kind.ACTION, action=ActionCall("wave")))
    edit = diff(first, second)
    assert edit
    one, two = (write_tree(t, SIGNATURES).split(b"<TreeNodesModel>")[0] for t in (first, second))
    closing = sum(bool(first[e.id].children) for e in edit.removed)
    assert len(git_lines(tmp_path, one, two)) <= len(edit.removed) + closing + 2 * len(edit.changed)


@pytest.mark.parametrize("command", [["show"], ["check"], ["diff", "/dev/null"], ["export", "--format", "dot"]])
def test_a_tree_from_standard_input(
    command: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(tree(GUARD).encode())))
    assert main(["tree", *command, "-"]) == (6 if command[0] == "diff" else 0)
    assert "act" in capsys.readouterr().out or command == ["check"]
