"""What a tick of the incremental engine costs: what changed, at any size and depth of the tree."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.tree import Kind, Node, Tree
from llmbt_runtime.engine.incremental import IncrementalEngine
from llmbt_runtime.engine.naive import NaiveEngine
from llmbt_runtime.engine.program import program_of_tree
from llmbt_runtime.engine.ticker import Ticker
from llmbt_runtime.engine.values import Values
from llmbt_runtime.facts import NO_CHANGE, Change, FactBase, change_between
from llmbt_runtime.tick import NodeStatus, tick
from tests.engine.cases import FLAGS, random_case
from tests.strategies import deep_tree, trees

RUNNING = NodeStatus.RUNNING
PLAIN_FACTS = st.frozensets(st.sampled_from([Condition(f) for f in FLAGS]))


class Busy:
    """Leaves of which each runs until it is halted."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, int]] = []

    def start(self, node: int) -> NodeStatus:
        """Runs."""
        self.calls.append(("start", node))
        return RUNNING

    def poll(self, node: int) -> NodeStatus:
        """Still runs."""
        self.calls.append(("poll", node))
        return RUNNING

    def halt(self, node: int) -> None:
        """Noted."""
        self.calls.append(("halt", node))


def goals_tree(goals: int) -> Tree:
    """ReactiveSequence of Fallback(goal, Sequence(two preconditions, action)): six nodes a goal and one."""
    nodes = [Node("root", Kind.SEQUENCE, tuple(f"f{i}" for i in range(goals)))]
    for i in range(goals):
        nodes += [
            Node(f"f{i}", Kind.FALLBACK, (f"g{i}", f"s{i}")),
            Node(f"g{i}", Kind.CONDITION, condition=Condition("Goal", (str(i),))),
            Node(f"s{i}", Kind.SEQUENCE, (f"p{i}", f"q{i}", f"a{i}")),
            Node(f"p{i}", Kind.CONDITION, condition=Condition("Pre", (str(i),))),
            Node(f"q{i}", Kind.CONDITION, condition=Condition("Block", (str(i),), True)),
            Node(f"a{i}", Kind.ACTION, action=ActionCall("reach", (str(i),))),
        ]
    return Tree("root", {n.id: n for n in nodes})


def goal(i: int) -> Condition:
    return Condition("Goal", (str(i),))


def start_state(goals: int) -> Facts:
    """All preconditions hold, and all goals but the last."""
    return frozenset({Condition("Pre", (str(i),)) for i in range(goals)} | {goal(i) for i in range(goals - 1)})


@pytest.mark.parametrize("goals", [16, 166, 1_666])
def test_nothing_changed_costs_one_question_to_the_action(goals: int) -> None:
    leaves = Busy()
    engine = IncrementalEngine(program_of_tree(goals_tree(goals)), leaves)
    assert engine.tick(Change(start_state(goals)), 0) is RUNNING
    before = engine.evaluations
    leaves.calls.clear()
    for k in range(10):
        assert engine.tick(NO_CHANGE, 100 * k) is RUNNING
    assert engine.evaluations == before
    assert [verb for verb, _ in leaves.calls] == ["poll"] * 10


@pytest.mark.parametrize("goals", [16, 166, 1_666])
def test_one_fact_costs_the_conditions_that_look_at_it(goals: int) -> None:
    """The first goal is lost and comes back: its action takes over, and the last one's starts anew."""
    leaves = Busy()
    program = program_of_tree(goals_tree(goals))
    engine = IncrementalEngine(program, leaves)
    engine.tick(Change(start_state(goals)), 0)
    before = engine.evaluations
    leaves.calls.clear()
    lost, again = Change(removed=frozenset({goal(0)})), Change(added=frozenset({goal(0)}))
    for change in (lost, NO_CHANGE, again):
        assert engine.tick(change, 0) is RUNNING
    assert engine.evaluations == before + 2
    names = [(verb, program.nodes[n].id) for verb, n in leaves.calls]
    first, last = "a0", f"a{goals - 1}"
    assert names == [
        ("start", first),
        ("halt", last),
        ("poll", first),
        ("halt", first),
        ("start", last),
    ]


