"""Paths of the tip and the joint trajectories that follow them.

A path is a line in cylinder coordinates about the robot's base (turn, radius, height, yaw of the fingers), so that the
arm swings round its base instead of cutting through it. Frame: the robot's base; metres, radians.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llmbt_runtime.bullet.kinematics import TipPose, solve, solve_pitched

__all__ = ["CONTROL_HZ", "Follower", "Trajectory", "brake", "hold", "plan_line", "plan_pitched", "straight"]

Array = NDArray[np.float64]

CONTROL_HZ = 120
_SAMPLES = 48
_PEAK_SPEED, _PEAK_ACCELERATION = 1.875, 5.7735
"""Of the quintic that goes from 0 to 1 in unit time, at rest at both ends."""


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Positions and speeds of N joints at CONTROL_HZ, a row each. The last row is at rest."""

    q: Array
    dq: Array

    @property
    def duration_s(self) -> float:
        """How long it lasts."""
        return len(self.q) / CONTROL_HZ


def hold(q: Array) -> Trajectory:
    """Stay."""
    return Trajectory(q[None, :].copy(), np.zeros((1, len(q))))


def _interpolate(start: TipPose, end: TipPose, s: Array) -> Array:
    """Joints along the path from one tip pose to the other, at fractions `s`; yaw runs as the numbers say."""
    th0, th1 = math.atan2(start[1], start[0]), math.atan2(end[1], end[0])
    r0, r1 = math.hypot(start[0], start[1]), math.hypot(end[0], end[1])
    theta = th0 + s * (th1 - th0)
    if abs(th1 - th0) < 0.35:  # nearby: a straight line
        x = start[0] + s * (end[0] - start[0])
        y = start[1] + s * (end[1] - start[1])
        theta = np.arctan2(y, x)
    else:
        r = r0 + s * (r1 - r0)
        x, y = r * np.cos(theta), r * np.sin(theta)
    z = start[2] + s * (end[2] - start[2])
    yaw = start[3] + s * (end[3] - start[3])
    return solve(x, y, z, yaw, theta)


def plan_line(start: TipPose, end: TipPose, speed_rad_s: float, acceleration_rad_s2: float) -> Trajectory | None:
    """The trajectory along a line in cylinder coordinates, at rest at both ends; None where a point is out of reach.

    The duration is the shortest for which no joint is faster or accelerates more than asked for.
    """
    return _timed(lambda s: _interpolate(start, end, s), speed_rad_s, acceleration_rad_s2)


def plan_pitched(
    theta: float,
    start: tuple[float, float, float],
    end: tuple[float, float, float],
    speed_rad_s: float,
    acceleration_rad_s2: float,
) -> Trajectory | None:
    """As `plan_line`, in the plane of the arm: from one radius, height and pitch of the hand to another."""

    def at(s: Array) -> Array:
        r, z, pitch = (a + s * (b - a) for a, b in zip(start, end, strict=True))
        return solve_pitched(r, z, pitch, theta)

    return _timed(at, speed_rad_s, acceleration_rad_s2)


def _timed(path_at: Callable[[Array], Array], speed_rad_s: float, acceleration_rad_s2: float) -> Trajectory | None:
    s = np.linspace(0.0, 1.0, _SAMPLES)
    q = path_at(s)
    if np.isnan(q).any():
        return None
    slope = np.gradient(q, s, axis=0)
    curve = np.gradient(slope, s, axis=0)
    reach = float(np.abs(slope).max())
    if reach < 1e-6:
        return hold(q[-1])
    seconds = max(
        _PEAK_SPEED * reach / speed_rad_s,
        math.sqrt((_PEAK_ACCELERATION * reach + _PEAK_SPEED**2 * float(np.abs(curve).max())) / acceleration_rad_s2),
        0.1,
    )
    n = math.ceil(seconds * CONTROL_HZ)
    t = np.arange(1, n + 1) / n
    along = t**3 * (10 - 15 * t + 6 * t * t)
    path = path_at(along)
    dq = np.gradient(np.vstack([q[:1], path]), 1 / CONTROL_HZ, axis=0)[1:]
    dq[-1] = 0.0
    return Trajectory(path, dq)


def brake(trajectory: Trajectory, at: int, seconds: float = 0.25) -> Trajectory:
    """Come to rest on the path of a trajectory whose next row is `at`, the speed falling evenly to zero."""
    n = max(1, math.ceil(seconds * CONTROL_HZ))
    left = len(trajectory.q) - at
    if left <= 1:
        return hold(trajectory.q[-1])
    t = np.arange(1, n + 1) / n
    rows = np.minimum(at + n * (t - t * t / 2), len(trajectory.q) - 1)
    low = np.floor(rows).astype(int)
    high = np.minimum(low + 1, len(trajectory.q) - 1)
    part = (rows - low)[:, None]
    q = (1 - part) * trajectory.q[low] + part * trajectory.q[high]
    dq = np.gradient(np.vstack([trajectory.q[at - 1 if at else 0][None], q]), 1 / CONTROL_HZ, axis=0)[1:]
    dq[-1] = 0.0
    return Trajectory(q, dq)


def straight(start: Array, end: Array, seconds: float) -> Trajectory:
    """Straight from one set of positions to another, at rest at both ends."""
    n = max(1, math.ceil(seconds * CONTROL_HZ))
    t = np.arange(1, n + 1)[:, None] / n
    along = t**3 * (10 - 15 * t + 6 * t * t)
    slope = 30 * t * t * (1 - t) ** 2 / (n / CONTROL_HZ)
    return Trajectory(start + along * (end - start), slope * (end - start))


class Follower:
    """Hands out a trajectory row by row."""

    def __init__(self, plan: Trajectory) -> None:
        self.follow(plan)

    def follow(self, trajectory: Trajectory) -> None:
        """Replace what is being followed, from the next control step on."""
        self._plan = trajectory
        self._q: list[list[float]] = trajectory.q.tolist()
        self._dq: list[list[float]] = trajectory.dq.tolist()
        self._row = 0

    def brake(self) -> None:
        """Come to rest on the path, within a quarter of a second: a thing in the hand stays there."""
        if not self.arrived:
            self.follow(brake(self._plan, self._row))

    @property
    def arrived(self) -> bool:
        """Whether the trajectory has been handed out to its end."""
        return self._row >= len(self._q)

    @property
    def progress(self) -> float:
        """The part of the trajectory that has been handed out."""
        return self._row / len(self._q)

    @property
    def commanded(self) -> Array:
        """The row handed out last."""
        row: Array = self._plan.q[min(max(self._row - 1, 0), len(self._q) - 1)]
        return row

    def next_row(self) -> tuple[list[float], list[float]] | None:
        """The next positions and speeds; None at the end."""
        if self._row >= len(self._q):
            return None
        self._row += 1
        return self._q[self._row - 1], self._dq[self._row - 1]
