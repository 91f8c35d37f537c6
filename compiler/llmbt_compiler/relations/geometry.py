"""Things as a viewer sees them, and the relations between two or three of them.

Axes are those of the viewer's heading, not of the line of sight: `right` grows to the viewer's right, `ahead` away from
the viewer, `up` upwards; all in metres. "In front of" is nearer to the viewer, "behind" is farther away.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from llmbt_ir.geometry import Pose, Viewpoint
from llmbt_ir.semantic_map import MapObject, SemanticMap

__all__ = [
    "ALIGNED_M",
    "SAME_HEIGHT_M",
    "Around",
    "Thing",
    "above",
    "behind",
    "below",
    "beside",
    "between",
    "distance",
    "in_front_of",
    "layout",
    "left_of",
    "on_top_of",
    "right_of",
]

ALIGNED_M = 0.025
"""Things whose centres are nearer than this along an axis are level with each other on it. Like all margins here, off
the centimetres in which scenes are laid out, so that no layout lies on the edge of one."""
CONE = 0.7
"""How far to the side, as a part of the way, a thing may be and still be left of another (35 degrees)."""
BESIDE_M = 0.205
"""Things are next to each other where the gap between them is at most this, and nothing stands between."""
SAME_HEIGHT_M = 0.035
"""Bottoms this close are on one level."""
TOUCH_M = 0.015
"""A bottom this close to a top stands on it."""
SPREAD = 0.45
"""How far from the line of two things, as a part of their distance, a thing between them may be."""

Vec3 = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Thing:
    """An object or a place: its centre from above, the heights of its bottom and top, half its extents along `right`
    and `ahead`, and its volume (0 for a place)."""

    id: str
    right: float
    ahead: float
    bottom: float
    top: float
    half_right: float = 0.0
    half_ahead: float = 0.0
    volume: float = 0.0

    @property
    def height(self) -> float:
        """From its bottom to its top."""
        return self.top - self.bottom


@dataclass(frozen=True, slots=True)
class Around:
    """The things of a map that have a known position, by id."""

    things: Mapping[str, Thing]
    seen_by: str

    def __getitem__(self, id_: str) -> Thing:
        return self.things[id_]

    def get(self, id_: str) -> Thing | None:
        """The thing, or None where its position is not known."""
        return self.things.get(id_)


def layout(semantic_map: SemanticMap, moved: Mapping[str, str | None] | None = None) -> Around:
    """Every object and place with a position, as the map's viewer sees it.

    `moved` has the objects that some steps have moved, and the place in whose middle each stands now; None, and a place
    without a surface, where that is not known: then the object is left out.
    """
    viewer = semantic_map.viewpoint
    things: dict[str, Thing] = {}
    for p in semantic_map.places:
        if p.surface_m is not None:
            right, ahead = _seen(p.surface_m, viewer)
            half = _half_extents((*p.size_m, 0.0), Pose(p.surface_m), viewer)
            things[p.id] = Thing(p.id, right, ahead, p.surface_m[2], p.surface_m[2], *half)
    for o in semantic_map.objects:
        thing = _object(o, viewer)
        if moved is None or o.id not in moved:
            things[o.id] = thing
            continue
        at = things.get(moved[o.id] or "")
        if at is not None:
            things[o.id] = replace(thing, right=at.right, ahead=at.ahead, bottom=at.top, top=at.top + thing.height)
    return Around(things, viewer.of)


def _object(o: MapObject, viewer: Viewpoint) -> Thing:
    right, ahead = _seen(o.pose.xyz_m, viewer)
    across, along = _half_extents(o.size_m, o.pose, viewer)
    half_up = sum(abs(c) * s for c, s in zip(_rotation(o.pose)[2], o.size_m, strict=True)) / 2
    z = o.pose.xyz_m[2]
    x, y, height = o.size_m
    return Thing(o.id, right, ahead, z - half_up, z + half_up, across, along, x * y * height)


def _seen(xyz: Vec3, viewer: Viewpoint) -> tuple[float, float]:
    dx, dy = xyz[0] - viewer.xyz_m[0], xyz[1] - viewer.xyz_m[1]
    c, s = math.cos(viewer.yaw_rad), math.sin(viewer.yaw_rad)
    return dx * s - dy * c, dx * c + dy * s


def _half_extents(size: Vec3, pose: Pose, viewer: Viewpoint) -> tuple[float, float]:
    """Half of the extents of a turned box along the viewer's axes."""
    rows = _rotation(pose)
    c, s = math.cos(viewer.yaw_rad), math.sin(viewer.yaw_rad)
    half_right = sum(abs(rows[0][i] * s - rows[1][i] * c) * size[i] for i in range(3)) / 2
    half_ahead = sum(abs(rows[0][i] * c + rows[1][i] * s) * size[i] for i in range(3)) / 2
    return half_right, half_ahead


