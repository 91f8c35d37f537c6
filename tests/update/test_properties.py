"""Laws of the update over random cargo states and goals, held against a model of things on places."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from llmbt_ir.condition import ActionCall, Condition, Goals
from llmbt_ir.tree import Kind, Tree, goal_tree
from llmbt_ir.tree_xml import parse_tree, write_tree
from llmbt_runtime.record import signatures_of
from llmbt_runtime.search import OutOfBudget, Unsolvable
from llmbt_runtime.update.imagine import imagine
from llmbt_runtime.update.links import linked_tree
from llmbt_runtime.update.loop import Grown, Kept, update
from llmbt_runtime.update.rollout import Certificate, rollout
from tests.oracle import Cargo, carry_out, shortest
from tests.strategies import cargo_goals, cargo_library, cargos, domain_for, layout, tasks

C = Condition
SMALL = {"max_objects": 3, "max_levels": 2, "max_positions": 2, "max_obstacles": 1}


def ids(tree: Tree) -> set[str]:
    return {n.id for n in tree.preorder()}


def updated(cargo: Cargo, goals: Goals, tree: Tree | None = None, **options: object) -> Kept | Grown | Unsolvable:
    found = update(tree or goal_tree(goals), domain_for(cargo), cargo.facts(), goals, **options)  # type: ignore[arg-type]
    assert not isinstance(found, OutOfBudget)
    return found


def well_formed(tree: Tree) -> None:
    """Reactive nodes only, every node reached once, and the tree survives being written and read."""
    order = [n.id for n in tree.preorder()]
    assert len(order) == len(set(order)) and set(order) == set(tree.nodes)
    for node in tree.nodes.values():
        assert node.kind in Kind
        assert bool(node.children) == (node.kind in (Kind.SEQUENCE, Kind.FALLBACK))
    signatures = signatures_of(cargo_library())
    assert parse_tree(write_tree(tree, signatures), "t.xml", signatures).tree == tree


@given(tasks(**SMALL))
def test_unsolvable_is_said_of_what_breadth_first_search_cannot_reach_and_only_of_that(
    task: tuple[Cargo, tuple[Condition, ...]],
) -> None:
    cargo, goal = task
    found, fewest = updated(cargo, (goal,)), shortest(cargo, goal)
    assert isinstance(found, Unsolvable) == (fewest is None)
    if isinstance(found, Unsolvable):
        assert found.reason and set(found.goals) <= set(goal) and found.goals
        assert shortest(cargo, found.goals) is None
    elif isinstance(found, Kept):
        assert len(found.certificate.actions) == fewest == 0


@given(tasks())
def test_a_certificate_is_what_happens(task: tuple[Cargo, tuple[Condition, ...]]) -> None:
    """The tree, ticked by the naive engine in the model of things, runs those actions and reaches the goals."""
    cargo, goal = task
    found = updated(cargo, (goal,))
    if isinstance(found, Unsolvable):
        return
    tree = found.tree if isinstance(found, Grown) else goal_tree((goal,))
    well_formed(tree)
    done, end = carry_out(tree, cargo, goal)
    assert done == [a.call for a in found.certificate.actions]
    assert found.certificate.states[-1] == end.facts()
    assert [str(tree[n].action) for n in found.certificate.nodes] == [str(c) for c in done]


@given(tasks())
def test_a_grown_tree_restarted_from_its_state_reaches_the_goals_unchanged(
    task: tuple[Cargo, tuple[Condition, ...]],
) -> None:
    cargo, goal = task
    found = updated(cargo, (goal,))
    if isinstance(found, Grown):
        again = updated(cargo, (goal,), found.tree)
        assert again == Kept(found.certificate)


@given(st.data())
def test_a_tree_that_meets_another_state_loses_no_node_but_by_a_step_that_says_so(data: st.DataObject) -> None:
    """The tree of one state is updated in a second and a third; the steps recorded are the difference."""
    start = data.draw(cargos(max_objects=3))
    goals = (data.draw(cargo_goals(start, max_goals=3)),)
    tree, here = goal_tree(goals), start
    for _ in range(3):
        found = updated(here, goals, tree)
        if isinstance(found, Unsolvable):
            return
        if isinstance(found, Grown):
            explained(tree, found, goals)
            well_formed(found.tree)
            carry_out(found.tree, here, goals[0])
            tree = found.tree
        here = data.draw(elsewhere(here))


@st.composite
def elsewhere(draw: st.DrawFn, cargo: Cargo) -> Cargo:
    """The same things, otherwise."""
    steps = list(cargo.steps())
    for _ in range(draw(st.integers(1, 3))):
        if steps:
            cargo = draw(st.sampled_from([then for _, then in steps]))
            steps = list(cargo.steps())
    return cargo


def explained(before: Tree, found: Grown, goals: Goals) -> None:
    """Each kind of step accounts for the nodes that came and went."""
    kinds = {s.kind for s in found.steps}
    assert found.steps
    if kinds & {"chain", "goals"}:
        assert found.planner_calls or len(goals) > 1
        return
    assert kinds <= {"expand", "re-expand", "move", "remove"}
    if "remove" not in kinds:
        assert ids(before) <= ids(found.tree), "a node was lost"
    if kinds <= {"move", "remove"}:
        assert ids(found.tree) <= ids(before)
    new = [n for n in found.tree.nodes.values() if n.id not in before.nodes and n.action is not None]
    if "remove" not in kinds:
        added = [s.action for s in found.steps if s.kind in ("expand", "re-expand")]
        assert sorted(str(n.action) for n in new) == sorted(added)
    for step in found.steps:
        assert step.reason and (step.before != "") == (step.kind == "move")
        assert (str(step.action) not in step.alternatives) or step.kind == "move"


@given(tasks(**SMALL), st.data())
def test_an_excluded_action_is_never_in_a_certificate(
    task: tuple[Cargo, tuple[Condition, ...]], data: st.DataObject
) -> None:
    cargo, goal = task
    first = updated(cargo, (goal,))
    assume(isinstance(first, Grown))
    assert isinstance(first, Grown)
    banned = frozenset({data.draw(st.sampled_from(first.certificate.actions)).call})
    second = updated(cargo, (goal,), first.tree, excluded=banned)
    if isinstance(second, (Kept, Grown)):
        assert banned.isdisjoint(a.call for a in second.certificate.actions)
        carry_out(second.tree if isinstance(second, Grown) else first.tree, cargo, goal)


@given(st.data())
def test_negated_goals(data: st.DataObject) -> None:
    cargo = data.draw(cargos(**SMALL))
    goal = data.draw(cargo_goals(cargo, negated=True))
    found, fewest = updated(cargo, (goal,)), shortest(cargo, goal)
    assert isinstance(found, Unsolvable) == (fewest is None)
    if isinstance(found, Grown):
        carry_out(found.tree, cargo, goal)


@given(st.data())
def test_alternatives_are_reached_when_one_of_them_can_be(data: st.DataObject) -> None:
    cargo = data.draw(cargos(**SMALL))
    goals = tuple(data.draw(st.lists(cargo_goals(cargo, max_goals=2), min_size=2, max_size=3, unique=True)))
    found = updated(cargo, goals)
    fewest = [shortest(cargo, g) for g in goals]
    assert isinstance(found, Unsolvable) == all(f is None for f in fewest)
    if not isinstance(found, Unsolvable):
        tree = found.tree if isinstance(found, Grown) else goal_tree(goals)
        well_formed(tree)
        assert isinstance(rollout(tree, domain_for(cargo), cargo.facts(), goals), Certificate)


@settings(max_examples=20)
@given(tasks(max_objects=3))
def test_the_same_question_has_the_same_answer(task: tuple[Cargo, tuple[Condition, ...]]) -> None:
    cargo, goal = task
    assert updated(cargo, (goal,)) == updated(cargo, (goal,))


@given(tasks())
def test_ids_are_those_of_the_growth_not_of_the_run(task: tuple[Cargo, tuple[Condition, ...]]) -> None:
    """A goal keeps its id in every version: provenance names goals by it."""
    cargo, goal = task
    found = updated(cargo, (goal,))
    if isinstance(found, Grown) and all(s.kind != "chain" for s in found.steps):
        for i, c in enumerate(goal, 1):
            assert found.tree[f"g{i}"].condition == c


def test_the_goals_keep_their_ids_when_a_plan_reorders_them() -> None:
    """A plan that reaches g2 before g1 orders the tree so; g1 stays g1."""
    cargo = Cargo(layout(1, 3), (("object_1", "sorting_area"), ("object_2", "sorting_area")))
    goal = (C("On", ("object_1", "position_11")), C("On", ("object_2", "position_12")))
    domain, state, plan = domain_for(cargo), cargo, []
    for name, args in (
        ("pick", ("object_2", "sorting_area")),
        ("place", ("object_2", "position_12")),
        ("pick", ("object_1", "sorting_area")),
        ("place", ("object_1", "position_11")),
    ):
        action = domain.action(ActionCall(name, args))
        assert action is not None
        plan.append(action)
        then = state.after(action.call)
        assert then is not None
        state = then
    made = linked_tree((goal,), 0, tuple(plan), cargo.facts())
    assert made is not None
    tree, _ = made
    assert [str(tree.head(c)) for c in tree[tree.root].children] == [str(goal[1]), str(goal[0])]
    for i, c in enumerate(goal, 1):
        assert tree[f"g{i}"].condition == c


@settings(max_examples=20)
@given(tasks(max_objects=4, max_levels=2, max_positions=3))
def test_imagining_ends(task: tuple[Cargo, tuple[Condition, ...]]) -> None:
    cargo, goal = task
    found = imagine(goal_tree((goal,)), domain_for(cargo), cargo.facts(), (goal,))
    assert found is None or found.certificate.states[0] == cargo.facts()


@pytest.mark.parametrize(
    "goal",
    [
        (C("On", ("object_1", "position_11")), C("On", ("object_2", "position_11"))),
        (C("On", ("object_1", "position_11")), C("On", ("object_1", "position_12"))),
        (C("Holding", ("object_1",)), C("HandEmpty")),
        (C("Holding", ("object_1",)), C("Holding", ("object_2",))),
        (C("HandEmpty"), ~C("HandEmpty")),
        (C("Free", ("position_11",)), C("On", ("object_1", "position_11"))),
    ],
)
def test_what_cannot_hold_together_is_named(goal: tuple[Condition, ...]) -> None:
    cargo = Cargo(layout(1, 3), (("object_1", "sorting_area"), ("object_2", "sorting_area")))
    for extra in ((), (C("On", ("object_2", "position_13")),) if "object_2" not in str(goal) else ()):
        found = updated(cargo, ((*extra, *goal),))
        assert isinstance(found, Unsolvable)
        assert set(found.goals) == set(goal)
