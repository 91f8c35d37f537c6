"""Ways to take a thing with a vertical hand, and where the hand must be to let it go. Pure."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from llmbt_ir.scene import MAX_GRASP_M, Body
from llmbt_runtime.bullet.bodies import Axes, BodyState, at_rest
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.kinematics import TipPose, central_yaw
from llmbt_runtime.bullet.robot import MAX_OPENING_M

__all__ = ["FINGER_BELOW_TIP_M", "Carried", "Grasp", "Verdict", "grasps_of", "held_state", "put_down_state", "tip_for"]

FINGER_BELOW_TIP_M = 0.0115
_GRASP_DEPTH_M = 0.03
_HIGHER_M, _LEAST_DEPTH_M = 0.009, 0.012
"""Where a step is in the way of the palm, a thing is taken this much higher, if that is not too near its top."""
_OPEN_BESIDE_M = (0.010, 0.005)
"""How far the fingers are open beside a thing on either side; the second in tight places."""
_OFF_CENTRE_M = 0.015
_TILT_LIMIT = math.sin(math.radians(40))


@dataclass(frozen=True, slots=True)
class Grasp:
    """Where the tip goes (base frame), how wide the fingers open before and how wide the thing is between them."""

    tip: TipPose
    opening_m: float
    width_m: float


@dataclass(frozen=True, slots=True)
class Carried:
    """How a held thing sits in the hand: its centre seen from the tip, in the hand's yaw frame, and its turn: how far
    the flattest of its axes is from square to the fingers. `axes` is its rotation, seen from the hand's yaw frame.

    A tilted one will fall over when it is let go.
    """

    id: str
    along_m: float
    across_m: float
    below_m: float
    bottom_below_tip_m: float
    turn_rad: float
    width_m: float
    axes: Axes
    tilted: bool = False


@dataclass(frozen=True, slots=True)
class Verdict:
    """A grasp or a place to let go, or why there is none: out of reach, a fixture, or the body `blocker`.

    `options` are the sets of bodies that would have to go, one for each way that fixtures leave open.
    """

    grasp: Grasp | None = None
    blocker: str | None = None
    reachable: bool = True
    options: tuple[tuple[str, ...], ...] = ()


def grasps_of(frame: BasePose, body: Body, state: BodyState) -> list[Grasp]:
    """The ways to take a thing from above with its faces between the fingers, the handiest first."""
    ext = state.extent
    deepest = min(ext.half[2], _GRASP_DEPTH_M)
    depths = (deepest, max(deepest - _HIGHER_M, _LEAST_DEPTH_M))
    found: list[tuple[tuple[float, ...], Grasp]] = []
    on_side = body.shape == "cylinder" and abs(state.axes[2][2]) < 0.5
    lying_m = min(_OFF_CENTRE_M, max(0.0, body.size_m[2] / 2 - 0.02)) if on_side else 0.0
    square = [(0, *axis) for axis in _finger_axes(body, state)]
    askew = [(1, *axis) for axis in _askew_axes(body, state)]
    for (turns, yaw, width), depth, beside in itertools.product(square + askew, depths, _OPEN_BESIDE_M):
        if width > MAX_GRASP_M:
            continue
        z = max(ext.top_m - depth, ext.bottom_m + FINGER_BELOW_TIP_M + 0.001)
        x, y, zb, yb = frame.to_base(*state.xyz[:2], z, yaw)
        yb = central_yaw(x, y, yb)
        if lying_m:  # nearer to the end that will be up, should it be set upright
            x, y = x - lying_m * math.sin(yb), y + lying_m * math.cos(yb)
        twist = abs(yb - (math.pi / 2 + math.atan2(y, x)))
        opening = min(MAX_OPENING_M, width + 2 * beside)
        found.append(((turns, -beside, -round(depth, 4), round(twist, 3)), Grasp((x, y, zb, yb), opening, width)))
    return [g for _, g in sorted(found, key=lambda f: f[0])]


def tip_for(frame: BasePose, carried: Carried, x: float, y: float, bottom_m: float, yaw: float) -> TipPose:
    """Where the tip must be (base frame) for a held thing's centre to be over (x, y), its bottom at a height, and
    the fingers opening along `yaw`."""
    c, s = math.cos(yaw), math.sin(yaw)
    tx = x - (c * carried.along_m - s * carried.across_m)
    ty = y - (s * carried.along_m + c * carried.across_m)
    bx, by, bz, byaw = frame.to_base(tx, ty, bottom_m + carried.bottom_below_tip_m, yaw)
    return (bx, by, bz, central_yaw(bx, by, byaw))


def held_state(frame: BasePose, body: Body, carried: Carried, tip: TipPose) -> BodyState:
    """Where a held thing is while the tip is at a pose (base frame)."""
    x, y, z, yaw = frame.to_world(tip)
    c, s = math.cos(yaw), math.sin(yaw)
    x, y = x + c * carried.along_m - s * carried.across_m, y + s * carried.along_m + c * carried.across_m
    return at_rest(body, (x, y, z - carried.below_m), _turned(carried.axes, c, s))


def put_down_state(body: Body, carried: Carried, x: float, y: float, bottom_m: float, yaw: float) -> BodyState:
    """A held thing once it has been put down, the fingers opening along `yaw`."""
    z = bottom_m + carried.bottom_below_tip_m - carried.below_m
    return at_rest(body, (x, y, z + 0.001), _turned(carried.axes, math.cos(yaw), math.sin(yaw)))


def _turned(axes: Axes, c: float, s: float) -> Axes:
    """A rotation turned about the vertical."""
    (ax, bx, cx), (ay, by, cy), down = axes
    east = c * ax - s * ay, c * bx - s * by, c * cx - s * cy
    return east, (s * ax + c * ay, s * bx + c * by, s * cx + c * cy), down


def _finger_axes(body: Body, state: BodyState) -> list[tuple[float, float]]:
    """Yaws (world) along which the fingers may close on a thing, and its width there."""
    columns = [tuple(row[i] for row in state.axes) for i in (0, 1, 2)]
    sx, sy, sz = body.size_m
    if body.shape == "sphere":
        return [(k * math.pi / 4, sx) for k in range(4)]
    if body.shape == "cylinder":
        u = columns[2]
        if abs(u[2]) > 0.7:
            return [(k * math.pi / 4, sx) for k in range(4)]
        return [(math.atan2(u[1], u[0]) + math.pi / 2, sx)]
    flat = [
        (abs(c[2]), math.atan2(c[1], c[0]), size)
        for c, size in zip(columns, (sx, sy, sz), strict=True)
        if abs(c[2]) < _TILT_LIMIT
    ]
    return [(yaw, size) for _, yaw, size in sorted(flat, key=lambda f: round(f[0], 4))]


def _askew_axes(body: Body, state: BodyState) -> list[tuple[float, float]]:
    """Yaws for a box that its faces offer no grasp of, and the box's extent there.

    An upright one that stands askew, as against the riser of a step, is turned flush by the fingers as they close along
    the world's axes, or held by its corners. One that leans somewhere is taken as it comes.
    """
    if body.shape in ("cylinder", "sphere"):
        return []
    yaws = [0.0, math.pi / 2] if state.upright(body.shape) else [k * math.pi / 8 for k in range(8)]
    return [(yaw, _width_along(body, state, yaw)) for yaw in yaws]


def _width_along(body: Body, state: BodyState, yaw: float) -> float:
    """The extent of a box along a horizontal direction."""
    c, s = math.cos(yaw), math.sin(yaw)
    x, y, _ = state.axes
    return sum(abs(c * x[i] + s * y[i]) * body.size_m[i] for i in (0, 1, 2))