def _rotation(pose: Pose) -> tuple[Vec3, Vec3, Vec3]:
    x, y, z, w = pose.quat_xyzw
    n = math.sqrt(x * x + y * y + z * z + w * w)
    if n == 0 or not math.isfinite(n):
        return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    x, y, z, w = x / n, y / n, z / n, w / n
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


# -- two things ----------------------------------------------------------------------------------------------------


def left_of(a: Thing, b: Thing) -> bool:
    """Whether a is to the left of b: by the margin, and not rather before or behind it."""
    way = b.right - a.right
    return way >= ALIGNED_M and abs(a.ahead - b.ahead) <= CONE * way


def right_of(a: Thing, b: Thing) -> bool:
    """The mirror image of `left_of`."""
    return left_of(b, a)


def in_front_of(a: Thing, b: Thing) -> bool:
    """Whether a is nearer to the viewer than b: by the margin, and not rather to its left or right."""
    way = b.ahead - a.ahead
    return way >= ALIGNED_M and abs(a.right - b.right) <= CONE * way


def behind(a: Thing, b: Thing) -> bool:
    """The mirror image of `in_front_of`."""
    return in_front_of(b, a)


def above(a: Thing, b: Thing) -> bool:
    """Whether a is higher than b by the margin, wherever it is from above (a level of a shelf)."""
    return a.bottom - b.bottom >= ALIGNED_M


def below(a: Thing, b: Thing) -> bool:
    """The mirror image of `above`."""
    return above(b, a)


def on_top_of(a: Thing, b: Thing) -> bool:
    """Whether a stands on b: its bottom on b's top, its centre over b, and b has a height (is no place)."""
    over = abs(a.right - b.right) <= b.half_right and abs(a.ahead - b.ahead) <= b.half_ahead
    return b.height > 0 and over and abs(a.bottom - b.top) <= TOUCH_M


def distance(a: Thing, b: Thing) -> float:
    """Between the centres, from above."""
    return math.hypot(a.right - b.right, a.ahead - b.ahead)


def beside(a: Thing, b: Thing, others: Mapping[str, Thing]) -> bool:
    """Whether a is next to b: on one level, the gap between them small, and nothing of `others` between.

    Between is the circle over the line of their centres, wider by the margin; so things at the corners of a square are
    next to each other along its sides and not across.
    """
    if abs(a.bottom - b.bottom) > SAME_HEIGHT_M or a.id == b.id:
        return False
    gap_right = abs(a.right - b.right) - a.half_right - b.half_right
    gap_ahead = abs(a.ahead - b.ahead) - a.half_ahead - b.half_ahead
    if math.hypot(max(gap_right, 0.0), max(gap_ahead, 0.0)) > BESIDE_M:
        return False
    centre = ((a.right + b.right) / 2, (a.ahead + b.ahead) / 2)
    reach = distance(a, b) / 2 + ALIGNED_M
    return not any(
        o.id not in (a.id, b.id)
        and abs(o.bottom - a.bottom) <= SAME_HEIGHT_M
        and math.hypot(o.right - centre[0], o.ahead - centre[1]) < reach
        for o in others.values()
    )


def between(a: Thing, b: Thing, c: Thing) -> bool:
    """Whether a is between b and c, seen from above: past each of them by the margin, and near their line."""
    x, y = c.right - b.right, c.ahead - b.ahead
    length = math.hypot(x, y)
    if length < 2 * ALIGNED_M:
        return False
    along = ((a.right - b.right) * x + (a.ahead - b.ahead) * y) / length
    aside = abs((a.right - b.right) * y - (a.ahead - b.ahead) * x) / length
    return ALIGNED_M <= along <= length - ALIGNED_M and aside <= SPREAD * length
