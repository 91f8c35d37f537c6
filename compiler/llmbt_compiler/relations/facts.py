"""The relations of a map in words, for the prompt: a line for each order and not one for each pair."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations

from llmbt_compiler.relations.geometry import Around, Thing, beside, layout, on_top_of
from llmbt_compiler.relations.order import DIRECTIONS, Direction, by_size, ties
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["facts_of"]

MAX_LINES = 60
MAX_NAMES = 24
MAX_PAIRS = 24
MAX_PAIRED = 60
_AXES = (("left", "from left to right"), ("front", "from front to back"))
_LOW = Direction("low to high", lambda t: t.bottom)


def facts_of(semantic_map: SemanticMap) -> tuple[str, ...]:
    """What stands in which order on each place, which places lie how, what is next to what, on what, and the sizes.

    At most MAX_LINES lines, of at most MAX_NAMES names each, whatever the map's size; equal maps give equal lines.
    Only what is clear by the margins is said; things that are level or alike are joined by `=`.
    """
    around = layout(semantic_map)
    lines = [*_places(semantic_map, around), *_objects(semantic_map, around), *_sizes(semantic_map, around)]
    return tuple(lines[:MAX_LINES])


def _places(semantic_map: SemanticMap, around: Around) -> Iterator[str]:
    inside: dict[str, list[Thing]] = {}
    for p in semantic_map.places:
        thing = around.get(p.id)
        if p.parent is not None and thing is not None:
            inside.setdefault(p.parent, []).append(thing)
    for outer in semantic_map.places:
        yield from _orders(f"in {outer.id}", inside.get(outer.id, ()))
        yield from _line(f"in {outer.id} from low to high", ties(inside.get(outer.id, ()), _LOW))


def _objects(semantic_map: SemanticMap, around: Around) -> Iterator[str]:
    standing: dict[str, list[Thing]] = {}
    for o in semantic_map.objects:
        if o.place is not None:
            standing.setdefault(o.place, []).append(around[o.id])
    for place, here in standing.items():
        yield from _orders(f"on {place}", here)
        by_id = {t.id: t for t in here}
        pairs = [f"{a.id} and {b.id}" for a, b in _pairs(here) if beside(a, b, by_id)]
        if pairs and len(here) > 2:
            yield f"on {place} next to each other: {_listed(pairs, MAX_PAIRS)}"
    everything = [around[o.id] for o in semantic_map.objects]
    stacked = [f"{a.id} on {b.id}" for x, y in _pairs(everything) for a, b in ((x, y), (y, x)) if on_top_of(a, b)]
    if stacked:
        yield f"stacked: {_listed(stacked, MAX_PAIRS)}"


def _pairs(things: Sequence[Thing]) -> Iterable[tuple[Thing, Thing]]:
    """Every pair, unless there are so many things that nobody reads of their neighbours."""
    return combinations(things, 2) if len(things) <= MAX_PAIRED else ()


def _orders(where: str, things: Sequence[Thing]) -> Iterator[str]:
    for name, words in _AXES:
        yield from _line(f"{where} {words}", ties(things, DIRECTIONS[name]))


def _sizes(semantic_map: SemanticMap, around: Around) -> Iterator[str]:
    things = [around[o.id] for o in semantic_map.objects]
    yield from _line("objects from small to large", by_size(things))


def _line(head: str, groups: Sequence[Sequence[str]]) -> Iterator[str]:
    if len(groups) < 2:
        return
    shown: list[str] = []
    left = MAX_NAMES
    for group in groups:
        if left > 0:
            shown.append(" = ".join(group[:left]))
        left -= len(group)
    yield f"{head}: {', '.join(shown)}" + (f", and {-left} more" if left < 0 else "")


def _listed(names: Sequence[str], most: int) -> str:
    more = f", and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more
