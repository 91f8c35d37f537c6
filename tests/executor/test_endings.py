"""How an execution ends when neither success nor a proof ends it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.scene import load_scene
from llmbt_ir.tree import goal_tree
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.executor import Settings, execute
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.world import ActionReport, World, WorldLostError
from tests.strategies import CANONICAL, canonical_cargo, domain_for

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