def test_the_naive_engine_asks_every_condition() -> None:
    leaves = Busy()
    engine = NaiveEngine(program_of_tree(goals_tree(16)), leaves)
    engine.tick(Change(start_state(16)), 0)
    before = engine.evaluations
    engine.tick(NO_CHANGE, 0)
    assert engine.evaluations - before == 15 + 3


@given(st.integers(0, 10_000), st.data())
def test_values_do_not_depend_on_the_way_to_a_state(seed: int, data: st.DataObject) -> None:
    program = random_case(seed).program
    kept = Values(program)
    facts: Facts = frozenset()
    for after in data.draw(st.lists(PLAIN_FACTS, min_size=1, max_size=6)):
        kept.learn(change_between(facts, after))
        facts = after
        fresh = Values(program)
        fresh.learn(Change(after))
        assert (kept.value, kept.stops) == (fresh.value, fresh.stops)


@given(trees(plain=True), st.lists(PLAIN_FACTS, max_size=5))
def test_on_our_trees_both_do_what_the_pure_tick_says(tree: Tree, schedule: list[Facts]) -> None:
    """`llmbt_runtime.tick`, which plans are rolled out with: which action is wanted, and every leaf on the way."""
    program = program_of_tree(tree)
    for engine_of in (NaiveEngine, IncrementalEngine):
        leaves = Busy()
        engine = engine_of(program, leaves)
        engine.trace = []
        before: Facts = frozenset()
        for facts in schedule:
            change, before = change_between(before, facts), facts
            status = engine.tick(change, 0)
            record = tick(tree, facts)
            found = [(program.nodes[n].id, s) for n, s in engine.trace]
            engine.trace.clear()
            assert status is record.status
            assert found == [(i, s) for i, s in record.trace if not tree[i].children]


@given(st.lists(st.tuples(trees(plain=True), st.lists(PLAIN_FACTS, min_size=1, max_size=4)), max_size=3))
def test_the_executors_ticker_wants_what_the_pure_tick_wants(runs: list[tuple[Tree, list[Facts]]]) -> None:
    ticker, base = Ticker(), FactBase()
    for tree, schedule in runs:
        for facts in schedule:
            base.become(facts)
            wanted, record = ticker.tick(tree, base), tick(tree, facts)
            assert (wanted.status, wanted.action) == (record.status, record.action)


@pytest.mark.parametrize("engine_of", [NaiveEngine, IncrementalEngine])
def test_ten_thousand_levels(engine_of: type) -> None:
    leaves = Busy()
    engine = engine_of(program_of_tree(deep_tree(10_000)), leaves)
    holds = frozenset({Condition("P0")})
    assert engine.tick(Change(holds), 0) is RUNNING
    assert engine.tick(NO_CHANGE, 0) is RUNNING
    assert [verb for verb, _ in leaves.calls] == ["start", "poll"]
    assert engine.tick(Change(removed=holds), 0) is NodeStatus.FAILURE
    assert leaves.calls[-1][0] == "halt"
    engine.tick(Change(holds), 0)
    engine.halt()
    assert leaves.calls[-1][0] == "halt"


# -- what changed ----------------------------------------------------------------------------------------------------


def test_a_fact_base_tells_what_changed_since_it_was_asked() -> None:
    rng = random.Random(1)
    facts = [Condition(f"P{i}") for i in range(8)]
    base = FactBase(facts[:4])
    told: Facts = frozenset()
    for _ in range(500):
        for _ in range(rng.randrange(4)):
            fact = rng.choice(facts)
            (base.add if rng.random() < 0.5 else base.remove)(fact)
        change = base.take()
        assert change == change_between(told, base.facts)
        told = base.facts
        assert base.facts is told and base.take() is NO_CHANGE


@given(st.frozensets(st.integers(0, 9)), st.frozensets(st.integers(0, 9)))
def test_a_change_leads_from_one_state_to_the_other(first: frozenset[int], second: frozenset[int]) -> None:
    before, after = (frozenset(Condition(str(i)) for i in s) for s in (first, second))
    change = change_between(before, after)
    assert (before - change.removed) | change.added == after
    assert bool(change) == (before != after)
