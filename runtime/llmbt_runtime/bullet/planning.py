"""Motions for where lifting, swinging over and lowering does not do: RRTConnect (Kuffner and LaValle 2000) of OMPL.

It plans for a hand that stays vertical, so that what is carried stays upright: in the turn, radius and height of the
tip and the turn of the fingers, four dimensions instead of seven. Bounded by iterations and seeded for each call, so
that a trial repeats; OMPL is imported when it is needed first.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from llmbt_runtime.bullet.client import quiet_stdout
from llmbt_runtime.bullet.kinematics import TipPose, central_yaw
from llmbt_runtime.bullet.motion import Trajectory, plan_line

__all__ = ["plan_tip"]

Free = Callable[[Trajectory], bool]
"""Whether a trajectory meets nothing."""

_ITERATIONS = 4000
_SEED = 1
_RANGE = 0.25
_RESOLUTION = 0.01
_LOW, _HIGH = (-2.85, 0.20, -0.35, -2.6), (2.85, 0.80, 0.72, 2.6)
_SCALE = (0.6, 1.0, 1.0, 0.12)
"""Turn, radius, height, fingers: what of each counts as a metre."""
_CHECK_SPEED = (1.0, 4.0)


def plan_tip(start: TipPose, end: TipPose, free_at: Callable[[TipPose], bool], free: Free) -> list[TipPose] | None:
    """The corners of a way of the tip from one pose to another, without the start; None where none was found.

    `free_at` says whether the arm, and what it holds, meets nothing at a pose; `free` the same of a trajectory.
    """
    if not (free_at(start) and free_at(end)):
        return None
    goal = (*end[:3], central_yaw(end[0], end[1], end[3]))
    corners = _search(_to_space(start), _to_space(goal), lambda v: free_at(_to_tip(v)))
    return _straightened([start, *map(_to_tip, corners[1:-1]), goal], free) if corners else None


def _to_space(tip: TipPose) -> list[float]:
    theta = math.atan2(tip[1], tip[0])
    point = (theta, math.hypot(tip[0], tip[1]), tip[2], tip[3] - theta - math.pi / 2)
    return [v * s for v, s in zip(point, _SCALE, strict=True)]


def _to_tip(point: list[float]) -> TipPose:
    theta, r, z, fingers = (v / s for v, s in zip(point, _SCALE, strict=True))
    return r * math.cos(theta), r * math.sin(theta), z, fingers + theta + math.pi / 2


def _search(start: list[float], goal: list[float], free: Callable[[list[float]], bool]) -> list[list[float]]:
    """The corners that RRTConnect finds, none where it finds no way within its iterations."""
    with quiet_stdout():
        from ompl import base, geometric, util

        util.setLogLevel(util.LOG_NONE)
        util.RNG.setSeed(_SEED)
    space = base.RealVectorStateSpace(4)
    bounds = base.RealVectorBounds(4)
    for i in range(4):
        bounds.setLow(i, min(_LOW[i] * _SCALE[i], start[i], goal[i]))
        bounds.setHigh(i, max(_HIGH[i] * _SCALE[i], start[i], goal[i]))
    space.setBounds(bounds)
    information = base.SpaceInformation(space)
    information.setStateValidityChecker(lambda state: free(list(state[0:4])))
    information.setStateValidityCheckingResolution(_RESOLUTION)
    information.setup()
    problem = base.ProblemDefinition(information)
    ends = [space.allocState(), space.allocState()]
    for state, values in zip(ends, (start, goal), strict=True):
        for i, value in enumerate(values):
            state[i] = value
    problem.setStartAndGoalStates(*ends)
    planner = geometric.RRTConnect(information)
    planner.setRange(_RANGE)
    planner.setProblemDefinition(problem)
    planner.setup()
    asked = 0

    def enough() -> bool:
        nonlocal asked
        asked += 1
        return asked > _ITERATIONS

    with quiet_stdout():
        planner.solve(base.PlannerTerminationCondition(enough))
    path = problem.getSolutionPath() if problem.hasExactSolution() else None
    return [list(state[0:4]) for state in path.getStates()] if path is not None else []


def _straightened(way: list[TipPose], free: Free) -> list[TipPose] | None:
    """From each corner on to the furthest that a single motion reaches without meeting anything."""
    found, at = list[TipPose](), 0
    while at < len(way) - 1:
        for to in range(len(way) - 1, at, -1):
            motion = plan_line(way[at], way[to], *_CHECK_SPEED)
            if motion is not None and free(motion):
                break
        else:
            return None
        found.append(way[to])
        at = to
    return found
