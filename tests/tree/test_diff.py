"""Differences of trees: a diff names exactly the edit that was made, and applied to the first gives the second."""

from __future__ import annotations

import random
from dataclasses import dataclass, field, replace

import pytest
from hypothesis import assume, given, settings
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


@given(trees(), st.integers(0, 10_000), st.integers(2, 6))
def test_several_edits_are_named(tree: Tree, seed: int, count: int) -> None:
    """Branches added, leaves removed and changed, branches moved to anywhere: which nodes came, went and changed is
    told exactly, no more is said to have moved than was moved, and applied to the first the diff gives the second."""
    rng, after, moves = random.Random(seed), tree, 0
    for k in range(count):
        ids = [n.id for n in after.preorder()]
        kind = rng.choice(("add", "remove", "move", "move", "change"))
        if kind == "add" and inner(after):
            new = Node(f"new{k}", Kind.CONDITION, condition=Condition("P5"))
            parent = rng.choice(inner(after))
            after = inserted(after.with_nodes(new), parent, rng.randint(0, len(after[parent].children)), new.id)
        elif kind == "remove" and len(ids) > 1:
            after = after.without(rng.choice(ids[1:]))
        elif kind == "change":
            leaf = after[rng.choice(ids)]
            if not leaf.children:
                changed = Node(leaf.id, Kind.ACTION, action=ActionCall("wave", (str(k),)))
                after = after.with_nodes(changed)
        elif kind == "move" and len(ids) > 1:
            moved = rng.choice(ids[1:])
            branch = {n.id: n for n in after.preorder(moved)}
            parents = [i for i in inner(after) if i not in branch]
            parent = rng.choice(parents)
            rest = after.without(moved)
            if parent in rest.nodes and rest[parent].kind in (Kind.SEQUENCE, Kind.FALLBACK):
                at = rng.randint(0, len(rest[parent].children))
                after = inserted(rest.with_nodes(*branch.values()), parent, at, moved)
                moves += 1
    after = reachable(after)
    edit = diff(tree, after)
    assert apply(edit, tree) == after
    assert {e.id for e in edit.added} == set(after.nodes) - set(tree.nodes)
    assert {e.id for e in edit.removed} == set(tree.nodes) - set(after.nodes)
    both = set(tree.nodes) & set(after.nodes)
    content = {i: [(n.kind, n.condition, n.action) for n in (tree[i], after[i])] for i in both}
    assert {e.id for e in edit.changed} == {i for i, (old, new) in content.items() if old != new}
    assert len(edit.moved) <= moves


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


# -- several edits at once -------------------------------------------------------------------------------------------


@dataclass
class Script:
    """A tree under edit, and what was done to it."""

    tree: Tree
    rng: random.Random
    added: int = 0
    moves: int = 0
    touched: set[str] = field(default_factory=set)

    def step(self) -> None:
        """One random edit; nothing where the tree has no room for it."""
        rest = [n.id for n in self.tree.preorder() if n.id != self.tree.root]
        kind = self.rng.choice(["add", "add", "remove", "move", "move", "change"])
        if kind == "add" and inner(self.tree):
            self.add()
        elif kind == "change":
            self.change(self.rng.choice([self.tree.root, *rest]))
        elif kind == "remove" and rest:
            gone = self.rng.choice(rest)
            if len(self.tree[self.tree.parents[gone]].children) > 1:
                self.touched |= {n.id for n in self.tree.preorder(gone)}
                self.tree = self.tree.without(gone)
        elif kind == "move" and rest:
            self.move(self.rng.choice(rest))

    def add(self) -> None:
        """A branch of two or three nodes."""
        self.added += 1
        top, leaf, other = f"+{self.added}", f"+{self.added}.1", f"+{self.added}.2"
        branch = (
            Node(top, self.rng.choice([Kind.SEQUENCE, Kind.FALLBACK]), (leaf, other)),
            Node(leaf, Kind.CONDITION, condition=Condition(f"P{self.added % 6}")),
            Node(other, Kind.ACTION, action=ActionCall("wave")),
        )
        self.touched |= {n.id for n in branch}
        parent = self.rng.choice(inner(self.tree))
        at = self.rng.randint(0, len(self.tree[parent].children))
        self.tree = inserted(self.tree.with_nodes(*branch), parent, at, top)

    def change(self, id_: str) -> None:
        """Something else in its place."""
        node = self.tree[id_]
        self.touched.add(id_)
        if node.children:
            other = replace(node, kind=Kind.FALLBACK if node.kind is Kind.SEQUENCE else Kind.SEQUENCE)
        else:
            other = Node(id_, Kind.CONDITION, condition=Condition(f"P{self.rng.randrange(6)}", (), True))
        self.tree = self.tree.with_nodes(other)

    def move(self, id_: str) -> None:
        """To another parent, or another place."""
        branch = {n.id: n for n in self.tree.preorder(id_)}
        if len(self.tree[self.tree.parents[id_]].children) == 1:
            return
        without = self.tree.without(id_)
        parent = self.rng.choice(inner(without))
        at = self.rng.randint(0, len(without[parent].children))
        self.tree = inserted(without.with_nodes(*branch.values()), parent, at, id_)
        self.moves += 1
        self.touched.add(id_)


def stays(tree: Tree, other: Tree, parent: str) -> int:
    """Of a node's children that both trees have there, how many can keep their order: the longest common
    subsequence, by its table."""
    a, b = ([c for c in t[parent].children if c in u[parent].children] for t, u in ((tree, other), (other, tree)))
    table = [[0] * (len(b) + 1) for _ in range(len(a) + 1)]
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            table[i + 1][j + 1] = table[i][j] + 1 if x == y else max(table[i][j + 1], table[i + 1][j])
    return table[-1][-1]


@settings(max_examples=120)
@given(trees(), st.integers(0, 10_000), st.integers(1, 8))
def test_of_several_edits_exactly_their_sum_is_named(first: Tree, seed: int, steps: int) -> None:
    """Added, removed and changed are exactly the nodes that are; moved are those that have another parent, and of
    those that have not, as few as their order allows. Nothing is named that no edit touched, but for neighbours of
    what was moved."""
    script = Script(first, random.Random(seed))
    for _ in range(steps):
        script.step()
    second = reachable(script.tree)
    edit = diff(first, second)
    assert apply(edit, first) == second
    a, b = set(first.nodes), set(second.nodes)
    assert {e.id for e in edit.added} == b - a
    assert {e.id for e in edit.removed} == a - b
    bare = {i: (replace(first[i], children=()), replace(second[i], children=())) for i in a & b}
    assert {e.id for e in edit.changed} == {i for i, (x, y) in bare.items() if x != y}
    assert all(e.at == spot(second, e.id) for e in (*edit.added, *edit.moved))
    assert all(e.at == spot(first, e.id) for e in edit.removed)
    assert all(e.before == spot(first, e.id) for e in edit.moved)
    elsewhere = {i for i in a & b if first.parents.get(i) != second.parents.get(i)}
    within = {e.id for e in edit.moved} - elsewhere
    assert elsewhere <= {e.id for e in edit.moved}
    for parent in a & b:
        same = {c for c in second[parent].children if first.parents.get(c) == parent}
        assert len(within & same) == len(same) - stays(first, second, parent)
    assert {e.id for e in (*edit.added, *edit.removed, *edit.changed)} | elsewhere <= script.touched
    assert len(edit.moved) <= script.moves
    back = diff(second, first)
    assert ({e.id for e in back.added}, {e.id for e in back.removed}) == (a - b, b - a)
    assert {e.id for e in back.changed} == {e.id for e in edit.changed}


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
