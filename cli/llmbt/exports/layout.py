"""A small layered layout of trees: levels in rows, siblings in order, branches as close as their outlines allow.

Each branch keeps the outline of its left and right side by level, deepest level first, so that a parent is put on at
the end; two branches are joined by walking the shorter outline only. Nothing recurses on depth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

__all__ = ["Place", "arrange"]


@dataclass(frozen=True, slots=True)
class Place:
    """The centre of a node across its level, and the level from 0."""

    across: float
    level: int


@dataclass
class _Outline:
    """A branch: where its sides are on each level, deepest first, each to be shifted by `shift`."""

    left: list[float]
    right: list[float]
    shift: float = 0.0


def arrange(
    tops: Sequence[str], children: Mapping[str, Sequence[str]], extent: Mapping[str, float], gap: float
) -> dict[str, Place]:
    """Places for all nodes below `tops`, which stand side by side; `extent` is each node's size across."""
    order: list[tuple[str, int]] = []
    stack = [(t, 0) for t in reversed(tops)]
    while stack:
        here = stack.pop()
        order.append(here)
        stack.extend((c, here[1] + 1) for c in reversed(children[here[0]]))
    offset: dict[str, float] = dict.fromkeys(tops, 0.0)
    outlines: dict[str, _Outline] = {}
    for id_, _ in reversed(order):
        half = extent[id_] / 2
        kids = children[id_]
        if not kids:
            outlines[id_] = _Outline([-half], [half])
            continue
        joined, places = _row([outlines.pop(c) for c in kids], gap)
        middle = (places[0] + places[-1]) / 2
        offset.update((c, x - middle) for c, x in zip(kids, places, strict=True))
        joined.shift -= middle
        joined.left.append(-half - joined.shift)
        joined.right.append(half - joined.shift)
        outlines[id_] = joined
    if tops:
        _, places = _row([outlines[t] for t in tops], gap)
        offset.update(zip(tops, places, strict=True))
    found: dict[str, Place] = {}
    parent = {c: p for p, _ in order for c in children[p]}
    for id_, level in order:
        above = found[parent[id_]].across if id_ in parent else 0.0
        found[id_] = Place(above + offset[id_], level)
    return found


def _row(branches: list[_Outline], gap: float) -> tuple[_Outline, list[float]]:
    """Branches side by side: the outline of them all, and where each one's top is."""
    joined = branches[0]
    places = [0.0]
    for branch in branches[1:]:
        common = min(len(joined.right), len(branch.left))
        nearest = max(joined.right[-k] + joined.shift - branch.left[-k] - branch.shift for k in range(1, common + 1))
        at = nearest + gap
        places.append(at)
        branch.shift += at
        joined = _join(joined, branch, common)
    return joined, places


def _join(first: _Outline, second: _Outline, common: int) -> _Outline:
    """The left side of the first and the right side of the second, and below them those of the deeper one."""
    if len(first.left) >= len(second.left):
        for k in range(1, common + 1):
            first.right[-k] = second.right[-k] + second.shift - first.shift
        return first
    for k in range(1, common + 1):
        second.left[-k] = first.left[-k] + first.shift - second.shift
    return second
