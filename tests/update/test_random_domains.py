"""The update over random propositional domains: dead ends, negation, things that can be spent wrongly, alternatives."""

from __future__ import annotations

import random

import numpy as np
import pytest

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.tree import Kind, Node, Tree, goal_tree
from llmbt_runtime.executor import Change, Settings, execute
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.search import Unsolvable
from llmbt_runtime.symbolic import Event, SymbolicWorld
from llmbt_runtime.update.chain import chain_tree, regress
from llmbt_runtime.update.loop import Grown, Kept, update
from llmbt_runtime.update.rollout import Certificate, rollout
from tests.oracle import naive_tick
from tests.strips import Op, Strips, random_strips

C = Condition


def simulate(problem: Strips, tree: Tree) -> list[ActionCall]:
    """What a tree does from the problem's state; AssertionError where it does not reach the goals."""
    facts, done, seen = problem.facts, list[ActionCall](), {problem.facts}
    while True:
        status, running, _ = naive_tick(tree, facts)
        if status == "SUCCESS":
            assert problem.reached(facts)
            return done
        assert status == "RUNNING" and len(running) == 1
        call = tree[running[0]].action
        assert call is not None and problem.op(call).able(facts)
        facts = problem.op(call).after(facts)
        done.append(call)
        assert facts not in seen, "a state twice"
        seen.add(facts)


def problem_of(seed: int) -> Strips:
    rng = random.Random(seed)
    return random_strips(rng, alternatives=rng.choice([1, 1, 2]))


def check(seed: int) -> str:
    problem = problem_of(seed)
    found = update(goal_tree(problem.goals), problem.domain, problem.facts, problem.goals)
    fewest = problem.shortest()
    assert isinstance(found, Unsolvable) == (fewest is None), f"seed {seed}"
    if isinstance(found, (Kept, Grown)):
        tree = found.tree if isinstance(found, Grown) else goal_tree(problem.goals)
        assert simulate(problem, tree) == [a.call for a in found.certificate.actions], f"seed {seed}"
        again = update(tree, problem.domain, problem.facts, problem.goals)
        assert again == Kept(found.certificate), f"seed {seed}"
    return type(found).__name__


def test_solved_exactly_where_breadth_first_search_finds_a_way() -> None:
    outcomes = [check(seed) for seed in range(1_200)]
    assert {o: outcomes.count(o) > 100 for o in ("Kept", "Grown", "Unsolvable")} == dict.fromkeys(
        ("Kept", "Grown", "Unsolvable"), True
    )


@pytest.mark.slow
@pytest.mark.parametrize("block", range(4))
def test_solved_exactly_where_breadth_first_search_finds_a_way_many(block: int) -> None:
    for seed in range(100_000 + block * 5_000, 100_000 + block * 5_000 + 5_000):
        check(seed)


def test_a_plan_whose_step_only_ends_something_can_be_certified() -> None:
    """The goal is that P0 does not hold; the action that ends it does not need it to hold."""
    ops = (Op("end", (), (), frozenset(), frozenset({C("P0")})),)
    problem = Strips(ops, frozenset({C("P0")}), ((~C("P0"),),))
    found = update(goal_tree(problem.goals), problem.domain, problem.facts, problem.goals)
    assert isinstance(found, Grown)
    assert [str(a) for a in found.certificate.actions] == ["end"]


def test_a_coin_is_not_spent_wrongly() -> None:
    """The coin buys x or y; x can also be found. Both are wanted, x first: whoever acts before it knows buys x."""
    ops = (
        Op("buy_x", (), (C("coin"),), frozenset({C("x")}), frozenset({C("coin")})),
        Op("buy_y", (), (C("coin"),), frozenset({C("y")}), frozenset({C("coin")})),
        Op("find_x", (), (C("map"),), frozenset({C("x")}), frozenset()),
        Op("find_map", (), (), frozenset({C("map")}), frozenset()),
    )
    problem = Strips(ops, frozenset({C("coin")}), ((C("x"), C("y")),))
    found = update(goal_tree(problem.goals), problem.domain, problem.facts, problem.goals)
    assert isinstance(found, Grown)
    assert "buy_x" not in {str(a) for a in found.certificate.actions}
    assert found.planner_calls == 1
    simulate(problem, found.tree)


def test_regression_is_what_a_chain_is_made_of() -> None:
    """R_n = G, R_(i-1) = (R_i - add(a_i)) + pre(a_i); and every chain of a plan certifies from its state."""
    checked = 0
    for seed in range(600):
        problem = random_strips(random.Random(seed))
        from llmbt_runtime.search import Plan, search

        plan = search(problem.domain, problem.facts, problem.goals[0], budget=10_000)
        if not isinstance(plan, Plan) or not plan.actions:
            continue
        rows = regress(problem.goals[0], plan.actions)
        assert set(rows[-1]) == set(problem.goals[0])
        for i, action in enumerate(plan.actions):
            assert set(rows[i]) == {c for c in rows[i + 1] if not action.achieves(c)} | set(action.pre)
        tree = chain_tree(problem.goals[0], plan.actions)
        certificate = rollout(tree, problem.domain, problem.facts, problem.goals)
        assert isinstance(certificate, Certificate), f"seed {seed}"
        assert len(certificate.actions) <= len(plan.actions)
        simulate(problem, tree)
        checked += 1
    assert checked > 100


