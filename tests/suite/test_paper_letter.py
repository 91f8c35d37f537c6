"""Algorithm 1 as printed, and how it fails: each of its defects as a test (see baselines/paper.py)."""

from __future__ import annotations

import numpy as np

from llmbt_atl.library import Library
from llmbt_atl.state import Domain
from llmbt_atl.template import Pattern, Template, Variable
from llmbt_ir.condition import Condition, Facts, Goals
from llmbt_ir.tree import Kind, Tree, goal_tree
from llmbt_runtime.baselines import Limits, Run, run
from llmbt_runtime.baselines.paper import PaperPolicy, Reading, conflict, expand, failed_node, insert
from llmbt_runtime.episodes.model import flag
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.tick import NodeStatus, tick
from tests.oracle import Cargo
from tests.strategies import CANONICAL, SHELF, canonical_cargo, domain_for, draw_tree

C = Condition
LETTER, KIND = Reading.LETTER, Reading.KIND


def library(*templates: tuple[str, str, str, str], variables: tuple[tuple[str, ...], ...] = ()) -> Library:
    """Templates as (name, pre, post, delete), propositions by spaces."""

    def patterns(text: str) -> tuple[Pattern, ...]:
        return tuple(Pattern(f, ()) for f in text.split())

    names = {f for _, pre, post, gone in templates for f in f"{pre} {post} {gone}".split()}
    return Library(
        "small",
        {},
        {n: flag(n) for n in sorted(names)},
        tuple(Variable(f"v{i}", (), patterns(" ".join(v))) for i, v in enumerate(variables)),
        {n: Template(n, (), (), patterns(pre), patterns(post), patterns(gone)) for n, pre, post, gone in templates},
    )


def facts(text: str) -> Facts:
    return frozenset(C(f) for f in text.split())


def goals(text: str) -> Goals:
    return (tuple(C(f) for f in text.split()),)


def play(method: str, lib: Library, start: str, wanted: str) -> Run:
    domain = Domain(lib, {}).for_state(facts(start))
    world = SymbolicWorld(domain, facts(start), np.random.default_rng(1), ticks=(1, 1))
    return run(method, world, domain, goals(wanted), Limits(ticks=200, updates=40))


def revised(tree: Tree, domain: Domain, state: Facts, reading: Reading = LETTER, times: int = 1) -> Tree:
    policy = PaperPolicy(reading)
    for _ in range(times):
        record = tick(tree, state)
        assert record.status is NodeStatus.FAILURE
        found = policy.revise(tree, domain, state, record)
        assert isinstance(found, Tree)
        tree = found
    return tree


def test_where_nothing_can_go_wrong_it_works() -> None:
    lib = library(("first", "", "a", ""), ("second", "a", "b", ""), ("third", "other", "c", ""))
    assert play("paper", lib, "", "b").completed == play("loop", lib, "", "b").completed
    assert [str(a) for a in play("paper", lib, "", "b").completed] == ["first", "second"]


def test_gamma_is_overwritten() -> None:
    """Line 12: of two ways to a goal the last is kept, though only the first can be done."""
    lib = library(("easy", "", "goal", ""), ("hard", "odd", "goal", ""), ("odd_one", "odder", "odd", ""))
    domain = Domain(lib, {})
    tree = goal_tree(goals("goal"))
    assert "easy" not in draw_tree(revised(tree, domain, frozenset()))
    assert "easy" in draw_tree(revised(tree, domain, frozenset(), KIND))
    assert play("paper", lib, "", "goal").outcome is Outcome.BUDGET
    assert play("paper-kind", lib, "", "goal").outcome is Outcome.SUCCESS


def test_pre_is_that_of_the_last_template_matching_or_not() -> None:
    """Line 15: after the loop, `a` is whatever the library ends with."""
    lib = library(("get", "", "tool", ""), ("make", "tool", "goal", ""), ("unrelated", "weather", "mood", ""))
    domain = Domain(lib, {})
    tree = goal_tree(goals("goal"))
    found = expand(tree, "g1", domain, frozenset(), 1)
    assert found.types == {"weather"} and found.pre == (C("tool"),)


