"""The robot in the physics: a Panda whose joints follow a trajectory and whose fingers open and close.

It is bolted down, or stands on a platform that drives (joints x, y and yaw, under position control).
The platform stands for one on wheels that can go any way; it touches the floor with nothing.
"""

from __future__ import annotations

import math
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.scene import PLATFORM_RADIUS_M, RobotModel, Scene
from llmbt_runtime.bullet.client import DATA_PATH, BulletClient, quiet_stdout
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.kinematics import TipPose, tip_of
from llmbt_runtime.bullet.motion import CONTROL_HZ, Follower, hold

__all__ = ["MAX_OPENING_M", "PHYSICS_HZ", "Base", "Joints", "Loaded", "Panda", "load_robot"]

Array = NDArray[np.float64]

PHYSICS_HZ = 240
MAX_OPENING_M = 0.08
REST_Q = np.array([0.4, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
FINGER_FORCE_N = 40.0
_FINGER_SPEED_M_S = 0.15
_ARM_FORCE = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)
_STRONGER = 4.0
"""The motors of joints 5-7 are given some room: position control in Bullet does not compensate gravity."""
_FINGER_BOXES = ((0.0076, 0.0449, "0.0175 0.0152 0.0175"), (0.0186, 0.0185, "0.021 0.015 0.037"))
"""Of the left finger, in its link's frame: y and z of the middle, and the size. The pad, and what carries it."""
_BASE_FORCE_N = 5000.0
_PLATFORM_KG = 40.0
_PLATFORM_OFF_FLOOR_M = 0.01
_PLATFORM_BELOW_ARM_M = 0.01


@dataclass(frozen=True, slots=True)
class Joints:
    """The numbers of a model's joints and links in pybullet; `base` is empty where the robot is bolted down."""

    base: tuple[int, ...]
    arm: tuple[int, ...]
    hand: int
    fingers: tuple[int, int]
    tip: int

    @property
    def first_moving_link(self) -> int:
        """From this link on the arm may touch things; what is below belongs to its stand."""
        return self.arm[0] + 2


def _joints(before: int, base: tuple[int, ...]) -> Joints:
    return Joints(base, tuple(range(before, before + 7)), before + 8, (before + 9, before + 10), before + 11)


_PANDA, _MOBILE_PANDA = _joints(0, ()), _joints(4, (0, 1, 2))


@dataclass(frozen=True, slots=True)
class Loaded:
    """A robot in a pybullet client."""

    body: int
    joints: Joints

    def stand_at(self, client: BulletClient, at: BasePose) -> None:
        """Put the base somewhere, without physics. Nothing happens to a robot that is bolted down."""
        for joint, value in zip(self.joints.base, (at.x_m, at.y_m, at.yaw_rad), strict=False):
            client.resetJointState(self.body, joint, value)


def load_robot(client: BulletClient, scene: Scene, *, visible: bool) -> Loaded:
    """Load a scene's robot, standing where the scene says; without its visual meshes it takes a tenth of the time."""
    flags = 0 if visible else client.URDF_IGNORE_VISUAL_SHAPES
    panda = _panda_urdf()
    if scene.robot is RobotModel.PANDA:
        quat = client.getQuaternionFromEuler((0, 0, scene.robot_yaw_rad))
        return Loaded(_load(client, panda, scene.robot_xyz_m, quat, flags), _PANDA)
    height = scene.robot_xyz_m[2]
    urdf = _mobile_urdf(panda, height)
    robot = Loaded(_load(client, urdf, (0.0, 0.0, height), (0, 0, 0, 1), flags), _MOBILE_PANDA)
    robot.stand_at(client, BasePose.of_scene(scene))
    return robot


def _load(client: BulletClient, urdf: str, xyz_m: object, quat: object, flags: int) -> int:
    with tempfile.TemporaryDirectory() as folder, quiet_stdout():
        path = Path(folder, "robot.urdf")
        path.write_text(urdf, encoding="utf-8")
        body: int = client.loadURDF(str(path), xyz_m, quat, useFixedBase=True, flags=flags)
    return body


def _panda_urdf() -> str:
    """The model that comes with pybullet, the fingers' collision meshes replaced by boxes: two boxes touch in up to
    eight points, a mesh and a box now and then in one, about which a long thing turns in the hand."""
    text = Path(DATA_PATH, "franka_panda", "panda.urdf").read_text(encoding="utf-8")
    mesh = re.compile(r"<collision>(?:(?!</collision>).)*collision/finger\.obj.*?</collision>", re.DOTALL)
    text = mesh.sub("".join(_finger_box(1, *box) for box in _FINGER_BOXES), text, count=1)
    text = mesh.sub("".join(_finger_box(-1, *box) for box in _FINGER_BOXES), text, count=1)
    return text.replace("package://meshes", f"{DATA_PATH}/franka_panda/meshes")


def _finger_box(side: int, y_m: float, z_m: float, size: str) -> str:
    return f'<collision><origin xyz="0 {side * y_m} {z_m}"/><geometry><box size="{size}"/></geometry></collision>'


def _mobile_urdf(panda: str, height_m: float) -> str:
    """The Panda's model with three joints and a platform before its first link."""
    length = height_m - _PLATFORM_OFF_FLOOR_M - _PLATFORM_BELOW_ARM_M
    shape = (
        f'<origin xyz="0 0 {-_PLATFORM_BELOW_ARM_M - length / 2:.4f}"/>'
        f'<geometry><cylinder radius="{PLATFORM_RADIUS_M}" length="{length:.4f}"/></geometry>'
    )
    grey = '<material name="platform_grey"><color rgba="0.35 0.37 0.40 1"/></material>'

    def link(name: str, mass_kg: float, inside: str = "") -> str:
        i = f"{0.03 * mass_kg:.4f}"
        inertia = f'<inertia ixx="{i}" ixy="0" ixz="0" iyy="{i}" iyz="0" izz="{i}"/>'
        return f'<link name="{name}"><inertial><mass value="{mass_kg}"/>{inertia}</inertial>{inside}</link>'

    def joint(name: str, kind: str, parent: str, child: str, axis: str) -> str:
        limit = '<limit lower="-100" upper="100" effort="100000" velocity="10"/>' if kind != "fixed" else ""
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<axis xyz="{axis}"/>{limit}</joint>'
        )

    stand = (
        link("floor", 0.0)
        + link("base_x", 1.0)
        + link("base_y", 1.0)
        + link("platform", _PLATFORM_KG, f"<visual>{shape}{grey}</visual><collision>{shape}</collision>")
        + joint("base_joint_x", "prismatic", "floor", "base_x", "1 0 0")
        + joint("base_joint_y", "prismatic", "base_x", "base_y", "0 1 0")
        + joint("base_joint_yaw", "continuous", "base_y", "platform", "0 0 1")
        + joint("mount", "fixed", "platform", "panda_link0", "0 0 1")
    )
    at = panda.index('<link name="panda_link0">')
    return panda[:at] + stand + panda[at:]


