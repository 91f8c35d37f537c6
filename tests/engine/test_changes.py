"""Worlds hand over what changed. The oracle: the difference of the whole states that `observe` gives."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_atl.state import GroundAction, applicable, apply
from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.scene import load_scene
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.facts import change_between
from llmbt_runtime.symbolic import Event, SymbolicWorld
from llmbt_runtime.symbolic_disturbance import symbolic_events
from llmbt_runtime.update.rollout import perceived
from llmbt_runtime.view import View
from llmbt_runtime.world import Status, World
from tests.strategies import CANONICAL, canonical_cargo, domain_for

Choose = Callable[[random.Random], ActionCall]


def let_loose(world: World, choose: Choose, rng: random.Random, ticks: int) -> Iterator[None]:
    """Start, halt and go on at random; stops after each of them."""
    running: ActionCall | None = None
    for _ in range(ticks):
        if running is None and rng.random() < 0.5:
            running = choose(rng)
            world.start(running)
        elif running is not None and rng.random() < 0.03 and world.halt():
            running = None
        yield
        if world.advance().status is not Status.RUNNING:
            running = None
        yield


def held_against_whole_states(world: World, choose: Choose, seed: int, ticks: int) -> int:
    """Asked at random moments, `changes` is the difference of whole states, at first all that holds; how often it was
    not empty."""
    rng, told, seen = random.Random(seed), frozenset[Condition](), 0
    for _ in let_loose(world, choose, rng, ticks):
        if rng.random() < 0.6:
            change, now = world.changes(), world.observe()
            assert change == change_between(told, now)
            told, seen = now, seen + bool(change)
    return seen


@given(st.integers(0, 10_000))
def test_the_changes_of_a_world_of_facts_are_the_difference_of_its_states(seed: int) -> None:
    cargo = canonical_cargo()
    domain = domain_for(cargo)
    chance = np.random.default_rng(seed)
    names = ("drop", "obstacle_at_place", "obstacle_at_pick", "placed_object_moved")
    specs = tuple(map(DisturbanceSpec, random.Random(seed).sample(names, 3)))
    events = symbolic_events(specs, domain, cargo.facts(), CANONICAL, chance)
    facts = tuple(cargo.facts())
    noise = [Event(k, frozenset({facts[(seed + k) % len(facts)]}), frozenset({facts[k % len(facts)]})) for k in (3, 9)]
    world = SymbolicWorld(domain, cargo.facts(), chance, failure_rate=0.2, events=(*events, *noise), goals=CANONICAL)

    def applicable_now(rng: random.Random) -> ActionCall:
        possible = [a.call for a in domain.actions if applicable(a, world.observe())]
        return rng.choice(possible or [domain.actions[0].call])

    assert held_against_whole_states(world, applicable_now, seed, 100) > 2


CARGO = [
    ActionCall("pick", ("object_1", "sorting_area")),
    ActionCall("place", ("object_1", "position_12")),
    ActionCall("pick", ("object_2", "sorting_area")),
    ActionCall("place", ("object_2", "position_13")),
]
HOUSEHOLD = [
    ActionCall("navigate", ("shelf",)),
    ActionCall("pick", ("milk", "shelf")),
    ActionCall("navigate", ("user",)),
    ActionCall("place", ("milk", "user")),
]


@pytest.mark.parametrize(("scene", "actions"), [("cargo_sorting", CARGO), ("household", HOUSEHOLD)])
def test_the_changes_of_a_physical_world_are_the_difference_of_its_states(
    scene: str, actions: list[ActionCall]
) -> None:
    """Also in the trial after a reset."""
    specs = (DisturbanceSpec("drop"), DisturbanceSpec("obstacle_at_place"))
    world = BulletWorld(load_scene(scene), 3, specs)
    try:
        for seed in (3, 4):
            turn = itertools.cycle(actions)
            assert held_against_whole_states(world, lambda _, turn=turn: next(turn), seed, 150) > 2
            world.reset(seed, specs)
    finally:
        world.close()


# -- what a tree is shown ---------------------------------------------------------------------------------------------


class Scripted(SymbolicWorld):
    """A world of facts that can be written to."""

    def become(self, facts: Facts) -> None:
        self._state.become(facts)


@given(st.integers(0, 10_000))
def test_a_view_is_what_is_perceived_and_how_it_differs_from_what_is_expected(seed: int) -> None:
    """The oracle computes whole states: `perceived`, `apply`, and their differences."""
    rng = random.Random(seed)
    cargo = canonical_cargo()
    domain = domain_for(cargo)
    everything = sorted(cargo.facts() | {f for a in domain.actions[:40] for f in a.adds})
    world = Scripted(domain, cargo.facts(), np.random.default_rng(seed))
    view = View(world)
    running: GroundAction | None = None
    expected: Facts | None = None
    assert not view.expects
    for _ in range(30):
        world.become(world.observe() ^ frozenset(rng.sample(everything, rng.randrange(3))))
        if rng.random() < 0.3:
            running = rng.choice(domain.actions[:40]) if rng.random() < 0.7 else None
            view.runs(running)
        view.look()
        seen = perceived(world.observe(), running)
        assert view.facts == seen
        if expected is not None and rng.random() < 0.2:
            action = rng.choice(domain.actions[:40])
            view.expect(action)
            expected = apply(action, expected)
        if rng.random() < 0.2:
            view.accept()
            expected = seen
        assert view.expects == (expected is not None)
        if expected is not None:
            assert (view.began, view.ended) == (seen - expected, expected - seen)
            within = running is not None and seen <= expected and expected - seen <= running.deletes
            assert view.as_expected(running) == (seen == expected or within)


def test_what_stays_the_same_stays_the_same_object() -> None:
    """So that nothing has to be compared in a tick in which nothing happens."""
    world = BulletWorld(load_scene("cargo_sorting"), 1)
    try:
        world.changes()
        before = world.observe()
        for _ in range(5):
            world.advance()
            assert not world.changes() and world.observe() is before
    finally:
        world.close()