# -- executed, with failures and events ------------------------------------------------------------------------------


def run(seed: int) -> str:
    """An execution with events; what the design note claims of it."""
    problem, rng = problem_of(seed), random.Random(-seed)
    flags = sorted({c.fact for g in problem.goals for c in g} | problem.facts)
    events = tuple(
        Event(rng.randint(1, 30), frozenset(rng.sample(flags, 1)), frozenset(rng.sample(flags, 1)))
        for _ in range(rng.choice([0, 1, 3, 10]))
    )
    world = SymbolicWorld(
        problem.domain,
        problem.facts,
        np.random.default_rng(seed),
        ticks=(1, rng.choice([1, 4])),
        failure_rate=rng.choice([0.0, 0.0, 0.15]),
        events=events,
    )
    kept: list[Change] = []

    def keep(change: Change) -> str:
        kept.append(change)
        return f"v{len(kept):03d}"

    result = execute(
        world, problem.domain, goal_tree(problem.goals), problem.goals, keep=keep, settings=Settings(max_ticks=3_000)
    )
    fired, failed = len(world.disturbances()), sum(e.result == "FAILURE" for e in result.actions)
    for change in kept:
        again = rollout(change.grown.tree, problem.domain, change.facts, problem.goals)
        assert isinstance(again, Certificate), f"seed {seed}"
    assert result.outcome in (Outcome.SUCCESS, Outcome.UNSOLVABLE, Outcome.ACTION_FAILED), f"seed {seed}"
    assert result.planner_calls <= len(problem.goals) * (1 + fired + failed), f"seed {seed}"
    if result.outcome is Outcome.SUCCESS:
        assert problem.reached(world.truth())
    if result.outcome is Outcome.UNSOLVABLE:
        assert problem.shortest(world.truth()) is None, f"seed {seed}"
    if not events and result.outcome is not Outcome.ACTION_FAILED:
        assert (result.outcome is Outcome.SUCCESS) == (problem.shortest() is not None), f"seed {seed}"
    if not events and not failed:
        assert all(e.result == "SUCCESS" for e in result.actions)
        assert len(result.actions) == (len(kept[0].grown.certificate.actions) if kept else 0)
    return result.outcome.value


def test_executions_end_and_end_rightly() -> None:
    outcomes = [run(seed) for seed in range(500)]
    assert outcomes.count("SUCCESS") > 100 and outcomes.count("UNSOLVABLE") > 100


@pytest.mark.slow
@pytest.mark.parametrize("block", range(4))
def test_very_many_executions_end_and_end_rightly(block: int) -> None:
    for seed in range(200_000 + block * 2_000, 200_000 + block * 2_000 + 2_000):
        run(seed)


def test_the_same_seed_ends_the_same_way() -> None:
    assert [run(s) for s in range(40)] == [run(s) for s in range(40)]


# -- trees that somebody else made -----------------------------------------------------------------------------------


def foreign_tree(problem: Strips, rng: random.Random, depth: int = 3) -> Tree:
    """Conditions and actions in any shape: `execute` takes any file."""
    nodes: dict[str, Node] = {}
    flags = sorted({c.fact for g in problem.goals for c in g} | problem.facts)

    def grow(id_: str, level: int) -> str:
        if level == 0 or (level < depth and rng.random() < 0.3):
            if rng.random() < 0.4:
                nodes[id_] = Node(id_, Kind.ACTION, action=ActionCall(rng.choice(problem.ops).name))
            else:
                nodes[id_] = Node(id_, Kind.CONDITION, condition=rng.choice(flags))
            return id_
        below = tuple(grow(f"{id_}.{i}", level - 1) for i in range(1, rng.randint(1, 3) + 1))
        nodes[id_] = Node(id_, rng.choice([Kind.SEQUENCE, Kind.FALLBACK]), below)
        return id_

    return Tree(grow("n", depth), nodes)


def test_any_tree_can_be_updated() -> None:
    for seed in range(800):
        rng = random.Random(seed)
        problem = random_strips(rng)
        tree = foreign_tree(problem, rng)
        banned = frozenset({rng.choice(problem.ops).name} if rng.random() < 0.5 else ())
        excluded = frozenset(ActionCall(b) for b in banned)
        found = update(tree, problem.domain, problem.facts, problem.goals, excluded=excluded)
        assert isinstance(found, Unsolvable) == (problem.shortest(without=banned) is None), f"seed {seed}"
        if isinstance(found, Grown):
            assert banned.isdisjoint(str(a) for a in found.certificate.actions)
            simulate(problem, found.tree)


def test_any_tree_can_be_executed_and_nothing_spins() -> None:
    for seed in range(600):
        rng = random.Random(seed)
        problem = random_strips(rng)
        tree = foreign_tree(problem, rng)
        world = SymbolicWorld(problem.domain, problem.facts, np.random.default_rng(seed), failure_rate=0.3)
        settings = Settings(max_ticks=2_000)
        result = execute(world, problem.domain, tree, problem.goals, keep=lambda _: "v", settings=settings)
        assert result.outcome in (Outcome.SUCCESS, Outcome.UNSOLVABLE, Outcome.ACTION_FAILED), f"seed {seed}"
        if problem.reached(problem.facts) and not result.actions:
            assert result.outcome is Outcome.SUCCESS
