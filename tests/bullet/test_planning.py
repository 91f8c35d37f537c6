"""Motions that are searched for, where lifting, swinging over and lowering does not do."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
import pytest

from llmbt_ir.condition import ActionCall
from llmbt_ir.scene import Fixture, Scene, load_scene
from llmbt_runtime.bullet.bodies import lying_at
from llmbt_runtime.bullet.kinematics import solve_one, tip_of
from llmbt_runtime.bullet.motion import plan_line
from llmbt_runtime.bullet.planning import plan_tip
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.world import ActionReport, Status

WALL = Fixture("wall", (0.62, 0.27, 0.775), (0.60, 0.02, 0.75), "grey")


def walled(*, closed: bool = False) -> Scene:
    """A wall between the sorting area and the shelf, higher than the hand comes; open towards the robot, or not."""
    scene = load_scene("cargo_sorting")
    wall = replace(WALL, xyz_m=(0.53, 0.27, 0.775), size_m=(0.86, 0.02, 0.75)) if closed else WALL
    return replace(scene, fixtures=(*scene.fixtures, wall))


def act(world: BulletWorld, name: str, *args: str) -> ActionReport:
    world.start(ActionCall(name, args))
    while (report := world.advance()).status is Status.RUNNING:
        pass
    return report


def test_round_a_wall_and_back_with_a_block_in_the_hand() -> None:
    world = BulletWorld(walled())
    assert act(world, "pick", "object_1", "sorting_area") == ActionReport(Status.SUCCESS)
    assert act(world, "place", "object_1", "position_12") == ActionReport(Status.SUCCESS)
    assert math.dist(world.objects()["object_1"][:2], world.places()["position_12"][:2]) < 0.005
    assert act(world, "pick", "object_2", "sorting_area") == ActionReport(Status.SUCCESS)
    first = world.objects()
    world.reset()
    for name, *args in (
        ("pick", "object_1", "sorting_area"),
        ("place", "object_1", "position_12"),
        ("pick", "object_2", "sorting_area"),
    ):
        act(world, name, *args)
    assert world.objects() == first, "a search is seeded for each call"
    world.close()


def test_no_way_is_a_reason() -> None:
    """The arm starts on the other side of a wall that goes on behind it."""
    world = BulletWorld(walled(closed=True))
    started = time.monotonic()
    report = act(world, "pick", "object_1", "sorting_area")
    assert report.status is Status.FAILURE and report.reason == "no_plan"
    assert time.monotonic() - started < 60, "bounded by iterations"
    assert "HandEmpty" in {str(f) for f in world.observe()}
    world.close()


def test_a_planned_way_meets_nothing_by_bullets_own_distances() -> None:
    """Every row of every motion, with what is held: against the checker of a second client, at a finer step."""
    world = BulletWorld(walled())
    act(world, "pick", "object_1", "sorting_area")
    arm, approach = world._arm, world._approach
    carried = arm.carried
    assert carried is not None
    approach.mirror(world._bench.sensed.states, without="object_1")
    start = world._bench.panda.tip()
    end = (0.44, 0.06, 0.2, math.pi / 2)

    def free_at(tip: tuple[float, float, float, float]) -> bool:
        q = solve_one(tip)
        return q is not None and approach.is_free(q, 0.045, carried)

    way = plan_tip(start, end, free_at, lambda m: approach.free_along(m.q[::5], 0.045, carried))
    assert way is not None and len(way) > 1, "straight over does not do"
    block = world._bench.kinds["object_1"]
    at = start
    for corner in way:
        motion = plan_line(at, corner, 1.0, 4.0)
        assert motion is not None
        for q in motion.q:
            assert approach.is_free(q, 0.045, None)
            x, y, z, yaw = approach.frame.to_world(tip_of(q))
            held = lying_at(block, (x, y, z - carried.below_m), yaw)
            gap = max(abs(held.xyz[0] - WALL.xyz_m[0]) - 0.30, abs(held.xyz[1] - WALL.xyz_m[1]) - 0.01)
            assert gap > 0.0225 or held.extent.bottom_m > 1.15
        at = corner
    world.close()


@pytest.mark.parametrize("seed", range(3))
def test_random_ways_in_a_plane_with_discs(seed: int) -> None:
    """The search by itself: discs to keep off, found just where a way exists on a grid."""
    rng = np.random.default_rng(seed)
    discs = [(float(a), float(b), float(c)) for a, b, c in rng.uniform((0.3, -0.5, 0.03), (0.7, 0.5, 0.1), (6, 3))]

    def clear(x: float, y: float) -> bool:
        return all(math.hypot(x - a, y - b) > c for a, b, c in discs)

    ends = [(x, y, 0.2, math.pi / 2) for x, y in ((0.45, -0.55), (0.45, 0.55)) if clear(x, y)]
    if len(ends) < 2:
        pytest.skip("an end is covered")

    def rows(motion: object) -> bool:
        return all(clear(*tip_of(q)[:2]) for q in motion.q)  # type: ignore[attr-defined]

    way = plan_tip(ends[0], ends[1], lambda t: solve_one(t) is not None and clear(t[0], t[1]), rows)
    assert way is not None and math.dist(way[-1][:3], ends[1][:3]) < 1e-9
