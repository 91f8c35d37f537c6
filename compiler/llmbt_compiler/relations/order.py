"""Orders: along a direction, by size, by distance; what is level or alike is told as a tie, never put in an order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from llmbt_compiler.relations.geometry import ALIGNED_M, Thing, distance

__all__ = ["DIRECTIONS", "Direction", "by_size", "in_a_row", "nearest_first", "ranked", "ties"]

NEARER_M = 0.015
"""One thing is nearer than another where it is so by more than this."""
TALLER_M = 0.0075
"""One thing is taller than another where it is so by more than this."""
LARGER = 1.15
"""One thing is larger than another where it is so by more than this factor."""


@dataclass(frozen=True, slots=True)
class Direction:
    """Something to order by: `key` grows along it, `margin` is what counts as a step."""

    name: str
    key: Callable[[Thing], float]
    margin: float = ALIGNED_M


DIRECTIONS: Mapping[str, Direction] = MappingProxyType(
    {
        "left": Direction("left to right", lambda t: t.right),
        "right": Direction("right to left", lambda t: -t.right),
        "front": Direction("front to back", lambda t: t.ahead),
        "back": Direction("back to front", lambda t: -t.ahead),
        "small": Direction("small to large", lambda t: _log(t.volume), math.log(LARGER)),
        "large": Direction("large to small", lambda t: -_log(t.volume), math.log(LARGER)),
        "short": Direction("short to tall", lambda t: t.height, TALLER_M),
        "tall": Direction("tall to short", lambda t: -t.height, TALLER_M),
    }
)
"""By the end that comes first."""


def _log(volume: float) -> float:
    return math.log(volume) if volume > 0 else -math.inf


def ties(things: Iterable[Thing], direction: Direction) -> tuple[tuple[str, ...], ...]:
    """The things along a direction, level ones together: a step of more than the margin to the next begins a new group.

    Within a group by id. A chain of small steps is one group, however long.
    """
    listed = sorted(things, key=lambda t: (direction.key(t), t.id))
    groups: list[list[Thing]] = []
    for thing in listed:
        if groups and not direction.key(thing) - direction.key(groups[-1][-1]) > direction.margin:
            groups[-1].append(thing)
        else:
            groups.append([thing])
    return tuple(tuple(sorted(t.id for t in g)) for g in groups)


def ranked(things: Iterable[Thing], direction: Direction, rank: int = 1) -> tuple[str, ...]:
    """What comes `rank`-th along a direction: one id, or all those level with each other that it may be; none where
    there are fewer things."""
    before = 0
    for group in ties(things, direction):
        if before < rank <= before + len(group):
            return group
        before += len(group)
    return ()


def by_size(things: Iterable[Thing]) -> tuple[tuple[str, ...], ...]:
    """From small to large by volume, things alike together."""
    return ties(things, DIRECTIONS["small"])


def nearest_first(things: Iterable[Thing], to: Thing) -> tuple[tuple[str, ...], ...]:
    """By the distance between centres from above, things as far together; `to` itself is left out."""
    return ties((t for t in things if t.id != to.id), Direction("near to far", lambda t: distance(t, to), NEARER_M))


def in_a_row(things: Iterable[Thing]) -> bool:
    """Whether two or more things stand in a row along one of the viewer's axes: level on the other one, apart on this
    one."""
    listed = tuple(things)
    if len(listed) < 2:
        return False
    for across, along in (("front", "left"), ("left", "front")):
        keys = [DIRECTIONS[across].key(t) for t in listed]
        if max(keys) - min(keys) <= ALIGNED_M and len(ties(listed, DIRECTIONS[along])) == len(listed):
            return True
    return False
