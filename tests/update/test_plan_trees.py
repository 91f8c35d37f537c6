"""Trees made of a plan: grouped rows mean what flat rows mean, and a tree along the causal links runs the plan."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llmbt_atl.pddl import import_domain, import_problem
from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import ActionCall, Condition, Facts, Goals
from llmbt_ir.tree import Kind, Node, Tree
from llmbt_runtime.search import Plan, search
from llmbt_runtime.tick import NodeStatus, TickRecord, tick
from llmbt_runtime.update.chain import chain_tree, regress
from llmbt_runtime.update.links import linked_tree
from llmbt_runtime.update.rollout import Certificate, rollout
from tests.search.bench import BLOCKS, PLACES, blocks_problem, places_problem
from tests.strips import Strips, random_strips


def flat_chain(goals: tuple[Condition, ...], plan: tuple[GroundAction, ...]) -> Tree:
    """The rows one beside the other: Fallback(Sequence(G), Sequence(R_(n-1), a_n), ..., Sequence(R_0, a_1))."""
    rows = regress(goals, plan)
    nodes: list[Node] = []
    branches = []
    for i in range(len(plan), -1, -1):
        leaves = [Node(f"r{i}.{k}", Kind.CONDITION, condition=c) for k, c in enumerate(rows[i])]
        if i < len(plan):
            leaves.append(Node(f"r{i}.act", Kind.ACTION, action=plan[i].call))
        nodes += [Node(f"r{i}", Kind.SEQUENCE, tuple(n.id for n in leaves)), *leaves]
        branches.append(f"r{i}")
    return Tree("top", {n.id: n for n in (Node("top", Kind.FALLBACK, tuple(branches)), *nodes)})


def planned(seeds: Iterator[int] | range) -> Iterator[tuple[Strips, tuple[GroundAction, ...]]]:
    """Random problems of propositions with a plan that is not empty."""
    for seed in seeds:
        problem = random_strips(random.Random(seed))
        plan = search(problem.domain, problem.facts, problem.goals[0], budget=10_000)
        if isinstance(plan, Plan) and plan.actions:
            yield problem, plan.actions


def seen(tree: Tree, record: TickRecord) -> tuple[NodeStatus, list[tuple[ActionCall, NodeStatus]]]:
    """What a tick comes to: the status, and the actions that were ticked with what they returned, in order."""
    ticked = ((tree[i].action, status) for i, status in record.trace)
    return record.status, [(call, status) for call, status in ticked if call is not None]


@settings(max_examples=300)
@given(st.integers(0, 100_000), st.data())
def test_grouped_rows_mean_what_flat_rows_mean(seed: int, data: st.DataObject) -> None:
    """In any state, whatever the actions return: the same status, the same actions ticked in the same order."""
    for problem, plan in planned(range(seed, seed + 5)):
        flat, grouped = flat_chain(problem.goals[0], plan), chain_tree(problem.goals[0], plan)
        assert len(grouped) <= len(flat)
        flags = sorted({c.fact for row in regress(problem.goals[0], plan) for c in row})
        for _ in range(5):
            facts = frozenset(data.draw(st.lists(st.sampled_from(flags))))
            ending = frozenset(data.draw(st.lists(st.sampled_from(flags), max_size=2)))
            said = {a.call: data.draw(st.sampled_from(NodeStatus)) for a in dict.fromkeys(plan)}
            told = [
                {n.id: said[n.action] for n in tree.nodes.values() if n.action is not None} for tree in (flat, grouped)
            ]
            assert seen(flat, tick(flat, facts, told[0], ending=ending)) == seen(
                grouped, tick(grouped, facts, told[1], ending=ending)
            )
            assert seen(flat, tick(flat, facts)) == seen(grouped, tick(grouped, facts))


def towers(n: int, seed: int) -> tuple[Domain, Facts, Goals]:
    problem = import_problem(blocks_problem(n, seed), import_domain(BLOCKS, "blocks.pddl"))
    return problem.domain, problem.facts, problem.goals


def shelves(n: int, k: int, seed: int) -> tuple[Domain, Facts, Goals]:
    problem = import_problem(places_problem(n, k, seed), import_domain(PLACES, "places.pddl"))
    return problem.domain, problem.facts, problem.goals


PROBLEMS = {f"blocks {n} {s}": towers(n, s) for n in (5, 10, 20) for s in (1, 2, 3)} | {
    f"places {n} {s}": shelves(n, k, s) for n, k in ((6, 9), (12, 16)) for s in (1, 2)
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_plan_becomes_a_tree_that_runs_it(name: str) -> None:
    domain, facts, goals = PROBLEMS[name]
    plan = search(domain, facts, goals[0])
    assert isinstance(plan, Plan)
    linked = linked_tree(goals, 0, plan.actions, facts)
    assert linked is not None, "the links do not nest"
    chain = chain_tree(goals[0], plan.actions)
    for tree in (linked[0], chain):
        certificate = rollout(tree, domain, facts, goals)
        assert isinstance(certificate, Certificate)
        assert certificate.actions == plan.actions
    assert len(linked[0]) <= 7 * len(plan.actions) + 1 + len(goals[0])
    if len(plan.actions) > 15:
        assert 2 * len(chain) < 3 * len(flat_chain(goals[0], plan.actions)), "grouping saves a third at least"


def runs_the_plan(seeds: range) -> tuple[int, int]:
    """How many plans there are, and how many nest; those that nest are run as they are."""
    plans = nested = 0
    for problem, plan in planned(seeds):
        plans += 1
        made = linked_tree(problem.goals[:1], 0, plan, problem.facts)
        if made is None:
            continue
        nested += 1
        tree, steps = made
        certificate = rollout(tree, problem.domain, problem.facts, problem.goals)
        assert isinstance(certificate, Certificate)
        assert certificate.actions == plan
        assert [n.condition for n in tree.nodes.values() if n.id.startswith("g") and "." not in n.id] == list(
            dict.fromkeys(problem.goals[0])
        )
        assert {s.node for s in steps} <= set(tree.nodes) and len(steps) == len(plan)
    return plans, nested


def test_nearly_every_plan_nests_and_then_the_tree_runs_it() -> None:
    plans, nested = runs_the_plan(range(1_500))
    assert plans > 300 and nested > 0.98 * plans


@pytest.mark.slow
def test_nearly_every_plan_nests_and_then_the_tree_runs_it_many() -> None:
    plans, nested = runs_the_plan(range(1_000_000, 1_012_000))
    assert nested > 0.98 * plans


def test_what_only_has_to_come_before_hangs_by_a_literal_that_lasts() -> None:
    """b7 has to be put down before b6 comes onto it, for b2's sake: nothing that b6 needs says so."""
    domain, facts, goals = PROBLEMS["blocks 20 1"]
    plan = search(domain, facts, goals[0])
    assert isinstance(plan, Plan)
    made = linked_tree(goals, 0, plan.actions, facts)
    assert made is not None
    assert any("for the sake of what comes later" in s.reason for s in made[1])


def test_an_alternative_is_grown_in_its_own_branch() -> None:
    domain, facts, goals = PROBLEMS["places 6 1"]
    two: Goals = ((Condition("on", ("t0", "p0")), Condition("on", ("t1", "p0"))), goals[0])
    plan = search(domain, facts, two[1])
    assert isinstance(plan, Plan)
    made = linked_tree(two, 1, plan.actions, facts)
    assert made is not None
    tree, _ = made
    assert tree[tree.root].children == ("alt1", "alt2")
    assert tree["alt1"].children == ("g1", "g2")
    certificate = rollout(tree, domain, facts, two)
    assert isinstance(certificate, Certificate) and certificate.actions == plan.actions
