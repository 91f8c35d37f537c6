"""The paper's figures, and the worked example of the design note, as trees that a person can look at in golden/."""

from __future__ import annotations

from collections.abc import Callable

from llmbt_ir.condition import Condition, Goals
from llmbt_ir.tree import Tree, goal_tree
from llmbt_runtime.search import h_add
from llmbt_runtime.tick import tick
from llmbt_runtime.update.edit import expand, protected
from llmbt_runtime.update.local import repair
from llmbt_runtime.update.loop import Grown, Kept, update
from llmbt_runtime.update.rollout import Certificate, Stuck, rollout
from tests.oracle import Cargo, carry_out
from tests.strategies import CANONICAL, SHELF, canonical_cargo, domain_for, draw_tree
from tests.suite.scenes import scenes

C = Condition
Golden = Callable[[str, str], None]
ONE: Goals = ((C("On", ("object_1", "position_12")),),)


def grown(cargo: Cargo, goals: Goals, tree: Tree | None = None) -> Grown:
    found = update(tree or goal_tree(goals), domain_for(cargo), cargo.facts(), goals)
    assert isinstance(found, Grown)
    assert carry_out(found.tree, cargo, goals[0])[0] == [a.call for a in found.certificate.actions]
    return found


def story(found: Grown) -> str:
    """The tree, the edits that made it, and what it will do."""
    lines = [draw_tree(found.tree)]
    lines += [
        f"{s.kind} {s.condition} <- {s.action}" + (f" (before {s.before})" if s.before else "") for s in found.steps
    ]
    lines += ["", *(f"{i}. {a}" for i, a in enumerate(found.certificate.actions, 1))]
    return "\n".join(lines) + "\n"


def test_the_initial_tree_is_a_sequence_of_the_goals(golden: Golden) -> None:
    golden("initial_tree.txt", draw_tree(goal_tree((CANONICAL,))))


def test_expand_puts_an_achiever_beside_the_condition(golden: Golden) -> None:
    """Paper, Expand: Fallback(c, Sequence(Pre(a), a))."""
    cargo = canonical_cargo()
    domain = domain_for(cargo)
    (place,) = (a for a in domain.achievers(ONE[0][0]) if a.call.name == "place")
    tree = expand(goal_tree(ONE), "g1", place)
    golden("expand.txt", draw_tree(tree))
    record = tick(tree, cargo.facts())
    assert str(tree[next(i for i in record.failed_leaves() if tree[i].condition)].condition) == "Holding(object_1)"


def test_expanding_once_more_adds_a_further_achiever_after_those_there() -> None:
    domain = domain_for(canonical_cargo())
    one, two = domain.achievers(C("HandEmpty"))[:2]
    tree = expand(goal_tree(((C("HandEmpty"),),)), "g1", one)
    more = expand(tree, "g1", two)
    root = more[more.root].children[0]
    assert [more.head(c) for c in more[root].children[:1]] == [C("HandEmpty")]
    assert more[root].children[:2] == tree[root].children
    assert len(more[root].children) == 3


def test_the_canonical_tree(golden: Golden) -> None:
    found = grown(canonical_cargo(), (CANONICAL,))
    assert [a.call.name for a in found.certificate.actions] == ["pick", "place"] * 6
    assert found.planner_calls == 0
    golden("canonical.txt", story(found))


def test_the_conflict_is_found_and_insert_resolves_it(golden: Golden) -> None:
    """Paper, Insert: object_1 is held and its place is taken. Freeing the place needs the hand, which the condition
    on its left holds: so the freeing is moved before it, as a subtree, not copied."""
    cargo = Cargo(SHELF, (("object_2", "position_12"),), "object_1")
    domain, facts = domain_for(cargo), cargo.facts()
    (place,) = (a for a in domain.achievers(ONE[0][0]) if a.call.name == "place")
    tree = expand(goal_tree(ONE), "g1", place)
    stuck = rollout(tree, domain, facts, ONE)
    assert isinstance(stuck, Stuck)
    failed = next(i for i in stuck.record.failed_leaves() if tree[i].condition and i != "g1")
    assert str(tree[failed].condition) == "Free(position_12)"
    assert [str(f) for _, _, f in protected(tree, failed)] == ["Holding(object_1)"]
    aside = next(a for a in domain.achievers(C("Free", ("position_12",))) if a.call.name == "move_aside")
    assert any(domain.mutex(c, C("Holding", ("object_1",))) for c in aside.pre)

    mended = repair(tree, stuck, domain, h_add(domain, facts))
    assert mended is not None and mended.step.kind == "move"
    assert set(mended.tree.nodes) == set(tree.nodes)
    golden("insert.txt", draw_tree(tree) + "\n" + draw_tree(mended.tree))


