"""Ground actions: exact effects, mutexes that are true, containment that is always consistent."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_atl.state import Domain, GroundAction, applicable, apply
from llmbt_ir.condition import ActionCall, Condition, Facts, holds
from tests.oracle import Cargo
from tests.strategies import canonical_cargo, cargos, domain_for, layout

C = Condition


def walk(data: st.DataObject, domain: Domain, facts: Facts, steps: int = 6) -> list[Facts]:
    """The states of a walk of random applicable actions."""
    states = [facts]
    for _ in range(steps):
        able = [a for a in domain.actions if applicable(a, states[-1])]
        if not able:
            break
        states.append(apply(data.draw(st.sampled_from(able)), states[-1]))
    return states


def described(action: GroundAction) -> str:
    lines = [str(action)]
    for sign, conditions in (("start", action.start), ("hold ", action.hold)):
        lines += [f"  {sign} {c}" for c in conditions]
    lines += [f"  + {c}" for c in sorted(action.adds)]
    lines += [f"  - {c}" for c in sorted(action.deletes)]
    return "\n".join(lines) + "\n"


def test_the_ground_effects_of_cargo_sorting(golden: Callable[[str, str], None]) -> None:
    """Every ground action of one object, one obstacle, one level with two positions, the bench and the area on it."""
    cargo = Cargo(layout(1, 2), (("object_1", "position_11"), ("obstacle_1", "sorting_area")))
    golden("cargo_effects.txt", "\n".join(described(a) for a in domain_for(cargo).actions))


@given(cargos(), st.data())
def test_no_two_facts_of_a_reachable_state_are_mutex(cargo: Cargo, data: st.DataObject) -> None:
    domain = domain_for(cargo)
    for state in walk(data, domain, cargo.facts()):
        clashes = [(str(a), str(b)) for a, b in combinations(sorted(state), 2) if domain.mutex(a, b)]
        assert clashes == []


@given(cargos(), st.data())
def test_of_a_state_variable_at_most_one_value_holds(cargo: Cargo, data: st.DataObject) -> None:
    """But for a place and those that contain it, which hold together."""
    domain = domain_for(cargo)
    for state in walk(data, domain, cargo.facts()):
        held: dict[tuple[str, tuple[str, ...]], list[Condition]] = {}
        for fact in sorted(state):
            for variable, key in domain.variables_of(fact):
                held.setdefault((variable.name, key), []).append(fact)
        for values in held.values():
            specific = [f for f in values if not any(f in set(domain.upward(g)) - {g} for g in values)]
            assert len(specific) == 1, [str(v) for v in values]


@given(cargos(), st.data())
def test_containment_is_always_consistent(cargo: Cargo, data: st.DataObject) -> None:
    """What holds for a place holds for the places that contain it; what a place holds is on something inside it."""
    domain = domain_for(cargo)
    for state in walk(data, domain, cargo.facts()):
        for fact in state:
            assert set(domain.upward(fact)) <= state
        for fact in state:
            if fact.name == "On" and not domain.fits(fact.args[1], "spot"):
                inside = [p for p in domain.types if domain.contains(fact.args[1], p)]
                assert any(C("On", (fact.args[0], p)) in state for p in inside), str(fact)


@given(cargos(), st.data())
def test_actions_do_in_the_facts_what_they_do_with_things(cargo: Cargo, data: st.DataObject) -> None:
    """Applicability and effects against a model of things on places, for actions that name the place itself."""
    domain, here = domain_for(cargo), cargo
    for _ in range(6):
        facts = here.facts()
        able = {a.call for a in domain.actions if applicable(a, facts) and _specific(a.call, here)}
        possible = dict(here.steps())
        possible |= {
            ActionCall("put_down", c.args): then
            for c, then in possible.items()
            if c.name == "place" and c.args[1] in here.layout.buffers
        }
        assert able == set(possible)
        if not able:
            break
        call = data.draw(st.sampled_from(sorted(able)))
        here = possible[call]
        action = domain.action(call)
        assert action is not None
        assert apply(action, facts) == here.facts()


def _specific(call: ActionCall, cargo: Cargo) -> bool:
    where = dict(cargo.at)
    if call.name == "pick":
        return where.get(call.args[0]) == call.args[1]
    return call.name != "clear_away" or where.get(call.args[0]) == call.args[2]


@given(cargos())
def test_a_mutex_is_one_of_the_physical_states_too(cargo: Cargo) -> None:
    """Breadth first over two steps: what the domain calls mutex never holds together in the model of things."""
    domain = domain_for(cargo)
    states = {cargo} | {s for _, s in cargo.steps()}
    states |= {t for s in tuple(states)[:8] for _, t in s.steps()}
    for state in list(states)[:20]:
        facts = sorted(state.facts())
        assert not [(a, b) for a, b in combinations(facts, 2) if domain.mutex(a, b)]
        for fact in facts:
            assert domain.mutex(fact, ~fact)
            assert not domain.mutex(fact, fact)


@given(cargos())
def test_adds_and_deletes_are_disjoint_and_every_action_changes_something(cargo: Cargo) -> None:
    for a in domain_for(cargo).actions:
        assert not a.adds & a.deletes
        assert a.deletes or not a.adds <= set(a.pre)
        for c in a.pre:
            assert not (a.achieves(c) and a.falsifies(c))


@pytest.mark.parametrize(
    ("a", "b", "exclude"),
    [
        (C("HandEmpty"), C("Holding", ("object_1",)), True),
        (C("Holding", ("object_1",)), C("Holding", ("object_2",)), True),
        (C("On", ("object_1", "position_12")), C("On", ("object_1", "position_13")), True),
        (C("On", ("object_1", "position_12")), C("On", ("object_1", "shelf_level_1")), False),
        (C("On", ("object_1", "position_12")), C("On", ("object_1", "shelf_level_2")), True),
        (C("On", ("object_1", "shelf_level_1")), C("On", ("object_2", "shelf_level_1")), False),
        (C("On", ("object_1", "position_12")), C("On", ("object_2", "position_12")), True),
        (C("On", ("object_1", "sorting_area")), C("On", ("object_2", "sorting_area")), False),
        (C("On", ("object_1", "position_12")), C("Free", ("position_12",)), True),
        (C("On", ("object_1", "sorting_area")), C("Free", ("sorting_area",)), False),
        (C("On", ("object_1", "position_12")), C("Holding", ("object_1",)), True),
        (C("Clear", ("object_1",)), C("Blocks", ("object_2", "object_1")), True),
        (C("Clear", ("object_2",)), C("Blocks", ("object_2", "object_1")), False),
        (C("On", ("object_1", "position_12")), C("On", ("object_1", "shelf"), True), True),
        (C("On", ("object_1", "shelf")), C("On", ("object_1", "position_12"), True), False),
        (C("HandEmpty", (), True), C("Holding", ("object_1",), True), False),
    ],
)
def test_mutexes_of_the_cargo_scene(a: Condition, b: Condition, exclude: bool) -> None:
    domain = domain_for(canonical_cargo())
    assert domain.mutex(a, b) is domain.mutex(b, a) is exclude


def test_things_that_appear_get_the_type_that_their_conditions_ask_for() -> None:
    domain = domain_for(canonical_cargo())
    facts = canonical_cargo().facts() | {C("On", ("surprise", "position_12")), C("Clear", ("surprise",))}
    seen = domain.for_state(facts)
    assert not domain.fits("surprise", "movable") and seen.fits("surprise", "movable")
    assert seen.action(ActionCall("move_aside", ("surprise", "position_12", "sorting_area"))) is not None
    assert seen.for_state(facts) is seen


@pytest.mark.parametrize(
    "call",
    [
        ActionCall("juggle", ("object_1",)),
        ActionCall("pick", ("object_1",)),
        ActionCall("pick", ("position_12", "object_1")),
        ActionCall("place", ("object_1", "shelf_level_1")),
        ActionCall("put_down", ("object_1", "position_12")),
    ],
)
def test_there_is_no_such_action(call: ActionCall) -> None:
    assert domain_for(canonical_cargo()).action(call) is None


@given(cargos())
def test_achievers_are_what_brings_a_literal_about(cargo: Cargo) -> None:
    domain, facts = domain_for(cargo), cargo.facts()
    for goal in sorted(facts)[:5] + [~f for f in sorted(facts)[:5]]:
        for action in domain.achievers(goal):
            state = apply(action, facts)
            assert holds(goal, state)
            assert goal not in action.pre


def test_grounding_does_not_depend_on_the_order_of_sets() -> None:
    domain = domain_for(canonical_cargo())
    ranked = [a.call for a in domain.actions]
    assert ranked == [a.call for a in domain_for(canonical_cargo()).actions]
    assert len(set(ranked)) == len(ranked)


def test_picking_is_from_the_most_specific_place() -> None:
    """pick(object_1, shelf_level_1) is for a thing that stands on the level beside its slots: otherwise the slot would
    be lost, neither free nor taken."""
    cargo = canonical_cargo(object_1="position_12")
    domain = domain_for(cargo)
    action = domain.action(ActionCall("pick", ("object_1", "shelf_level_1")))
    assert action is not None
    assert not applicable(action, cargo.facts())
    assert ~C("On", ("object_1", "position_12")) in action.start