def test_where_nothing_matches_it_never_ends() -> None:
    """Line 14 makes Fallback(c_f), which fails like c_f; line 1 has no bound but ours."""
    lib = library(("other", "", "x", ""), ("use", "goal", "y", ""))
    tree = revised(goal_tree(goals("goal")), Domain(lib, {}), frozenset(), times=3)
    assert [n.kind for n in tree.preorder()] == [Kind.SEQUENCE, *[Kind.FALLBACK] * 3, Kind.CONDITION]
    found = play("paper", lib, "", "goal")
    assert found.outcome is Outcome.BUDGET and found.updates == 40 and not found.actions


def test_a_type_is_a_name_so_two_goals_about_places_conflict() -> None:
    """Line 18: On(object_1, ...) and the last template's preconditions have names in common, HandEmpty and Holding have
    none, although these exclude each other and those do not."""
    cargo = Cargo(SHELF, (("object_2", "position_12"),), "object_1")
    domain, state = domain_for(cargo), cargo.facts()
    tree = goal_tree(((CANONICAL[0],),))
    tree = insert(tree, "g1", expand(tree, "g1", domain, state, 1), None)
    record = tick(tree, state)
    failed = failed_node(tree, record)
    assert failed is not None and str(tree[failed].condition) == "Free(position_12)"
    found = expand(tree, failed, domain, state, 2)
    assert C("HandEmpty") in found.pre
    assert found.types == {p.name for p in list(domain.library.templates.values())[-1].pre}
    assert "HandEmpty" in found.types and "Holding" not in found.types
    assert conflict(tree, failed, found, domain, record, LETTER) is None, "Holding(object_1) conflicts, and is not seen"
    kind = expand(tree, failed, domain, state, 2, KIND)
    before = conflict(tree, failed, kind, domain, record, KIND)
    assert before is not None and str(tree[before].condition) == "Holding(object_1)"


def test_add_leaves_the_failed_condition_where_it_was() -> None:
    """Line 22, in the paper's own example: T_exp comes before Holding(object_1), Free(position_12) stays behind it."""
    cargo = Cargo(SHELF, (("object_2", "position_12"),), "object_1")
    tree = revised(goal_tree(((CANONICAL[0],),)), domain_for(cargo), cargo.facts(), KIND, times=2)
    labels = [n.label() for n in tree.preorder()]
    assert labels.count("Free(position_12)") == 2
    assert labels.index("Free(position_12)") < labels.index("Holding(object_1)")


def test_add_puts_a_subtree_into_a_fallback() -> None:
    """Line 22: the first condition of the conflicting type can be a Fallback's head; T_exp is ticked before it."""
    lib = library(("make", "tool", "goal", ""), ("get", "money", "tool", ""), ("z", "goal", "y", ""))
    tree = revised(goal_tree(goals("goal")), Domain(lib, {}), frozenset(), times=2)
    top = tree[tree[tree.root].children[0]]
    assert top.kind is Kind.FALLBACK and tree[top.children[0]].kind is Kind.FALLBACK
    assert tree[top.children[1]].condition == C("goal")


def test_with_two_goals_of_a_type_the_second_hides_in_the_first() -> None:
    """Add nests the second goal's subtree in the first goal's; once the first holds it is not ticked any more."""
    cargo = canonical_cargo()
    domain = domain_for(cargo)
    wanted = (CANONICAL[:2],)
    world = SymbolicWorld(domain, cargo.facts(), np.random.default_rng(1), ticks=(1, 1))
    assert run("paper", world, domain, wanted, Limits(ticks=200, updates=60)).outcome is Outcome.BUDGET
    world = SymbolicWorld(domain, cargo.facts(), np.random.default_rng(1), ticks=(1, 1))
    assert run("loop", world, domain, wanted).outcome is Outcome.SUCCESS


def test_it_acts_before_it_knows_a_way_to_the_end() -> None:
    """The coin buys either; a grows for free only where there is water. The loop knows before it spends."""
    lib = library(
        ("grow_b", "field", "b", ""),
        ("buy_b", "coin", "b", "coin"),
        ("buy_a", "coin", "a", "coin"),
        ("z", "q", "r", ""),
    )
    wanted = "b a"
    for method in ("paper", "pa-bt", "local"):
        found = play(method, lib, "coin", wanted)
        assert found.outcome is Outcome.BUDGET
    assert play("loop", lib, "coin", wanted).outcome is Outcome.UNSOLVABLE
    assert not play("loop", lib, "coin", wanted).actions
    assert play("paper", lib, "coin field", wanted).outcome is Outcome.BUDGET
    assert play("loop", lib, "coin field", wanted).outcome is Outcome.SUCCESS