def test_the_worked_example(golden: Golden) -> None:
    """A is held, B stands on P, T1 and T2 are free; goal On(A, P): one move, and every node is kept by it."""
    cargo = Cargo(SHELF, (("object_2", "position_12"),), "object_1")
    found = grown(cargo, ONE)
    assert [s.kind for s in found.steps].count("move") == 1
    assert [str(a) for a in found.certificate.actions] == [
        "put_down(object_1, sorting_area)",
        "move_aside(object_2, position_12, sorting_area)",
        "pick(object_1, sorting_area)",
        "place(object_1, position_12)",
    ]
    golden("worked_example.txt", story(found))


def test_a_drop(golden: Golden) -> None:
    """The object fell out of the gripper: the tree is kept where the object lies where it was taken from, and gets a
    further way to hold it where it lies elsewhere."""
    before = canonical_cargo()
    tree = grown(before, (CANONICAL,)).tree
    kept = update(tree, domain_for(before), before.facts(), (CANONICAL,))
    assert isinstance(kept, Kept)
    fell = canonical_cargo(object_1="workbench")
    found = grown(fell, (CANONICAL,), tree)
    assert [(s.kind, s.action) for s in found.steps] == [("re-expand", "pick(object_1, workbench)")]
    assert set(tree.nodes) < set(found.tree.nodes)
    golden("drop.txt", story(found))


def test_an_obstacle_at_the_pick(golden: Golden) -> None:
    before = canonical_cargo()
    tree = grown(before, (CANONICAL,)).tree
    blocked = Cargo(SHELF, (*before.at, ("obstacle_1", "sorting_area")), None, frozenset({("obstacle_1", "object_3")}))
    found = grown(blocked, (CANONICAL,), tree)
    assert [s.kind for s in found.steps] == ["expand"]
    assert [a.call.name for a in found.certificate.actions].count("clear_away") == 1
    golden("obstacle_at_pick.txt", story(found))


def test_an_obstacle_at_the_place(golden: Golden) -> None:
    """It appears while object_1 is on its way there."""
    before = canonical_cargo()
    tree = grown(before, (CANONICAL,)).tree
    at = (*(e for e in before.at if e[0] != "object_1"), ("obstacle_1", "position_12"))
    found = grown(Cargo(SHELF, at, "object_1"), (CANONICAL,), tree)
    assert [s.kind for s in found.steps][:1] == ["move"]
    assert [str(a) for a in found.certificate.actions][:2] == [
        "put_down(object_1, sorting_area)",
        "move_aside(obstacle_1, position_12, sorting_area)",
    ]
    golden("obstacle_at_place.txt", story(found))


def test_a_placed_object_was_moved(golden: Golden) -> None:
    """What was done already is done again, without a change where it lies where it lay at first."""
    before = canonical_cargo()
    tree = grown(before, (CANONICAL,)).tree
    done = canonical_cargo(object_1="position_12", object_2="sorting_area", object_4="position_14")
    found = update(tree, domain_for(done), done.facts(), (CANONICAL,))
    assert isinstance(found, Kept)
    golden("placed_object_moved.txt", "\n".join(str(a) for a in found.certificate.actions) + "\n")


def test_a_swap(golden: Golden) -> None:
    cargo = Cargo(SHELF, (("object_1", "position_12"), ("object_3", "position_22")))
    goals = ((C("On", ("object_1", "position_22")), C("On", ("object_3", "position_12"))),)
    found = grown(cargo, goals)
    assert len(found.certificate.actions) == 5
    golden("swap.txt", story(found))


def test_the_certificate_tells_every_predicted_state() -> None:
    cargo = canonical_cargo()
    found = grown(cargo, (CANONICAL,))
    again = rollout(found.tree, domain_for(cargo), cargo.facts(), (CANONICAL,))
    assert isinstance(again, Certificate) and again == found.certificate
    assert again.states[0] == cargo.facts() and len(again.states) == len(again.actions) + 1
    assert len(set(again.states)) == len(again.states)


def test_an_obstacle_turns_up_before_the_milk(golden: Golden) -> None:
    """The household of section V.B, as shipped: the tree for the milk is kept, what is before the milk goes first."""
    scene = next(s for s in scenes() if s.name == "household: an obstacle turns up before the milk")
    assert scene.installed is not None
    found = update(scene.installed, scene.domain, scene.facts, scene.goals)
    assert isinstance(found, Grown) and found.planner_calls == 0
    assert set(scene.installed.nodes) < set(found.tree.nodes)
    assert [str(a) for a in found.certificate.actions] == [
        "navigate(bar)",
        "clear_away(obstacle_1, milk, bar)",
        "pick(milk, bar)",
        "navigate(user)",
        "place(milk, user)",
    ]
    golden("household_milk.txt", story(found))
