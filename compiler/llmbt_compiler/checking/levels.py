"""Levels told by going up or down from where a thing stands: "one level down", "a level higher"."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token

__all__ = ["levels_from"]

_UP = frozenset({"up", "higher", "above", "raise", "upwards"})
_DOWN = frozenset({"down", "lower", "below", "beneath", "under", "underneath", "downwards"})
_LEVELS = frozenset({"level", "levels", "shelf", "storey", "tier", "row", "floor", "board"})


def levels_from(words: Sequence[Token], place: str | None, scene: Scene) -> tuple[str, ...]:
    """The levels that these words lead to from a place: just one where it is counted ("down by one level", "the level
    above"), else all that way; none where they tell no way, or the place is on no level."""
    here = next(iter(scene.map.containers(place)), None) if place is not None else None
    over = next(iter(scene.map.containers(here)), None) if here is not None else None
    levels = scene.upwards(p.id for p in scene.map.inside(over) if scene.map.inside(p.id)) if over is not None else ()
    said = {t.text for t in words}
    if here not in levels or bool(said & _UP) == bool(said & _DOWN):
        return ()
    way = levels[levels.index(here) + 1 :] if said & _UP else levels[: levels.index(here)][::-1]
    count = next((c for a, b in pairwise(words) if b.text in _LEVELS and (c := _count(a))), 0)
    return way[count - 1 : count] if count else way


def _count(t: Token) -> int:
    if t.number is not None and t.number.isdecimal() and not t.digits:
        return int(t.number)
    return int(t.text in {"a", "one", "next"})