class Panda:
    """Follows one trajectory at a time and keeps the fingers at an opening, both by position control."""

    def __init__(self, client: BulletClient, robot: Loaded) -> None:
        self._client = client
        self.body, self.joints = robot.body, robot.joints
        for j, value in zip(self.joints.arm, REST_Q, strict=True):
            client.resetJointState(self.body, j, value)
        for j in self.joints.fingers:
            client.resetJointState(self.body, j, MAX_OPENING_M / 2)
        left, right = self.joints.fingers
        gear = client.createConstraint(
            self.body, left, self.body, right, client.JOINT_GEAR, (1, 0, 0), (0, 0, 0), (0, 0, 0)
        )
        client.changeConstraint(gear, gearRatio=-1, erp=0.1, maxForce=50)
        self._forces = [f * (_STRONGER if f < 20 else 1.0) for f in _ARM_FORCE]
        self.follower = Follower(hold(REST_Q))
        self.opening_m = MAX_OPENING_M
        self._command_fingers(MAX_OPENING_M)
        self.follow = self.follower.follow
        self.brake = self.follower.brake

    @property
    def arrived(self) -> bool:
        """Whether the trajectory has been commanded to its end."""
        return self.follower.arrived

    @property
    def progress(self) -> float:
        """The part of the trajectory that has been commanded."""
        return self.follower.progress

    @property
    def commanded(self) -> Array:
        """The joint angles last asked for."""
        return self.follower.commanded

    def command(self) -> None:
        """Send the next row of the trajectory to the joints; to be called at CONTROL_HZ."""
        row = self.follower.next_row()
        if row is None:
            return
        self._client.setJointMotorControlArray(
            self.body,
            self.joints.arm,
            self._client.POSITION_CONTROL,
            targetPositions=row[0],
            targetVelocities=row[1],
            forces=self._forces,
            positionGains=_GAINS,
            velocityGains=_ONES,
        )

    def measured(self) -> Array:
        """The joint angles as they are."""
        return np.array([s[0] for s in self._client.getJointStates(self.body, self.joints.arm)])

    def all_joints(self) -> tuple[float, ...]:
        """Every joint of the model, the fixed ones too, in the model's order."""
        n = self._client.getNumJoints(self.body)
        return tuple(s[0] for s in self._client.getJointStates(self.body, range(n)))

    def tracking_error(self) -> float:
        """The largest difference between a joint and what was asked of it, in radians."""
        return float(np.abs(self.measured() - self.commanded).max())

    def tip(self) -> TipPose:
        """Where the tip is asked to be, in the frame of the base."""
        return tip_of(self.commanded)

    def grip(self, opening_m: float) -> None:
        """Ask the fingers for an opening; 0 closes them on whatever is between them, with FINGER_FORCE_N."""
        self.opening_m = opening_m
        self._command_fingers(opening_m)

    def slip(self) -> None:
        """The fingers open, though that is not what they were asked for; `grip` puts an end to it."""
        self._command_fingers(self.finger_gap() + 0.03, speed_m_s=0.5)

    def _command_fingers(self, opening_m: float, speed_m_s: float = _FINGER_SPEED_M_S) -> None:
        for j in self.joints.fingers:
            self._client.setJointMotorControl2(
                self.body,
                j,
                self._client.POSITION_CONTROL,
                targetPosition=opening_m / 2,
                force=FINGER_FORCE_N,
                maxVelocity=speed_m_s,
            )

    def finger_gap(self) -> float:
        """How far the fingers are open, in metres."""
        return float(sum(s[0] for s in self._client.getJointStates(self.body, self.joints.fingers)))


