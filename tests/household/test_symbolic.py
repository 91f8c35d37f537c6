"""The household in the world of facts: where the robot has to be, one thing at a time, what is in the way."""

from __future__ import annotations

import numpy as np
import pytest

from llmbt_atl.library import load_library
from llmbt_atl.state import Domain, domain_of
from llmbt_ir.condition import Condition, Facts, parse_condition
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.tree import goal_tree
from llmbt_runtime.executor import execute
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.outcome import Outcome, Result
from llmbt_runtime.symbolic import Event, SymbolicWorld


def home() -> tuple[Domain, Facts]:
    found = to_semantic_map(load_scene("household"))
    domain = domain_of(load_library("household"), found)
    return domain, facts_of_map(domain, found)


def facts(*texts: str) -> Facts:
    return frozenset(c for t in texts if (c := parse_condition(t)) is not None)


def run(*goals: str, now: Facts | None = None, events: tuple[Event, ...] = (), seed: int = 0) -> Result:
    domain, start = home()
    start = start if now is None else now
    wanted = (tuple(c for g in goals if (c := parse_condition(g)) is not None),)
    domain = domain.for_state(start)
    world = SymbolicWorld(domain, start, np.random.default_rng(seed), events=events)
    return execute(world, domain, goal_tree(wanted), wanted, keep=lambda _: "v")


def actions(result: Result) -> list[str]:
    return [str(a.call) for a in result.actions if a.result == "SUCCESS"]


def test_what_stands_where() -> None:
    _, start = home()
    drinks, food = ("milk", "coke", "juice", "water", "tea"), ("potato_chips", "chocolate", "bread", "cookies", "apple")
    on = {c.args for c in start if c.name == "On"}
    assert on == {(o, "bar") for o in drinks} | {(o, "table") for o in food}
    assert {c.args[0] for c in start if c.name == "Free"} == {"table", "bar", "desk", "shelf", "user"}
    assert not any(c.name == "Near" for c in start)
    assert not any("obstacle" in a for c in start for a in c.args)


def test_bring_the_milk() -> None:
    result = run("On(milk, user)")
    assert result.outcome is Outcome.SUCCESS and result.updates == 1 and result.planner_calls == 0
    assert actions(result) == ["navigate(bar)", "pick(milk, bar)", "navigate(user)", "place(milk, user)"]


def test_one_thing_at_a_time_and_back_to_the_bar() -> None:
    result = run("On(milk, user)", "On(coke, user)", "Near(bar)")
    assert result.outcome is Outcome.SUCCESS
    assert actions(result)[-1] == "navigate(bar)" and len(actions(result)) == 9


def test_the_robot_cannot_be_at_two_places() -> None:
    result = run("Near(bar)", "Near(table)")
    assert result.outcome is Outcome.UNSOLVABLE
    assert {str(g) for g in result.unsolvable} == {"Near(bar)", "Near(table)"}


def test_the_milk_behind_an_obstacle() -> None:
    """The paper's figure: first the obstacle is moved away from the milk."""
    _, start = home()
    there = start - facts("Clear(milk)") | facts("Blocks(obstacle_1, milk)", "On(obstacle_1, bar)", "Clear(obstacle_1)")
    result = run("On(milk, user)", now=there)
    expected = ["navigate(bar)", "clear_away(obstacle_1, milk, bar)", "pick(milk, bar)"]
    assert result.outcome is Outcome.SUCCESS and actions(result)[:3] == expected


def test_a_full_place_is_made_room_on_first() -> None:
    _, start = home()
    full = start - facts("Free(user)") | facts("On(obstacle_1, user)", "Clear(obstacle_1)")
    result = run("On(milk, user)", now=full)
    assert result.outcome is Outcome.SUCCESS
    assert any(a.startswith("move_aside(obstacle_1, user, ") for a in actions(result))


def test_what_stands_in_the_way_of_the_base_is_moved_with_an_empty_hand() -> None:
    _, start = home()
    held = start - facts("HandEmpty", "On(milk, bar)", "Clear(user)") | facts("Holding(milk)", "Near(bar)")
    held |= facts("Blocks(obstacle_3, user)", "Fallen(obstacle_3)", "Clear(obstacle_3)")
    result = run("On(milk, user)", now=held)
    assert result.outcome is Outcome.SUCCESS
    assert actions(result)[:2] == ["place(milk, bar)", "clear_way(obstacle_3, user)"]


def test_a_way_that_closes_while_the_robot_drives() -> None:
    """Clear of a location is a hold-condition: the drive is halted, not ended where nothing can stand."""
    closes = Event(
        2,
        facts("Clear(user)"),
        facts("Blocks(obstacle_3, user)", "Fallen(obstacle_3)", "Clear(obstacle_3)"),
        facts_of("Holding(milk)"),
    )
    result = run("On(milk, user)", events=(closes,))
    assert result.outcome is Outcome.SUCCESS
    assert "clear_way(obstacle_3, user)" in actions(result)


def test_nobody_moves_an_armchair() -> None:
    _, start = home()
    result = run("On(milk, user)", now=start - facts("Clear(user)"))
    assert result.outcome is Outcome.UNSOLVABLE and [str(g) for g in result.unsolvable] == ["On(milk, user)"]


@pytest.mark.parametrize("fell", ["milk", "apple"])
def test_what_fell_is_recovered(fell: str) -> None:
    _, start = home()
    gone = frozenset(c for c in start if not (c.name == "On" and c.args[0] == fell))
    result = run(f"On({fell}, user)", now=gone | facts(f"Fallen({fell})"))
    assert result.outcome is Outcome.SUCCESS
    assert actions(result) == [f"recover({fell}, user)"]


def test_actions_leave_the_robot_at_one_place_at_most() -> None:
    domain, start = home()
    near = [Condition("Near", (p,)) for p in ("bar", "table")]
    assert domain.mutex(*near)
    for action in domain.for_state(start).actions:
        assert sum(f.name == "Near" for f in action.adds) <= 1


def facts_of(text: str) -> tuple[Condition, ...]:
    found = parse_condition(text)
    assert found is not None
    return (found,)
