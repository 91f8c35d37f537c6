"""The first thing the world must do: pick and place one block, whatever the tick phase, the start and the target."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace

import numpy as np
import pytest

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.geometry import Pose, quat_from_yaw
from llmbt_ir.scene import Scene, load_scene
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.world import Status

SLOTS = [f"position_{level}{column}" for level in "123" for column in "1234"]


def one_block(scene: Scene, rng: np.random.Generator) -> Scene:
    """The scene with one block of 4 to 5 cm somewhere in the sorting area, turned at random."""
    area = scene.place("sorting_area")
    assert area.surface_m is not None
    size = float(rng.uniform(0.04, 0.05))
    x, y = (area.surface_m[i] + float(rng.uniform(-1, 1)) * (area.size_m[i] / 2 - 0.04) for i in (0, 1))
    pose = Pose((x, y, area.surface_m[2] + size / 2), quat_from_yaw(float(rng.uniform(0, 2 * math.pi))))
    block = replace(scene.objects[0], size_m=(size, size, size), pose=pose)
    return replace(scene, objects=(block,), obstacles=())


def run(world: BulletWorld, action: ActionCall) -> tuple[Status, str, list[Facts]]:
    """The action to its end, and every set of facts that was observed on the way, repeats left out."""
    seen = [world.observe()]
    world.start(action)
    while True:
        report = world.advance()
        if world.observe() != seen[-1]:
            seen.append(world.observe())
        if report.status is not Status.RUNNING:
            return report.status, report.reason, seen


def pick_and_place(reps: int, seed: int) -> list[float]:
    """Errors in metres; asserts that each attempt succeeds and that the facts change once in each action."""
    rng = np.random.default_rng(seed)
    scene = load_scene("cargo_sorting")
    errors = []
    for rep in range(reps):
        world = BulletWorld(one_block(scene, rng), seed=rep)
        try:
            for _ in range(int(rng.integers(0, 24))):  # the phase of the tick
                world._bench.client.stepSimulation()
            slot = str(rng.choice(SLOTS))
            for action, post in (
                (ActionCall("pick", ("object_1", "sorting_area")), Condition("Holding", ("object_1",))),
                (ActionCall("place", ("object_1", slot)), Condition("On", ("object_1", slot))),
            ):
                status, reason, seen = run(world, action)
                assert status is Status.SUCCESS, (rep, action, reason)
                assert len(seen) == 2, (rep, action, "the facts flicker", seen)
                assert post in world.truth()
            xyz, goal = world.objects()["object_1"], world.places()[slot]
            errors.append(math.dist(xyz[:2], goal[:2]))
        finally:
            world.close()
    return errors


def test_ten_of_ten() -> None:
    assert statistics.median(pick_and_place(10, seed=1)) < 0.005


@pytest.mark.slow
def test_a_hundred_of_a_hundred() -> None:
    errors = pick_and_place(100, seed=2)
    print(f"median {1000 * statistics.median(errors):.2f} mm, worst {1000 * max(errors):.2f} mm")
    assert statistics.median(errors) < 0.005
    assert max(errors) < 0.02
