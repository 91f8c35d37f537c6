"""The Panda in the physics: joints that follow a trajectory, fingers that open and close."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from llmbt_runtime.bullet.client import DATA_PATH, BulletClient, quiet_stdout
from llmbt_runtime.bullet.kinematics import TipPose, tip_of
from llmbt_runtime.bullet.motion import CONTROL_HZ, Trajectory, brake, hold

__all__ = ["FINGERS", "HAND", "MAX_OPENING_M", "PHYSICS_HZ", "TIP", "Panda", "load_panda"]

Array = NDArray[np.float64]

PHYSICS_HZ = 240
ARM = tuple(range(7))
HAND = 8
FINGERS = (9, 10)
TIP = 11
MAX_OPENING_M = 0.08
REST_Q = np.array([0.4, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
FINGER_FORCE_N = 40.0
_FINGER_SPEED_M_S = 0.15
_ARM_FORCE = (87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0)
_STRONGER = 4.0
"""The motors of joints 5-7 are given some room: position control in Bullet does not compensate gravity."""


def load_panda(client: BulletClient, xyz_m: tuple[float, float, float], yaw_rad: float, *, visible: bool) -> int:
    """Load the robot with its base fixed; without its visual meshes it takes a tenth of the time."""
    flags = 0 if visible else client.URDF_IGNORE_VISUAL_SHAPES
    with quiet_stdout():
        body: int = client.loadURDF(
            f"{DATA_PATH}/franka_panda/panda.urdf",
            xyz_m,
            client.getQuaternionFromEuler((0, 0, yaw_rad)),
            useFixedBase=True,
            flags=flags,
        )
    return body


class Panda:
    """Follows one trajectory at a time and keeps the fingers at an opening, both by position control."""

    def __init__(self, client: BulletClient, xyz_m: tuple[float, float, float], yaw_rad: float) -> None:
        self._client = client
        self.body = load_panda(client, xyz_m, yaw_rad, visible=False)
        for j, value in enumerate(REST_Q):
            client.resetJointState(self.body, j, value)
        for j in FINGERS:
            client.resetJointState(self.body, j, MAX_OPENING_M / 2)
        gear = client.createConstraint(
            self.body, FINGERS[0], self.body, FINGERS[1], client.JOINT_GEAR, (1, 0, 0), (0, 0, 0), (0, 0, 0)
        )
        client.changeConstraint(gear, gearRatio=-1, erp=0.1, maxForce=50)
        self._forces = [f * (_STRONGER if f < 20 else 1.0) for f in _ARM_FORCE]
        self._plan = hold(REST_Q)
        self._q: list[list[float]] = self._plan.q.tolist()
        self._dq: list[list[float]] = self._plan.dq.tolist()
        self._row = 0
        self.opening_m = MAX_OPENING_M
        self._command_fingers(MAX_OPENING_M)

    def follow(self, trajectory: Trajectory) -> None:
        """Replace what is being followed, from the next control step on."""
        self._plan = trajectory
        self._q, self._dq = trajectory.q.tolist(), trajectory.dq.tolist()
        self._row = 0

    def brake(self) -> None:
        """Come to rest on the path, within a quarter of a second: a thing in the hand stays there."""
        if not self.arrived:
            self.follow(brake(self._plan, self._row))

    @property
    def arrived(self) -> bool:
        """Whether the trajectory has been commanded to its end."""
        return self._row >= len(self._q)

    @property
    def progress(self) -> float:
        """The part of the trajectory that has been commanded."""
        return self._row / len(self._q)

    @property
    def commanded(self) -> Array:
        """The joint angles last asked for."""
        row: Array = self._plan.q[min(max(self._row - 1, 0), len(self._q) - 1)]
        return row

    def command(self) -> None:
        """Send the next row of the trajectory to the joints; to be called at CONTROL_HZ."""
        if self._row >= len(self._q):
            return
        self._client.setJointMotorControlArray(
            self.body,
            ARM,
            self._client.POSITION_CONTROL,
            targetPositions=self._q[self._row],
            targetVelocities=self._dq[self._row],
            forces=self._forces,
            positionGains=_GAINS,
            velocityGains=_ONES,
        )
        self._row += 1

    def measured(self) -> Array:
        """The joint angles as they are."""
        return np.array([s[0] for s in self._client.getJointStates(self.body, ARM)])

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
        for j in FINGERS:
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
        return float(sum(s[0] for s in self._client.getJointStates(self.body, FINGERS)))


_GAINS = [0.5] * 7
_ONES = [1.0] * 7
assert PHYSICS_HZ % CONTROL_HZ == 0
assert math.isclose(MAX_OPENING_M, 0.08)
