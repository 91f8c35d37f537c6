"""The semantics of a tick: reactive, memoryless, one action at a time."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.tree import Kind, Node, Tree
from llmbt_runtime.tick import NodeStatus, tick
from tests.oracle import naive_tick
from tests.strategies import FLAGS, deep_tree, trees

S, F, R = NodeStatus.SUCCESS, NodeStatus.FAILURE, NodeStatus.RUNNING
OPPOSITE = {S: F, F: S, R: R}
facts_of = st.frozensets(st.sampled_from(FLAGS))


def reports_for(tree: Tree, data: st.DataObject) -> dict[str, NodeStatus]:
    actions = sorted(n.id for n in tree.nodes.values() if n.action is not None)
    return data.draw(st.dictionaries(st.sampled_from(actions), st.sampled_from([S, F, R]))) if actions else {}


def negation(tree: Tree) -> Tree:
    """Sequence for Fallback and each condition for its complement."""
    swap = {Kind.SEQUENCE: Kind.FALLBACK, Kind.FALLBACK: Kind.SEQUENCE}
    return Tree(
        tree.root,
        {
            k: Node(k, swap.get(n.kind, n.kind), n.children, ~n.condition if n.condition else None, n.action)
            for k, n in tree.nodes.items()
        },
    )


@settings(max_examples=300)
@given(trees(plain=True), facts_of, st.data())
def test_a_tick_is_what_the_naive_engine_says(tree: Tree, facts: Facts, data: st.DataObject) -> None:
    reports = reports_for(tree, data)
    record = tick(tree, facts, reports)
    status, running, trace = naive_tick(tree, facts, reports)
    assert (record.status, record.action, list(record.trace)) == (status, running[0] if running else None, trace)


@given(trees(plain=True), facts_of, st.data())
def test_fallback_is_sequence_under_negation(tree: Tree, facts: Facts, data: st.DataObject) -> None:
    reports = reports_for(tree, data)
    record = tick(tree, facts, reports)
    mirrored = tick(negation(tree), facts, {k: OPPOSITE[v] for k, v in reports.items()})
    assert mirrored.status is OPPOSITE[record.status]
    assert mirrored.trace == tuple((id_, OPPOSITE[status]) for id_, status in record.trace)
    assert mirrored.action == record.action


@given(trees(plain=True), facts_of, st.data())
def test_at_most_one_action_runs_and_then_the_root_does(tree: Tree, facts: Facts, data: st.DataObject) -> None:
    record = tick(tree, facts, reports_for(tree, data))
    running = [id_ for id_, status in record.trace if status is R and tree[id_].action is not None]
    assert running == ([record.action] if record.action else [])
    assert (record.status is R) == (record.action is not None)


@given(trees(plain=True), facts_of)
def test_a_tick_keeps_no_memory(tree: Tree, facts: Facts) -> None:
    first = tick(tree, facts)
    tick(tree, frozenset())
    assert tick(tree, facts) == first


@given(trees(plain=True), facts_of)
def test_no_node_is_ticked_twice_and_children_before_their_parents(tree: Tree, facts: Facts) -> None:
    order = [id_ for id_, _ in tick(tree, facts).trace]
    assert len(order) == len(set(order))
    assert order[-1] == tree.root
    assert all(order.index(id_) < order.index(tree.parents[id_]) for id_ in order[:-1])


def test_a_tick_does_not_recurse() -> None:
    tree = deep_tree(20_000)
    record = tick(tree, frozenset({Condition("P0")}))
    assert (record.status, record.action, len(record.trace)) == (R, "end", 39_999)


# -- the backchaining tree of behaviortree-cpp.md --------------------------------------------------------------------

CHAINED = Tree(
    "root",
    {
        n.id: n
        for n in (
            Node("root", Kind.SEQUENCE, ("f1", "f2")),
            Node("f1", Kind.FALLBACK, ("g1", "s1")),
            Node("s1", Kind.SEQUENCE, ("p1", "a1")),
            Node("f2", Kind.FALLBACK, ("g2", "s2")),
            Node("s2", Kind.SEQUENCE, ("p2", "a2")),
            *(Node(c, Kind.CONDITION, condition=Condition(c)) for c in ("g1", "p1", "g2", "p2")),
            *(Node(a, Kind.ACTION, action=ActionCall(a)) for a in ("a1", "a2")),
        )
    },
)
"""Seq[Fb(g1, Seq(p1, a1)), Fb(g2, Seq(p2, a2))]"""


def test_the_scripted_sequence_of_statuses() -> None:
    """a2 runs; g1 turns false, so a1 takes over; g1 holds again, so a2 goes on; p2 false fails; g2 true succeeds."""
    script = [
        ("g1 p1 p2", R, "a2", "g1+ f1+ g2- p2+ a2~ s2~ f2~ root~"),
        ("p1 p2", R, "a1", "g1- p1+ a1~ s1~ f1~ root~"),
        ("g1 p1 p2", R, "a2", "g1+ f1+ g2- p2+ a2~ s2~ f2~ root~"),
        ("g1 p1", F, None, "g1+ f1+ g2- p2- s2- f2- root-"),
        ("g1 g2", S, None, "g1+ f1+ g2+ f2+ root+"),
        ("", F, None, "g1- p1- s1- f1- root-"),
    ]
    sign = {S: "+", F: "-", R: "~"}
    for facts, status, action, trace in script:
        record = tick(CHAINED, frozenset(Condition(f) for f in facts.split()))
        assert (record.status, record.action) == (status, action)
        assert " ".join(id_ + sign[s] for id_, s in record.trace) == trace


def test_what_failed_last_is_where_expand_starts() -> None:
    record = tick(CHAINED, frozenset({Condition("g1")}))
    assert record.failed_leaves()[:4] == ("root", "f2", "s2", "p2")


@pytest.mark.parametrize(("report", "status"), [(S, S), (F, F), (R, R)])
def test_an_action_that_succeeds_before_its_condition_holds_lets_the_root_succeed(
    report: NodeStatus, status: NodeStatus
) -> None:
    """As BehaviorTree.CPP does: so the goals are looked at again before the task is called done."""
    assert tick(CHAINED, frozenset({Condition("g1"), Condition("p2")}), {"a2": report}).status is status
