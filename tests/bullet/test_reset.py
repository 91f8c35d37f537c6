"""A trial restored is a new world, bit for bit, and takes less than 5 ms."""

from __future__ import annotations

import time

import pytest

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.scene import load_scene
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.disturbance import DisturbanceSpec

Actions = tuple[tuple[str, ...], ...]
SORT: Actions = (
    ("pick", "object_1", "sorting_area"),
    ("place", "object_1", "position_12"),
    ("pick", "object_2", "sorting_area"),
)
BRING: Actions = (("navigate", "bar"), ("pick", "milk", "bar"), ("navigate", "user"), ("place", "milk", "user"))
GOALS = {
    "cargo_sorting": tuple(Condition("On", (f"object_{i}", f"position_1{i + 1}")) for i in (1, 2)),
    "household": (Condition("On", ("milk", "user")),),
}


def played(world: BulletWorld, actions: Actions) -> list[object]:
    """Everything that can be seen of a run, tick by tick."""
    seen: list[object] = [world.observe()]
    for name, *args in actions:
        world.start(ActionCall(name, tuple(args)))
        while (report := world.advance()).status == "RUNNING":
            seen.append((report, world.observe(), world.truth(), world.objects(), world.snapshot()))
    return [*seen, world.time_s, world.disturbances()]


@pytest.mark.parametrize(("scene", "actions"), [("cargo_sorting", SORT), ("household", BRING)])
def test_a_restored_trial_is_a_new_world(scene: str, actions: Actions) -> None:
    goals, drop = GOALS[scene], (DisturbanceSpec("drop"),)
    worn = BulletWorld(load_scene(scene))
    quiet = played(worn, actions)
    worn.reset(3, drop, goals)
    disturbed = played(worn, actions)
    worn.start(ActionCall(actions[0][0], actions[0][1:]))
    for _ in range(9):
        worn.advance()
    worn.reset(7)  # in the midst of an action
    again = played(worn, actions)
    worn.close()

    new = BulletWorld(load_scene(scene), 7)
    assert played(new, actions) == quiet == again
    new.close()
    new = BulletWorld(load_scene(scene), 3, drop, goals)
    assert played(new, actions) == disturbed
    assert disturbed != quiet
    new.close()


@pytest.mark.parametrize("scene", ["cargo_sorting", "household"])
def test_a_trial_is_restored_in_less_than_five_milliseconds(scene: str) -> None:
    world = BulletWorld(load_scene(scene))
    world.start(ActionCall("navigate", ("bar",)) if scene == "household" else ActionCall("pick", SORT[0][1:]))
    world.settle(1.0)
    best = 1.0
    for _ in range(10):
        started = time.process_time()
        world.reset()
        best = min(best, time.process_time() - started)
    world.close()
    assert best < 0.005
