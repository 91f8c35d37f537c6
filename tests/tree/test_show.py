"""`tree show` and the pictures of `tree export`; deep and long trees."""

from __future__ import annotations

import itertools
import json
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from llmbt.draw import diff_drawing, drawing
from llmbt.exports.graphs import dot, mermaid
from llmbt.exports.layout import arrange
from llmbt.exports.svg import svg
from llmbt.main import main
from llmbt.picture import box_of, picture_of_tree
from llmbt_ir.condition import Condition
from llmbt_ir.diff import diff_tables, table_of
from llmbt_ir.tree import Kind, Node, Tree
from llmbt_ir.tree_xml import write_tree
from tests.strategies import SIGNATURES, deep_tree, trees
from tests.tree.test_files import FOREIGN

SVG = "{http://www.w3.org/2000/svg}"


def told(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    capsys.readouterr()
    assert main(["tree", *map(str, arguments)]) == 0
    return capsys.readouterr().out


def test_statuses_in_the_recorded_state(
    kept: Path, golden: Callable[[str, str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    golden("show_v002.txt", told(capsys, "show", kept / "drop"))
    assert told(capsys, "show", kept / "drop") == told(capsys, "show", kept / "drop" / "tree.v002.xml")
    coloured = told(capsys, "show", kept / "drop", "--colour", "always")
    assert "\x1b[32m(HandEmpty) ✓\x1b[0m" in coloured
    assert "\x1b[31m(Holding(object_1)) ✗\x1b[0m" in coloured
    assert "\x1b[33m[pick(object_1, workbench)] …\x1b[0m" in coloured
    assert re.sub("\x1b\\[[0-9]*m", "", coloured) == told(capsys, "show", kept / "drop")
    plain = told(capsys, "show", kept / "drop", "--plain")
    assert not set("✓✗…") & set(plain)
    older = told(capsys, "show", kept / "drop" / "tree.v002.xml", "--state", kept / "drop" / "tree.v001.json")
    assert "[pick(object_1, sorting_area)] …" in older
    assert "   g1\n" in told(capsys, "show", kept / "drop", "--ids")
    nodes = json.loads(told(capsys, "show", kept / "drop", "--json"))["nodes"]
    assert next(n for n in nodes if n["id"] == "g1")["status"] == "FAILURE"


def test_any_file_is_shown(
    tmp_path: Path, golden: Callable[[str, str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "t.xml"
    path.write_text(FOREIGN)
    golden("show_foreign.txt", told(capsys, "show", path))
    for form in ("svg", "dot", "mermaid"):
        assert "Drive" in told_bytes(tmp_path, "export", path, "--format", form)
    path.write_text("<a/>")
    assert main(["tree", "show", str(path)]) == 1


def told_bytes(tmp_path: Path, *arguments: str | Path) -> str:
    out = tmp_path / "out"
    assert main(["tree", *map(str, arguments), "-o", str(out)]) == 0
    return out.read_text()


def test_a_picture_stands_alone(kept: Path, tmp_path: Path) -> None:
    for direction in ("down", "right", "auto"):
        text = told_bytes(tmp_path, "export", kept / "drop", "--format", "svg", "--direction", direction)
        root = etree.fromstring(text.encode())
        assert "href" not in text and "url(" not in text
        texts = [t.text for t in root.iter(f"{SVG}text")]
        assert len(texts) == 78
        assert "pick(object_1, workbench)" in texts
        assert len(root.findall(f"{SVG}path")) == 77
    assert float(str(root.get("width"))) <= 1_600


@pytest.mark.parametrize("direction", ["down", "right"])
@given(made=trees(max_leaves=40))
def test_nothing_lies_on_anything(direction: str, made: Tree) -> None:
    root = etree.fromstring(svg(picture_of_tree(made), direction=direction).encode())
    boxes = []
    for group in root.iterfind(f"{SVG}g"):
        shape = group[1]
        get = lambda name, shape=shape: float(str(shape.get(name)))  # noqa: E731
        if shape.tag == f"{SVG}ellipse":
            boxes.append((get("cx") - get("rx"), get("cy") - get("ry"), 2 * get("rx"), 2 * get("ry")))
        else:
            boxes.append((get("x"), get("y"), get("width"), get("height")))
    assert len(boxes) == len(made)
    for k, (x, y, w, h) in enumerate(boxes):
        assert x >= 0 and x + w <= float(str(root.get("width"))) + 1
        for x2, y2, w2, h2 in boxes[:k]:
            assert x + w <= x2 + 0.2 or x2 + w2 <= x + 0.2 or y + h <= y2 + 0.2 or y2 + h2 <= y + 0.2


@given(trees(max_leaves=40), st.data())
def test_the_layout_keeps_the_order(made: Tree, data: st.DataObject) -> None:
    extent = {n.id: data.draw(st.floats(1, 50)) for n in made.preorder()}
    children = {n.id: n.children for n in made.preorder()}
    places = arrange((made.root,), children, extent, 5.0)
    for id_, kids in children.items():
        assert all(places[c].level == places[id_].level + 1 for c in kids)
        for a, b in itertools.pairwise(kids):
            gap = places[b].across - extent[b] / 2 - places[a].across - extent[a] / 2
            assert gap >= 5.0 - 1e-6
        if kids:
            assert places[id_].across == pytest.approx((places[kids[0]].across + places[kids[-1]].across) / 2)


@given(trees())
def test_graphs_name_every_node_and_edge(made: Tree) -> None:
    picture = picture_of_tree(made)
    for text, arrow in ((dot(picture), " -> n"), (mermaid(picture), " --> n")):
        assert text.count(arrow) == len(made) - 1
    assert dot(picture).count("[label=") == len(made)
    assert len(drawing(made).splitlines()) == len(made)


@given(trees(), trees())
def test_every_difference_is_drawn(first: Tree, second: Tree) -> None:
    a, b = table_of(first), table_of(second)
    edit = diff_tables(a, b)
    text = diff_drawing(a, b, edit, lambda node: box_of(node).mark())
    marks = Counter(line[0] for line in text.splitlines())
    moved = {m.id for m in edit.moved}
    assert (marks["+"], marks["-"], marks[">"]) == (len(edit.added), len(edit.removed), len(moved))
    assert marks["~"] == len([c for c in edit.changed if c.id not in moved])


def test_control_characters_do_not_reach_the_terminal() -> None:
    evil = Tree("a", {"a": Node("a", Kind.CONDITION, condition=Condition("P", ("\x1b[2J",)))})
    assert "\x1b" not in drawing(evil)
    etree.fromstring(svg(picture_of_tree(evil)).encode())


def test_deep_and_long(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """5,000 levels, and 20,000 nodes side by side, through every command that reads a tree."""
    leaves = [Node(f"l{i}", Kind.CONDITION, condition=Condition("P1")) for i in range(20_000)]
    long = Tree("r", {n.id: n for n in (Node("r", Kind.SEQUENCE, tuple(n.id for n in leaves)), *leaves)})
    deep = tmp_path / "deep.xml"
    for name, made in (("deep", deep_tree(5_000)), ("long", long)):
        path = tmp_path / f"{name}.xml"
        path.write_bytes(write_tree(made, SIGNATURES))
        lines = told(capsys, "show", path).splitlines()
        assert len(lines) == len(made)
        assert max(map(len, lines)) < 300
        for form in ("svg", "dot", "mermaid"):
            assert len(told_bytes(tmp_path, "export", path, "--format", form)) > 100_000
        assert main(["tree", "check", str(path)]) == 0
        assert main(["tree", "diff", str(path), str(path)]) == 0
    assert main(["tree", "diff", str(deep), str(tmp_path / "long.xml")]) == 6
    assert main(["tree", "diff", "/dev/null", str(deep)]) == 6
    assert main(["tree", "export", str(deep), "--format", "btcpp", "-o", str(tmp_path / "p")]) == 0
