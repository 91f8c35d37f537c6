"""The row that a place stands in."""

from __future__ import annotations

from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.relations import DIRECTIONS, layout, ties

__all__ = ["row_of"]


def row_of(place: str | None, scene: Scene) -> tuple[str, ...]:
    """The places for one thing within the same container as `place`, from left to right; none where it is no such
    place, or they stand in no row."""
    inner = next(iter(scene.map.containers(place)), None) if place else None
    if place is None or inner is None or not scene.single(place):
        return ()
    known = layout(scene.map, {})
    slots = (e.id for e in scene.places if scene.single(e.id) and next(iter(scene.map.containers(e.id)), None) == inner)
    groups = ties([t for i in slots if (t := known.get(i)) is not None], DIRECTIONS["left"])
    return tuple(g[0] for g in groups) if all(len(g) == 1 for g in groups) else ()
