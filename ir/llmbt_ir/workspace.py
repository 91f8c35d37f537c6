"""Where the things of a scene are."""

from __future__ import annotations

import math

from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Scene

__all__ = ["workspace"]

_AROUND_M, _ABOVE_M = 0.05, 0.6
_OFF_FLOOR_M = 0.005


def workspace(scene: Scene) -> tuple[Vec3, Vec3]:
    """The lowest and the highest corner of the box over a scene's fixtures and places, up to some height; everywhere,
    if it has none."""
    boxes = [(f.xyz_m, f.size_m, f.top_m) for f in scene.fixtures]
    boxes += [(p.surface_m, (*p.size_m[:2], 0.0), p.surface_m[2]) for p in scene.places if p.surface_m is not None]
    if not boxes:
        return (-math.inf, -math.inf, -math.inf), (math.inf, math.inf, math.inf)
    x, y = ([at[i] - size[i] / 2 for at, size, _ in boxes] for i in (0, 1))
    u, v = ([at[i] + size[i] / 2 for at, size, _ in boxes] for i in (0, 1))
    top = max(top for _, _, top in boxes) + _ABOVE_M
    return (min(x) - _AROUND_M, min(y) - _AROUND_M, _OFF_FLOOR_M), (max(u) + _AROUND_M, max(v) + _AROUND_M, top)
