"""Closed-form kinematics of a Panda whose hand points straight down.

With joints 3 and 5 at zero the arm is a planar two-link chain on a turntable, and every pose with a vertical hand has
one elbow-up solution. It depends on the pose alone, never on a seed or on history, so neighbouring poses have
neighbouring joints: straight paths stay straight and a plan is the same whenever it is made.

Frame: the robot's base, z up, metres. The tip is 105 mm below the hand's origin, between the finger pads. The yaw of
the hand is the direction in which the fingers open, known up to half a turn.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["JOINT_LIMITS", "MAX_REACH_M", "TipPose", "solve", "solve_one", "solve_pitched", "tip_of"]

Array = NDArray[np.float64]

_SHOULDER_M = 0.333
_UPPER_M, _FORE_M, _ELBOW_M = 0.316, 0.384, 0.0825
_WRIST_M = 0.088
_TOOL_M = 0.107 + 0.105
_L1, _L2 = math.hypot(_UPPER_M, _ELBOW_M), math.hypot(_FORE_M, _ELBOW_M)
_D1, _D2 = math.atan2(_ELBOW_M, _UPPER_M), math.atan2(_ELBOW_M, _FORE_M)

MAX_REACH_M = _WRIST_M + _L1 + _L2
"""No tip is further from the base's axis than this."""

JOINT_LIMITS = np.array(
    [
        [-2.8973, 2.8973],
        [-1.7628, 1.7628],
        [-2.8973, 2.8973],
        [-3.0718, -0.0698],
        [-2.8973, 2.8973],
        [-0.0175, 3.7525],
        [-2.8973, 2.8973],
    ]
)
"""Radians, joint by joint: the controller's soft limits."""

TipPose = tuple[float, float, float, float]
"""x, y, z of the tip and the direction in which the fingers open."""


def solve(x: Array, y: Array, z: Array, yaw: Array, theta: Array | None = None) -> Array:
    """Joint angles (N x 7) for tips with a vertical hand; rows of NaN where out of reach or of the joint limits.

    `theta` is joint 1 where the caller has unwrapped it; `yaw` is taken as given, no half-turn is removed.
    """
    turn = np.arctan2(y, x) if theta is None else theta
    wx = np.hypot(x, y) - _WRIST_M
    wz = z + _TOOL_M - _SHOULDER_M
    cos_bend = (wx * wx + wz * wz - _L1 * _L1 - _L2 * _L2) / (2 * _L1 * _L2)
    with np.errstate(invalid="ignore"):
        bend = np.arccos(cos_bend)
    upper = np.arctan2(wx, wz) - np.arctan2(_L2 * np.sin(bend), _L1 + _L2 * np.cos(bend))
    fore = upper + bend + _D2
    q = np.zeros((len(turn), 7))
    q[:, 0] = turn
    q[:, 1] = upper - _D1
    q[:, 3] = q[:, 1] - fore
    q[:, 5] = fore
    q[:, 6] = 0.75 * math.pi + turn - yaw
    bad = ~np.all((q >= JOINT_LIMITS[:, 0]) & (q <= JOINT_LIMITS[:, 1]), axis=1)
    q[bad] = np.nan
    return q


def solve_pitched(r: Array, z: Array, pitch: Array, theta: float) -> Array:
    """Joint angles (N x 7) for a hand that is pitched out of the vertical in the plane of the arm (positive: away from
    the base), the fingers opening across that plane; rows of NaN where out of reach or of the joint limits.

    `r` and `z` are the tip's, `theta` is joint 1. With a pitch of 0 it is `solve` for a yaw of theta + pi/2.
    """
    wx = r - _TOOL_M * np.sin(pitch) - _WRIST_M * np.cos(pitch)
    wz = z + _TOOL_M * np.cos(pitch) - _WRIST_M * np.sin(pitch)
    q = solve(wx + _WRIST_M, np.zeros_like(r), wz - _TOOL_M, np.full_like(r, math.pi / 2))
    q[:, 0] = theta
    q[:, 5] += pitch
    bad = ~np.all((q >= JOINT_LIMITS[:, 0]) & (q <= JOINT_LIMITS[:, 1]), axis=1)
    q[bad] = np.nan
    return q


def solve_one(pose: TipPose) -> Array | None:
    """Joint angles for one tip pose, or None. Of the yaws that differ by half turns the most central is taken."""
    x, y, z, yaw = pose
    q = solve(*(np.array([v]) for v in (x, y, z, central_yaw(x, y, yaw))))[0]
    return None if np.isnan(q[0]) else q


def central_yaw(x: float, y: float, yaw: float) -> float:
    """The yaw, up to half a turn, that leaves joint 7 nearest to its middle for a tip above (x, y)."""
    middle = 0.5 * math.pi + math.atan2(y, x)  # joint 7 at pi/4
    return yaw + math.pi * round((middle - yaw) / math.pi)


def tip_of(q: Array) -> TipPose:
    """Where the tip is for joint angles of the family that `solve` gives; other joints are ignored."""
    upper, fore = q[1] + _D1, q[1] - q[3] - _D2
    r = _WRIST_M + _L1 * math.sin(upper) + _L2 * math.sin(fore)
    z = _SHOULDER_M - _TOOL_M + _L1 * math.cos(upper) + _L2 * math.cos(fore)
    return (r * math.cos(q[0]), r * math.sin(q[0]), z, 0.75 * math.pi + q[0] - q[6])
