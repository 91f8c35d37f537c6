"""The closed-form kinematics against pybullet's own."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from llmbt_ir.scene import load_scene
from llmbt_runtime.bullet.client import BulletClient
from llmbt_runtime.bullet.kinematics import JOINT_LIMITS, solve_one, tip_of
from llmbt_runtime.bullet.motion import brake, plan_line
from llmbt_runtime.bullet.robot import load_robot


def test_agrees_with_the_model_of_the_robot() -> None:
    client = BulletClient()
    scene = replace(load_scene("cargo_sorting"), robot_xyz_m=(0.0, 0.0, 0.0))
    loaded = load_robot(client, scene, visible=False)
    robot, joints = loaded.body, loaded.joints
    rng = np.random.default_rng(0)
    reached = 0
    for _ in range(300):
        pose = tuple(float(v) for v in rng.uniform((-0.1, -0.7, 0.0, -3.0), (0.75, 0.7, 0.4, 3.0)))
        q = solve_one(pose)  # type: ignore[arg-type]
        if q is None:
            continue
        reached += 1
        assert np.all((q >= JOINT_LIMITS[:, 0]) & (q <= JOINT_LIMITS[:, 1]))
        for j, value in enumerate(q.tolist()):
            client.resetJointState(robot, joints.arm[j], value)
        state = client.getLinkState(robot, joints.tip, computeForwardKinematics=1)
        rotation = np.array(client.getMatrixFromQuaternion(state[5])).reshape(3, 3)
        assert np.allclose(state[4], pose[:3], atol=1e-6)
        assert np.allclose(tip_of(q)[:3], pose[:3], atol=1e-9)
        assert math.isclose(rotation[2, 2], -1.0, abs_tol=1e-5)  # the hand points down
        fingers = math.atan2(rotation[1, 1], rotation[0, 1])
        assert abs(math.sin(fingers - pose[3])) < 1e-5
    client.close()
    assert reached > 200


def test_a_line_starts_and_ends_at_rest_and_keeps_to_its_height() -> None:
    start, end = (0.4, 0.1, 0.3, 1.5), (0.2, 0.5, 0.3, 2.4)
    plan = plan_line(start, end, 1.5, 5.0)
    assert plan is not None
    assert np.abs(plan.dq).max() < 1.6
    assert not plan.dq[-1].any()
    assert all(abs(tip_of(q)[2] - 0.3) < 1e-6 for q in plan.q)
    assert np.allclose(tip_of(plan.q[-1])[:2], end[:2])


def test_out_of_reach_is_no_plan() -> None:
    assert solve_one((0.9, 0.0, 0.1, 1.5)) is None
    assert plan_line((0.4, 0.0, 0.2, 1.5), (0.95, 0.0, 0.2, 1.5), 1.0, 4.0) is None


def test_braking_stays_on_the_path_and_stops() -> None:
    plan = plan_line((0.4, 0.1, 0.3, 1.5), (0.2, 0.5, 0.3, 2.4), 1.5, 5.0)
    assert plan is not None
    stop = brake(plan, len(plan.q) // 2)
    assert not stop.dq[-1].any()
    assert all(abs(tip_of(q)[2] - 0.3) < 1e-4 for q in stop.q)
    speeds = np.abs(stop.dq).max(axis=1)
    assert speeds[0] > speeds[len(speeds) // 2] > speeds[-2]
