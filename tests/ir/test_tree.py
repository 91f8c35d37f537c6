"""Trees as values: ids are stable, edits lose nothing, and nothing recurses on depth."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.tree import Kind, Node, Tree, goal_tree, goals_of, node_id
from tests.strategies import deep_tree, trees

A, B, D = Condition("P0"), Condition("P1"), Condition("P2")


def ids(tree: Tree) -> set[str]:
    return {n.id for n in tree.preorder()}


def test_the_initial_tree_is_a_sequence_of_the_goals_each_once() -> None:
    tree = goal_tree(((A, B, A),))
    assert tree["root"] == Node("root", Kind.SEQUENCE, ("g1", "g2"))
    assert [tree[i].condition for i in ("g1", "g2")] == [A, B]
    assert goals_of(tree) == ((A, B),)


def test_alternatives_are_a_fallback_of_sequences() -> None:
    tree = goal_tree(((A, B), (D,)))
    assert tree["root"].kind is Kind.FALLBACK
    assert goals_of(tree) == ((A, B), (D,))
    assert {n.id for n in tree.nodes.values()} == {"root", "alt1", "alt2", "g1", "g2", "g3"}


@pytest.mark.parametrize("goals", [(), ((),), ((A,), ())])
def test_a_tree_without_a_goal_is_refused(goals: tuple[tuple[Condition, ...], ...]) -> None:
    with pytest.raises(ValueError, match="goal"):
        goal_tree(goals)


def test_an_id_comes_from_the_goal_and_the_chain_of_expansions() -> None:
    assert node_id("g1") == "g1"
    assert node_id("g1", "pick(a)") == node_id("g1", "pick(a)")
    assert node_id(node_id("g1", "pick(a)"), "x").startswith("g1.")
    assert len({node_id("g1", "a", "b"), node_id("g1", "ab"), node_id("g1", "b", "a"), node_id("g2", "a", "b")}) == 4


def test_ids_do_not_collide_in_trees_of_a_hundred_thousand_nodes() -> None:
    assert len({node_id("g1", str(i)) for i in range(100_000)}) == 100_000


@given(trees(), st.data())
def test_a_move_changes_the_order_and_nothing_else(tree: Tree, data: st.DataObject) -> None:
    wide = [n for n in tree.nodes.values() if len(n.children) > 1]
    if not wide:
        return
    above = data.draw(st.sampled_from(wide))
    j, i = data.draw(st.permutations(above.children))[:2]
    moved = tree.move_before(j, i)
    assert ids(moved) == ids(tree)
    assert {k: v for k, v in moved.nodes.items() if k != above.id} == {
        k: v for k, v in tree.nodes.items() if k != above.id
    }
    children = moved[above.id].children
    assert children[children.index(i) - 1] == j
    assert [c for c in children if c != j] == [c for c in above.children if c != j]


@given(trees(), st.data())
def test_substituting_a_parent_for_a_node_keeps_the_node(tree: Tree, data: st.DataObject) -> None:
    id_ = data.draw(st.sampled_from(sorted(ids(tree))))
    new = Node("new", Kind.FALLBACK, (id_, "act"))
    act = Node("act", Kind.ACTION, action=ActionCall("wave"))
    grown = tree.substitute(id_, new, act)
    assert ids(grown) == ids(tree) | {"new", "act"}
    assert grown.parents[id_] == "new"
    assert grown.parents.get("new") == tree.parents.get(id_)


@given(trees(), st.data())
def test_taking_a_subtree_out_takes_that_subtree_out(tree: Tree, data: st.DataObject) -> None:
    inner = sorted(ids(tree) - {tree.root})
    if not inner:
        return
    id_ = data.draw(st.sampled_from(inner))
    smaller = tree.without(id_)
    assert ids(smaller) == ids(tree) - {n.id for n in tree.preorder(id_)}
    assert set(smaller.nodes) == ids(smaller)


@given(trees())
def test_every_node_but_the_root_has_one_parent(tree: Tree) -> None:
    assert set(tree.parents) == ids(tree) - {tree.root}
    for id_, parent in tree.parents.items():
        assert id_ in tree[parent].children
        assert next(iter(tree.ancestors(id_))) == parent


def test_nothing_recurses_on_depth() -> None:
    tree = deep_tree(20_000)
    assert tree.depth() == 20_000
    assert len(list(tree.preorder())) == len(tree) == 2 * 20_000 - 1
    assert sum(1 for _ in tree.ancestors("end")) == 19_999
    assert tree.move_before("d1", "c0").depth() == 20_000
    assert len(tree.without("d10000")) == 20_000


def test_equal_trees_are_equal_and_hash_alike() -> None:
    assert deep_tree(50) == deep_tree(50)
    assert hash(deep_tree(50)) == hash(deep_tree(50))
    assert deep_tree(50) != deep_tree(51)
