"""How an execution ends when neither success nor a proof ends it."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.scene import load_scene
from llmbt_ir.tree import goal_tree
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.executor import Settings, execute
from llmbt_runtime.outcome import Outcome, Result
from llmbt_runtime.symbolic import Event, SymbolicWorld
from llmbt_runtime.world import ActionReport, Status, World, WorldLostError
from tests.strategies import CANONICAL, canonical_cargo, domain_for
from tests.strips import Op, Strips, random_strips

C = Condition

GOALS = (CANONICAL,)


class Ending(SymbolicWorld):
    """Ends with an exception at a tick."""

    fault: BaseException = WorldLostError("the plug was pulled")
    left = 9

    def advance(self) -> ActionReport:
        self.left -= 1
        if self.left == 0:
            raise self.fault
        return super().advance()


def symbolic(kind: type[SymbolicWorld] = SymbolicWorld, **options: float) -> World:
    cargo = canonical_cargo()
    return kind(domain_for(cargo), cargo.facts(), np.random.default_rng(0), **options)  # type: ignore[arg-type]


def outcome(world: World, **limits: int) -> tuple[Outcome, str]:
    domain = domain_for(canonical_cargo())
    found = execute(world, domain, goal_tree(GOALS), GOALS, keep=lambda _: "v", settings=Settings(**limits))
    return found.outcome, found.reason


def test_a_world_that_is_lost() -> None:
    assert outcome(symbolic(Ending)) == (Outcome.WORLD_LOST, "the plug was pulled")


def test_an_interrupt_is_an_outcome() -> None:
    class Interrupted(Ending):
        fault = KeyboardInterrupt()

    assert outcome(symbolic(Interrupted))[0] is Outcome.INTERRUPTED


def test_the_guard_on_ticks() -> None:
    assert outcome(symbolic(), max_ticks=20)[0] is Outcome.BUDGET


def test_an_action_that_always_fails() -> None:
    found, reason = outcome(symbolic(failure_rate=1.0))
    assert found is Outcome.ACTION_FAILED
    assert "no plan is left" in reason


def test_the_physics_server_goes_away(tmp_path: Path) -> None:
    world = BulletWorld(load_scene("cargo_sorting"), 0)
    world.start(ActionCall("pick", ("object_1", "sorting_area")))
    world.advance()
    world.close()
    with pytest.raises(WorldLostError):
        world.advance()


def test_a_goal_that_nothing_brings_about() -> None:
    goals = ((Condition("Blocks", ("object_1", "object_2")),),)
    world = symbolic()
    found = execute(world, domain_for(canonical_cargo()), goal_tree(goals), goals, keep=lambda _: "v")
    assert found.outcome is Outcome.UNSOLVABLE
    assert found.unsolvable == goals[0]
    assert not found.actions


# -- never a spin ----------------------------------------------------------------------------------------------------


class Silent(SymbolicWorld):
    """Every action says that it succeeded, and nothing happened."""

    def advance(self) -> ActionReport:
        report = super().advance()
        if report.status is Status.SUCCESS:
            self._state.become(self.before)
        return report

    def start(self, action: ActionCall) -> None:
        self.before = self.truth()
        super().start(action)


class Undone(SymbolicWorld):
    """Everything that is done is undone again, a tick later and for ever."""

    def advance(self) -> ActionReport:
        before = self.truth() | self._suspended
        running = self._running is not None
        if not running:
            self._state.become(getattr(self, "then", self.truth()))
        report = super().advance()
        if report.status is Status.SUCCESS:
            self.then = before
        return report


def ended(problem: Strips, kind: type[SymbolicWorld], events: tuple[Event, ...] = (), **limits: int) -> Result:
    world = kind(problem.domain, problem.facts, np.random.default_rng(1), events=events)
    tree = goal_tree(problem.goals)
    return execute(world, problem.domain, tree, problem.goals, keep=lambda _: "v", settings=Settings(**limits))


def test_a_world_in_which_nothing_happens_though_it_says_so() -> None:
    """All that could lead on is tried three times, and then it is said."""
    cargo = canonical_cargo()
    domain = domain_for(cargo)
    world = Silent(domain, cargo.facts(), np.random.default_rng(0))
    found = execute(world, domain, goal_tree(GOALS), GOALS, keep=lambda _: "v")
    assert found.outcome is Outcome.ACTION_FAILED
    tries = Counter(a.call for a in found.actions)
    assert set(tries.values()) == {3} and len(tries) <= len(domain.actions)
    assert "pick(object_1, sorting_area) failed 3 times (post_not_reached: Holding(object_1))" in found.reason
    assert found.ticks < 2_000


def test_what_only_ends_something_and_does_not_is_noticed() -> None:
    ops = (Op("clean", (), (), frozenset(), frozenset({C("dirty")})),)
    found = ended(Strips(ops, frozenset({C("dirty")}), ((~C("dirty"),),)), Silent)
    assert found.outcome is Outcome.ACTION_FAILED
    assert [a.result for a in found.actions] == ["FAILURE"] * 3
    assert found.reason == "clean failed 3 times (post_not_reached: not dirty); without it no plan is left"


@pytest.mark.parametrize("kind", [Silent, Undone])
def test_no_world_makes_it_spin(kind: type[SymbolicWorld]) -> None:
    """Random problems whose actions do nothing, or are undone again and again: all end, long before the guard."""
    outcomes = Counter(
        ended(random_strips(random.Random(seed)), kind, max_ticks=20_000).outcome.value for seed in range(150)
    )
    assert set(outcomes) <= {"SUCCESS", "UNSOLVABLE", "ACTION_FAILED"}
    assert outcomes["ACTION_FAILED"] > 20


def test_unsolvable_is_said_where_it_is_so_though_an_action_failed() -> None:
    """`try` always fails and is left out; then what both ways need is lost: no failure is to blame for that."""

    class Stubborn(SymbolicWorld):
        def start(self, action: ActionCall) -> None:
            super().start(action)
            self._failing = True

    ops = tuple(Op(n, (), (C("tool"),), frozenset({C("done")}), frozenset()) for n in ("try", "other"))
    problem = Strips(ops, frozenset({C("tool")}), ((C("done"),),))
    lost = Event(25, frozenset({C("tool")}), frozenset())
    found = ended(problem, Stubborn, (lost,))
    assert found.outcome is Outcome.UNSOLVABLE and found.unsolvable == (C("done"),)
    assert found.reason == "done cannot be reached from here: nothing brings done about here (try would need tool)"
    assert ended(problem, Stubborn).outcome is Outcome.ACTION_FAILED


def test_what_only_a_failure_speaks_against_proves_nothing() -> None:
    """No room for the one thing that was held over a place is no proof that there is none."""

    class Full(SymbolicWorld):
        def advance(self) -> ActionReport:
            report = super().advance()
            if report.status is not Status.SUCCESS:
                return report
            self._state.become(self.before - {C("room")})
            return ActionReport(Status.FAILURE, "no_free_buffer", denies=C("room"))

        def start(self, action: ActionCall) -> None:
            self.before = self.truth()
            super().start(action)

    problem = Strips(
        (Op("put", (), (C("room"),), frozenset({C("done")}), frozenset()),), frozenset({C("room")}), ((C("done"),),)
    )
    found = ended(problem, Full)
    assert found.outcome is Outcome.ACTION_FAILED
    assert found.reason == "put failed (no_free_buffer), so room is taken not to hold, and no plan is left"
    assert ended(problem, SymbolicWorld, (Event(0, frozenset({C("room")}), frozenset()),)).outcome is Outcome.UNSOLVABLE


GO = Strips((Op("go", (), (), frozenset({C("there")}), frozenset()),), frozenset(), ((C("there"),),))


def test_what_stands_in_the_way_of_an_action_is_named() -> None:
    class Blocked(SymbolicWorld):
        def advance(self) -> ActionReport:
            report = super().advance()
            if report.status is Status.SUCCESS and self.time_s < 100:
                self._state.become(self.before)
                return ActionReport(Status.FAILURE, "not_approachable", "obstacle_7")
            return report

        def start(self, action: ActionCall) -> None:
            self.before = self.truth()
            super().start(action)

    found = ended(
        Strips((Op("go", (), (), frozenset({C("there")}), frozenset()),), frozenset(), ((C("there"),),)), Blocked
    )
    assert found.outcome is Outcome.ACTION_FAILED
    assert found.reason == (
        "go failed 3 times (not_approachable, obstacle_7 is in the way); without it no plan is left"
    )


def test_an_action_without_end_is_named() -> None:
    class Endless(SymbolicWorld):
        def advance(self) -> ActionReport:
            self._left += 1
            return super().advance()

    found = ended(
        Strips((Op("go", (), (), frozenset({C("there")}), frozenset()),), frozenset(), ((C("there"),),)),
        Endless,
        max_ticks=50,
    )
    assert (found.outcome, found.reason) == (Outcome.BUDGET, "no end after 50 ticks; go is under way")