class Base:
    """The platform: follows one trajectory at a time. One that is bolted down has always arrived, where it stands."""

    def __init__(self, client: BulletClient, robot: Loaded, at: BasePose) -> None:
        self._client, self._body, self._joints = client, robot.body, robot.joints.base
        self._at = at
        self.follower = Follower(hold(np.array([at.x_m, at.y_m, at.yaw_rad])))
        self.follow = self.follower.follow
        self.brake = self.follower.brake

    @property
    def arrived(self) -> bool:
        """Whether the trajectory has been commanded to its end."""
        return not self._joints or self.follower.arrived

    @property
    def progress(self) -> float:
        """The part of the trajectory that has been commanded."""
        return self.follower.progress

    @property
    def pose(self) -> BasePose:
        """Where it is asked to be."""
        if not self._joints:
            return self._at
        x, y, yaw = self.follower.commanded.tolist()
        return BasePose(x, y, self._at.z_m, yaw)

    def command(self) -> None:
        """Send the next row of the trajectory; to be called at CONTROL_HZ."""
        row = self.follower.next_row() if self._joints else None
        if row is None:
            return
        self._client.setJointMotorControlArray(
            self._body,
            self._joints,
            self._client.POSITION_CONTROL,
            targetPositions=row[0],
            targetVelocities=row[1],
            forces=_BASE_FORCES,
            positionGains=_BASE_GAINS,
            velocityGains=_BASE_ONES,
        )

    def measured(self) -> BasePose:
        """Where it is."""
        if not self._joints:
            return self._at
        x, y, yaw = (s[0] for s in self._client.getJointStates(self._body, self._joints))
        return BasePose(x, y, self._at.z_m, yaw)


_GAINS, _ONES = [0.5] * 7, [1.0] * 7
_BASE_GAINS, _BASE_ONES, _BASE_FORCES = [0.5] * 3, [1.0] * 3, [_BASE_FORCE_N] * 3
assert PHYSICS_HZ % CONTROL_HZ == 0
assert math.isclose(MAX_OPENING_M, 0.08)
