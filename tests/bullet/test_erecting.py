"""Cylinders that lie are set upright by a hand that is pitched back; its kinematics against pybullet's own."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from llmbt_ir.condition import ActionCall
from llmbt_ir.geometry import Pose
from llmbt_ir.scene import Scene, load_scene
from llmbt_runtime.bullet.client import BulletClient
from llmbt_runtime.bullet.kinematics import JOINT_LIMITS, solve, solve_pitched
from llmbt_runtime.bullet.robot import load_robot
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.world import ActionReport, Status


def test_the_pitched_hand_agrees_with_the_model_of_the_robot() -> None:
    client = BulletClient()
    scene = replace(load_scene("cargo_sorting"), robot_xyz_m=(0.0, 0.0, 0.0))
    robot = load_robot(client, scene, visible=False)
    rng = np.random.default_rng(0)
    reached = 0
    for _ in range(300):
        r, z, pitch, theta = rng.uniform((0.2, 0.0, -1.5, -2.0), (0.7, 0.5, 0.5, 2.0)).tolist()
        q = solve_pitched(*(np.array([v]) for v in (r, z, pitch)), theta)[0]
        if np.isnan(q[0]):
            continue
        reached += 1
        assert np.all((q >= JOINT_LIMITS[:, 0]) & (q <= JOINT_LIMITS[:, 1]))
        for j, value in zip(robot.joints.arm, q.tolist(), strict=True):
            client.resetJointState(robot.body, j, value)
        state = client.getLinkState(robot.body, robot.joints.tip, computeForwardKinematics=1)
        assert np.allclose(state[4], (r * math.cos(theta), r * math.sin(theta), z), atol=1e-6)
        rotation = np.array(client.getMatrixFromQuaternion(state[5])).reshape(3, 3)
        out = math.sin(pitch)
        assert np.allclose(rotation[:, 2], (out * math.cos(theta), out * math.sin(theta), -math.cos(pitch)), atol=1e-5)
        assert abs(rotation[2, 1]) < 1e-5  # the fingers open level
    client.close()
    assert reached > 100


def test_without_a_pitch_it_is_the_vertical_hand() -> None:
    r, z = np.linspace(0.3, 0.7, 20), np.linspace(0.0, 0.3, 20)
    upright = solve(r, 0 * r, z, np.full(20, math.pi / 2), np.full(20, 0.0))
    assert np.allclose(solve_pitched(r, z, 0 * r, 0.0), upright, equal_nan=True)


def act(world: BulletWorld, name: str, *args: str) -> ActionReport:
    world.start(ActionCall(name, args))
    while (report := world.advance()).status is Status.RUNNING:
        pass
    return report


def lay(world: BulletWorld, id_: str, x: float, y: float, surface: float, yaw: float) -> None:
    """A cylinder on its side, its axis along `yaw`."""
    h, c, s = math.sqrt(0.5), math.cos(yaw / 2), math.sin(yaw / 2)
    radius = world._bench.kinds[id_].size_m[0] / 2
    world._bench.put(id_, Pose((x, y, surface + radius + 0.001), (-s * h, c * h, s * h, c * h)))
    world.settle(0.8)


def with_a_tin() -> Scene:
    scene = load_scene("cargo_sorting")
    return replace(
        scene,
        objects=tuple(
            replace(o, shape="cylinder", size_m=(0.045, 0.045, 0.06)) if o.id == "object_4" else o
            for o in scene.objects
        ),
    )


def test_a_tin_that_fell_over_on_the_workbench() -> None:
    world = BulletWorld(with_a_tin())
    for k in range(4):
        world.reset()
        lay(world, "object_4", 0.10, 0.45 - 0.02 * k, 0.4, 0.8 * k)
        assert "Fallen(object_4)" in {str(f) for f in world.observe()}
        assert act(world, "recover", "object_4", "sorting_area") == ActionReport(Status.SUCCESS)
        assert "On(object_4, sorting_area)" in {str(f) for f in world.truth()}
    world.close()


@pytest.mark.parametrize("thing", ["coke", "water"])
def test_a_drink_that_lies_on_the_floor(thing: str) -> None:
    world = BulletWorld(load_scene("household"))
    for k in range(2):
        world.reset()
        lay(world, thing, 0.3 + 0.2 * k, 0.8 - 0.3 * k, 0.0, 1.1 * k)
        assert act(world, "recover", thing, "user") == ActionReport(Status.SUCCESS)
        assert {f"On({thing}, user)", "HandEmpty"} <= {str(f) for f in world.truth()}
    world.close()
