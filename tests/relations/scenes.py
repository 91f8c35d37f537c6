"""Maps made at random: objects of several sizes, turned, on one height or stacked, seen from anywhere."""

from __future__ import annotations

import math

from hypothesis import strategies as st

from llmbt_ir.geometry import Pose, Viewpoint
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap

LENGTH = st.integers(-600, 600).map(lambda n: n / 1000)
SIZE = st.integers(20, 120).map(lambda n: n / 1000)
ANGLE = st.integers(-314, 314).map(lambda n: n / 100)


@st.composite
def quats(draw):
    """Upright and turned, or any rotation at all."""
    if draw(st.booleans()):
        yaw = draw(ANGLE)
        return (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    parts = [draw(st.integers(-10, 10)) for _ in range(4)]
    if not any(parts):
        return (0.0, 0.0, 0.0, 1.0)
    n = math.sqrt(sum(p * p for p in parts))
    return tuple(p / n for p in parts)


@st.composite
def maps(draw, most=7):
    """Objects on a table, some put onto others."""
    objects = []
    for i in range(draw(st.integers(3, most))):
        size = (draw(SIZE), draw(SIZE), draw(SIZE))
        quat = draw(quats())
        x, y, z = draw(LENGTH), draw(LENGTH), draw(st.sampled_from([0.0, 0.0, 0.0, 0.06, 0.3])) + size[2] / 2
        under = draw(st.sampled_from([None, None, *objects]))
        if under is not None:
            quat, z = under.pose.quat_xyzw, under.pose.xyz_m[2] + under.size_m[2] / 2 + size[2] / 2
            x = under.pose.xyz_m[0] + draw(st.integers(-30, 30)) / 1000
            y = under.pose.xyz_m[1] + draw(st.integers(-30, 30)) / 1000
        objects.append(MapObject(f"o{i}", f"o{i}", "red", "box", size, Pose((x, y, z), quat), "table"))
    view = Viewpoint("somebody", (draw(LENGTH), draw(LENGTH), 0.0), draw(ANGLE))
    table = MapPlace("table", "table", "region", surface_m=(0.0, 0.0, 0.0), size_m=(2.0, 2.0))
    return SemanticMap("s", "l", tuple(objects), (table,), viewpoint=view)
