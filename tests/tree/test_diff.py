"""Differences of trees: a diff names exactly the edit that was made, and applied to the first gives the second."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.diff import Spot, apply, diff
from llmbt_ir.tree import Kind, Node, Tree
from tests.strategies import deep_tree, trees

NEW = Tree(
    "new",
    {
        "new": Node("new", Kind.FALLBACK, ("new.1", "new.2")),
        "new.1": Node("new.1", Kind.CONDITION, condition=Condition("P5")),
        "new.2": Node("new.2", Kind.ACTION, action=ActionCall("wave")),
    },
)


def reachable(tree: Tree) -> Tree:
    """Without what is not below the root."""
    return Tree(tree.root, {n.id: n for n in tree.preorder()})


def spot(tree: Tree, id_: str) -> Spot:
    """Where a node is."""
    parent = tree.parents.get(id_)
    row = tree[parent].children if parent else (id_,)
    at = row.index(id_)
    return Spot(parent, row[at - 1] if at else None)


def inserted(tree: Tree, parent: str, at: int, *ids: str) -> Tree:
    """The tree with further children of a node."""
    row = tree[parent].children
    return tree.with_nodes(replace(tree[parent], children=(*row[:at], *ids, *row[at:])))


def inner(tree: Tree) -> list[str]:
    return [n.id for n in tree.preorder() if n.children]


@given(trees())
def test_a_tree_does_not_differ_from_itself(tree: Tree) -> None:
    assert not diff(tree, tree)
    assert apply(diff(tree, tree), tree) == tree


@given(trees(), trees())
def test_any_two_trees(first: Tree, second: Tree) -> None:
    edit = diff(first, second)
    assert apply(edit, first) == second
    assert bool(edit) == (first != second)
    assert apply(diff(second, first), second) == first


@given(trees(), st.data())
def test_an_added_branch_is_named(tree: Tree, data: st.DataObject) -> None:
    assume(inner(tree))
    parent = data.draw(st.sampled_from(inner(tree)))
    at = data.draw(st.integers(0, len(tree[parent].children)))
    after = inserted(tree.with_nodes(*NEW.nodes.values()), parent, at, "new")
    edit = diff(tree, after)
    assert [(e.id, e.at) for e in edit.added] == [(i, spot(after, i)) for i in ("new", "new.1", "new.2")]
    assert not (edit.removed or edit.moved or edit.changed)
    assert apply(edit, tree) == after


@given(trees(), st.data())
def test_a_removed_branch_is_named(tree: Tree, data: st.DataObject) -> None:
    rest = [n.id for n in tree.preorder() if n.id != tree.root]
    assume(rest)
    gone = data.draw(st.sampled_from(rest))
    after = tree.without(gone)
    edit = diff(tree, after)
    assert [(e.id, e.at) for e in edit.removed] == [(n.id, spot(tree, n.id)) for n in tree.preorder(gone)]
    assert not (edit.added or edit.moved or edit.changed)
    assert apply(edit, tree) == after


@given(trees(), st.data())
def test_a_move_is_named(tree: Tree, data: st.DataObject) -> None:
    rest = [n.id for n in tree.preorder() if n.id != tree.root]
    assume(rest)
    moved = data.draw(st.sampled_from(rest))
    below = {n.id for n in tree.preorder(moved)}
    parent = data.draw(st.sampled_from([i for i in inner(tree) if i not in below]))
    branch = {n.id: n for n in tree.preorder(moved)}
    without = tree.without(moved)
    at = data.draw(st.integers(0, len(without[parent].children)))
    after = inserted(without.with_nodes(*branch.values()), parent, at, moved)
    edit = diff(tree, after)
    assert apply(edit, tree) == after
    if after == tree:
        assert not edit
        return
    assert not (edit.added or edit.removed or edit.changed)
    (only,) = edit.moved
    if only.id != moved:  # two neighbours that change places: either of them has moved
        assert {only.id, moved} <= set(after[parent].children)
        row, now = tree[parent].children, after[parent].children
        assert abs(row.index(moved) - now.index(moved)) == 1
    else:
        assert only.before == spot(tree, moved)
        assert only.at == spot(after, moved)


@given(trees(), st.data())
def test_a_change_is_named(tree: Tree, data: st.DataObject) -> None:
    node = tree[data.draw(st.sampled_from([n.id for n in tree.preorder()]))]
    if node.children:
        other = replace(node, kind=Kind.FALLBACK if node.kind is Kind.SEQUENCE else Kind.SEQUENCE)
    else:
        other = Node(node.id, Kind.ACTION, action=ActionCall("pick", ("else", "where")))
        assume(other != node)
    after = tree.with_nodes(other)
    edit = diff(tree, after)
    (only,) = edit.changed
    assert (only.id, only.before, only.content) == (node.id, replace(node, children=()), replace(other, children=()))
    assert not (edit.added or edit.removed or edit.moved)
    assert apply(edit, tree) == after


@given(trees(), trees())
def test_a_diff_of_another_tree_is_refused(first: Tree, second: Tree) -> None:
    after = replace(second, root=second.root)
    edit = diff(first, after)
    third = Tree("z", {"z": Node("z", Kind.CONDITION, condition=Condition("P0"))})
    assume(edit.removed or edit.moved or edit.changed)
    with pytest.raises(ValueError, match="not of this tree"):
        apply(edit, third)


def test_as_few_moves_as_the_ids_allow() -> None:
    leaves = [Node(f"l{i}", Kind.CONDITION, condition=Condition(f"P{i}")) for i in range(6)]
    first = Tree("r", {n.id: n for n in (Node("r", Kind.SEQUENCE, tuple(n.id for n in leaves)), *leaves)})
    second = first.with_nodes(Node("r", Kind.SEQUENCE, ("l5", "l0", "l1", "l2", "l4", "l3")))
    edit = diff(first, second)
    assert len(edit.moved) == 2
    assert "l5" in {m.id for m in edit.moved}
    assert apply(edit, first) == second


def test_deep_and_long() -> None:
    deep = deep_tree(5_000)
    other = deep.with_nodes(replace(deep["end"], action=ActionCall("a1")))
    assert [e.id for e in diff(deep, other)] == ["end"]
    assert apply(diff(deep, other), deep) == other
    leaves = [Node(f"l{i}", Kind.CONDITION, condition=Condition(f"P{i}")) for i in range(20_000)]
    ids = tuple(n.id for n in leaves)
    long = Tree("r", {n.id: n for n in (Node("r", Kind.SEQUENCE, ids), *leaves)})
    turned = long.with_nodes(Node("r", Kind.SEQUENCE, (*ids[1:], ids[0])))
    assert [e.id for e in diff(long, turned)] == ["l0"]
    assert apply(diff(long, turned), long) == turned
    assert apply(diff(long, deep), long) == reachable(deep)
