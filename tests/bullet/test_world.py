"""Skills, facts and halting in the physics."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.geometry import Pose, quat_from_yaw
from llmbt_ir.scene import Body, Scene, load_scene
from llmbt_runtime.bullet.bodies import lying_at
from llmbt_runtime.bullet.camera import DEFAULT_CAMERA, render_png
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.world import ActionReport, Status, World

AREA = "sorting_area"


@pytest.fixture
def world() -> Iterator[BulletWorld]:
    made = BulletWorld(load_scene("cargo_sorting"))
    yield made
    made.close()


def act(world: BulletWorld, name: str, *args: str) -> ActionReport:
    world.start(ActionCall(name, args))
    for _ in range(600):
        report = world.advance()
        if report.status is not Status.RUNNING:
            return report
    raise AssertionError(f"{name}{args} does not end")


def facts(world: BulletWorld, *names: str) -> set[str]:
    return {str(f) for f in world.observe() if f.name in names}


def put(world: BulletWorld, id_: str, pose: Pose, *, settle: float = 0.6) -> None:
    world._bench.put(id_, pose)
    world.settle(settle)


def above(world: BulletWorld, body: str, x: float, y: float, surface: float, yaw: float = 0.0) -> Pose:
    return Pose((x, y, surface + world._bench.kinds[body].size_m[2] / 2 + 0.0005), quat_from_yaw(yaw))


# ---------------------------------------------------------------------------------- what there is at the start


def test_the_start(world: BulletWorld) -> None:
    protocol: World = world
    assert protocol.time_s == 0
    assert world.observe() == world.truth()
    assert facts(world, "HandEmpty", "Holding", "Touching") == {"HandEmpty"}
    assert len(facts(world, "Clear")) == 6
    assert facts(world, "Blocks", "Fallen") == set()
    assert "On(object_1, workbench)" in facts(world, "On")
    assert "Free(sorting_area)" in facts(world, "Free")
    assert len([f for f in facts(world, "Free") if "position" in f]) == 12
    assert not any("obstacle" in id_ for id_ in world.objects())
    assert world.at_rest


def test_building_is_quick() -> None:
    started = time.process_time()
    BulletWorld(load_scene("cargo_sorting")).close()
    assert time.process_time() - started < 0.5


# ---------------------------------------------------------------------------------- the skills


def test_pick_and_put_down(world: BulletWorld) -> None:
    assert act(world, "pick", "object_5", AREA).status is Status.SUCCESS
    assert facts(world, "Holding", "HandEmpty") == {"Holding(object_5)"}
    assert not any(f.startswith("On(object_5") for f in facts(world, "On"))
    assert act(world, "put_down", "object_5", AREA).status is Status.SUCCESS
    assert {"On(object_5, sorting_area)"} <= facts(world, "On")
    assert len(facts(world, "Clear")) == 6


def test_place_onto_each_slot_and_take_back(world: BulletWorld) -> None:
    where = AREA
    for slot in ("position_11", "position_24", "position_31", "position_34"):
        assert act(world, "pick", "object_2", where).status is Status.SUCCESS
        assert act(world, "place", "object_2", slot).status is Status.SUCCESS
        assert f"On(object_2, {slot})" in facts(world, "On")
        assert math.dist(world.objects()["object_2"][:2], world.places()[slot][:2]) < 0.003
        where = slot


def test_a_full_level(world: BulletWorld) -> None:
    for i, o in enumerate(("object_1", "object_2", "object_4", "object_6"), start=1):
        assert act(world, "pick", o, AREA).status is Status.SUCCESS
        assert act(world, "place", o, f"position_1{i}").status is Status.SUCCESS
    assert act(world, "pick", "object_2", "position_12").status is Status.SUCCESS  # from between two neighbours


def test_move_aside_reports_what_it_is_for_at_its_end_only(world: BulletWorld) -> None:
    act(world, "pick", "object_1", AREA)
    act(world, "place", "object_1", "position_12")
    world.start(ActionCall("move_aside", ("object_1", "position_12", AREA)))
    while (report := world.advance()).status is Status.RUNNING:
        assert "Free(position_12)" not in facts(world, "Free")
        assert "On(object_1, sorting_area)" not in facts(world, "On")
    assert report.status is Status.SUCCESS
    assert "Free(position_12)" in facts(world, "Free")
    assert "On(object_1, sorting_area)" in facts(world, "On")


def test_a_thing_beside_blocks_and_is_cleared_away(world: BulletWorld) -> None:
    x, y, _ = world.objects()["object_3"]
    put(world, "obstacle_2", above(world, "obstacle_2", x + 0.049, y, 0.4))
    assert facts(world, "Blocks") == {"Blocks(obstacle_2, object_3)"}
    assert "Clear(object_3)" not in facts(world, "Clear")
    assert "Clear(obstacle_2)" in facts(world, "Clear")
    refused = act(world, "pick", "object_3", AREA)
    assert (refused.status, refused.reason, refused.blocker) == (
        Status.FAILURE,
        "not_approachable",
        "obstacle_2",
    )
    assert act(world, "clear_away", "obstacle_2", "object_3", AREA, AREA).status is Status.SUCCESS
    assert facts(world, "Blocks") == set()
    assert act(world, "pick", "object_3", AREA).status is Status.SUCCESS


def test_a_thing_on_top_blocks_and_is_recovered(world: BulletWorld) -> None:
    x, y, z = world.objects()["object_3"]
    put(world, "obstacle_1", above(world, "obstacle_1", x, y, z + 0.0225))
    assert facts(world, "Blocks", "Fallen") == {"Blocks(obstacle_1, object_3)", "Fallen(obstacle_1)"}
    assert act(world, "recover", "obstacle_1", AREA).status is Status.SUCCESS
    assert facts(world, "Blocks", "Fallen") == set()
    assert "On(obstacle_1, sorting_area)" in facts(world, "On")


def test_a_leaning_thing_is_fallen_and_recovered(world: BulletWorld) -> None:
    tilt = (0.0, math.sin(0.3), 0.0, math.cos(0.3))  # leans against the first step, 0.6 rad from upright
    put(world, "obstacle_2", Pose((0.352, -0.05, 0.4625), tilt), settle=1.5)
    assert "Fallen(obstacle_2)" in facts(world, "Fallen")
    assert act(world, "recover", "obstacle_2", AREA).status is Status.SUCCESS
    assert facts(world, "Fallen") == set()
    assert "On(obstacle_2, sorting_area)" in facts(world, "On")


def test_release(world: BulletWorld) -> None:
    act(world, "pick", "object_1", AREA)
    act(world, "place", "object_1", "position_12")
    bench = world._bench
    tip = world._approach.frame.to_world(bench.panda.tip())
    bench.panda.grip(0.08)
    world.settle(0.3)
    # a block against the inside of one finger: touched, not held
    size = bench.kinds["obstacle_1"].size_m[0]
    put(world, "obstacle_1", Pose((tip[0], tip[1] + 0.037 - size / 2, tip[2]), quat_from_yaw(0.0)), settle=0.1)
    bench.client.changeDynamics(bench.bodies["obstacle_1"], -1, mass=0.0)
    bench.panda.grip(0.07)
    world.settle(0.3)
    assert facts(world, "HandEmpty", "Holding", "Touching") == {"Touching(obstacle_1)"}
    assert act(world, "release", "obstacle_1").status is Status.SUCCESS
    assert facts(world, "HandEmpty", "Holding", "Touching") == {"HandEmpty"}


def test_place_refuses_a_taken_slot_and_keeps_the_thing(world: BulletWorld) -> None:
    act(world, "pick", "object_1", AREA)
    act(world, "place", "object_1", "position_12")
    act(world, "pick", "object_2", AREA)
    report = act(world, "place", "object_2", "position_12")
    assert (report.status, report.reason, report.blocker) == (Status.FAILURE, "spot_occupied", "object_1")
    assert facts(world, "Holding") == {"Holding(object_2)"}
    assert act(world, "place", "object_2", "position_13").status is Status.SUCCESS


def test_reasons_for_what_cannot_be_done(world: BulletWorld) -> None:
    assert act(world, "place", "object_1", "position_12").reason == "not_holding"
    put(world, "object_1", above(world, "object_1", 0.72, 0.66, 0.4))
    assert facts(world, "Clear", "Blocks").isdisjoint({"Clear(object_1)"})  # out of reach: neither
    assert act(world, "pick", "object_1", "workbench").reason == "not_approachable"
    assert act(world, "pick", "object_2", AREA).status is Status.SUCCESS
    assert act(world, "pick", "object_3", AREA).reason == "hand_not_empty"


def test_a_bad_call_is_a_value_error(world: BulletWorld) -> None:
    for action in (
        ActionCall("pick", ("object_9", AREA)),
        ActionCall("pick", ("object_1",)),
        ActionCall("fly", ("object_1",)),
    ):
        with pytest.raises(ValueError, match=r"unknown object_9|no such action"):
            world.start(action)
    world.start(ActionCall("pick", ("object_1", AREA)))
    with pytest.raises(ValueError, match="is running"):
        world.start(ActionCall("pick", ("object_2", AREA)))


def test_a_drop_on_the_way_ends_the_action_in_the_same_tick(world: BulletWorld) -> None:
    act(world, "pick", "object_3", AREA)
    world.start(ActionCall("place", ("object_3", "position_22")))
    for _ in range(6):
        world.advance()
    world._bench.slip()
    for _ in range(3):
        report = world.advance()
        if world._bench.sensed.held is None:
            break
    assert (report.status, report.reason) == (Status.FAILURE, "dropped_on_the_way")
    assert facts(world, "HandEmpty", "Holding", "Touching") <= {"HandEmpty", "Touching(object_3)"}
    while not world.at_rest:
        world.advance()
    assert any("object_3" in f for f in facts(world, "On", "Fallen"))


# ---------------------------------------------------------------------------------- halting


@pytest.mark.parametrize("ticks", [1, 7, 15, 20, 26, 29, 32])
def test_halting_a_pick(world: BulletWorld, ticks: int) -> None:
    world.start(ActionCall("pick", ("object_4", AREA)))
    for _ in range(ticks):
        assert world.advance().status is Status.RUNNING
    waited = 0
    while not world.halt():
        world.advance()
        waited += 1
    assert waited < 30
    assert len(facts(world, "HandEmpty", "Holding", "Touching")) == 1
    before = facts(world, "Holding")
    assert act(world, "pick", "object_4", AREA).reason == ("hand_not_empty" if before else "")
    assert facts(world, "Holding") == {"Holding(object_4)"}


@pytest.mark.parametrize("ticks", [2, 9, 14, 20, 30, 38])
def test_halting_a_place(world: BulletWorld, ticks: int) -> None:
    act(world, "pick", "object_4", AREA)
    world.start(ActionCall("place", ("object_4", "position_14")))
    for _ in range(ticks):
        assert world.advance().status is Status.RUNNING
    while not world.halt():
        world.advance()
    if "Holding(object_4)" in facts(world, "Holding"):
        assert act(world, "put_down", "object_4", AREA).status is Status.SUCCESS
        assert "On(object_4, sorting_area)" in facts(world, "On")
    else:
        assert "On(object_4, position_14)" in facts(world, "On")


def test_halting_while_idle_and_settling(world: BulletWorld) -> None:
    assert world.halt()
    world.settle(0.5)
    assert world.time_s == pytest.approx(0.5)
    assert world.advance().status is Status.IDLE


# ---------------------------------------------------------------------------------- facts


def test_off_centre_on_a_level_is_on_no_slot(world: BulletWorld) -> None:
    put(world, "obstacle_1", above(world, "obstacle_1", 0.44, 0.09, 0.46))
    assert {f for f in facts(world, "On") if "obstacle_1" in f} == {
        "On(obstacle_1, shelf_level_1)",
        "On(obstacle_1, shelf)",
    }
    assert "Free(position_12)" not in facts(world, "Free")
    assert "Free(position_13)" in facts(world, "Free")


def test_a_brush_changes_no_fact(world: BulletWorld) -> None:
    before = world.observe()
    bench = world._bench
    bench.client.resetBaseVelocity(bench.bodies["object_2"], (0.06, 0, 0), (0, 0, 0))
    for _ in range(5):
        world.advance()
        assert world.observe() == before


def test_a_full_region_is_not_free() -> None:
    scene = load_scene("cargo_sorting")
    area = scene.place(AREA)
    small = replace(area, size_m=(0.12, 0.12), surface_m=(0.33, 0.40, 0.4))
    scene = replace(scene, places=tuple(small if p.id == AREA else p for p in scene.places))
    world = BulletWorld(scene)
    assert "Free(sorting_area)" not in facts(world, "Free")
    assert act(world, "pick", "object_2", "workbench").status is Status.SUCCESS
    assert act(world, "put_down", "object_2", AREA).reason == "no_free_buffer"
    world.close()


def cylinder(scene: Scene) -> Scene:
    x, y, z = scene.place(AREA).surface_m or (0, 0, 0)
    can = Body("can", "can", "object", "red", "cylinder", (0.05, 0.05, 0.08), pose=Pose((x, y, z + 0.04)))
    bar = Body("bar", "bar", "object", "blue", "box", (0.03, 0.09, 0.04), pose=Pose((x + 0.15, y, z + 0.02)))
    return replace(scene, objects=(can, bar), obstacles=())


def test_cylinders_and_bars() -> None:
    world = BulletWorld(cylinder(load_scene("cargo_sorting")))
    for o, slot in (("can", "position_13"), ("bar", "position_22")):
        assert act(world, "pick", o, AREA).status is Status.SUCCESS
        assert act(world, "place", o, slot).status is Status.SUCCESS
        assert f"On({o}, {slot})" in facts(world, "On")
    world.close()


def test_the_robot_may_stand_elsewhere() -> None:
    """The whole scene turned by a quarter and moved: nothing depends on the robot being at the origin."""
    scene = load_scene("cargo_sorting")

    def turned(xyz: tuple[float, float, float]) -> tuple[float, float, float]:
        return (1.0 - xyz[1], 0.5 + xyz[0], xyz[2])

    def swapped(size: tuple[float, ...]) -> tuple[float, ...]:
        return (size[1], size[0], *size[2:])

    scene = replace(
        scene,
        robot_xyz_m=turned(scene.robot_xyz_m),
        robot_yaw_rad=math.pi / 2,
        fixtures=tuple(replace(f, xyz_m=turned(f.xyz_m), size_m=swapped(f.size_m)) for f in scene.fixtures),
        places=tuple(
            replace(p, surface_m=turned(p.surface_m), size_m=swapped(p.size_m)) if p.surface_m else p
            for p in scene.places
        ),
        objects=tuple(
            replace(o, pose=Pose(turned(o.pose.xyz_m), o.pose.quat_xyzw)) if o.pose else o for o in scene.objects
        ),
    )
    world = BulletWorld(scene)
    assert len(facts(world, "Clear")) == 6
    for o, slot in (("object_1", "position_12"), ("object_6", "position_34")):
        assert act(world, "pick", o, AREA).status is Status.SUCCESS
        assert act(world, "place", o, slot).status is Status.SUCCESS
    assert act(world, "move_aside", "object_1", "position_12", AREA).status is Status.SUCCESS
    world.close()


# ---------------------------------------------------------------------------------- repeating, looking, silence


PROGRAM = """
import hashlib
from llmbt_ir.condition import ActionCall
from llmbt_ir.scene import load_scene
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_ir.condition import Condition
goals = (Condition("On", ("object_1", "position_12")), Condition("On", ("object_2", "position_13")))
w = BulletWorld(load_scene("cargo_sorting"), 3, (DisturbanceSpec("obstacle_at_place"),), goals)
digest = hashlib.sha256()
for action in (ActionCall("pick", ("object_1", "sorting_area")), ActionCall("place", ("object_1", "position_12"))):
    w.start(action)
    while w.advance().status == "RUNNING":
        digest.update(repr((sorted(map(str, w.observe())), w.objects())).encode())
w.close()
print(digest.hexdigest())
"""


def test_the_same_run_in_another_process_and_nothing_else_on_stdout() -> None:
    root = Path(__file__).resolve().parents[2]
    path = os.pathsep.join(str(root / p) for p in ("ir", "atl", "runtime"))
    outputs = {
        subprocess.run(
            [sys.executable, "-c", PROGRAM],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }
    assert len(outputs) == 1
    assert len(outputs.pop().strip()) == len(hashlib.sha256().hexdigest())


def test_a_picture_changes_nothing(world: BulletWorld, tmp_path: Path) -> None:
    before = world.snapshot()
    render_png(world, tmp_path / "now.png", 160, 120, DEFAULT_CAMERA)
    assert (tmp_path / "now.png").read_bytes().startswith(b"\x89PNG")
    assert world.snapshot() == before


def test_virtual_poses_are_what_the_physics_has(world: BulletWorld) -> None:
    real = world._bench.sensed.states["object_1"]
    guess = lying_at(world._bench.kinds["object_1"], real.xyz, 0.0)
    assert np.allclose(guess.extent.half, real.extent.half, atol=1e-3)
    assert Condition("Clear", ("object_1",)) in world.observe()
