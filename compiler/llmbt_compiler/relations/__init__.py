"""Relations from coordinates: what is left of what, what stands in which order (docs/relations.md).

Pure functions over a semantic map. Every relation has a margin, so that a map recognised a millimetre off says the same
wherever things are not themselves within a millimetre of the margin.
"""

from llmbt_compiler.relations.facts import facts_of
from llmbt_compiler.relations.geometry import (
    ALIGNED_M,
    SAME_HEIGHT_M,
    Around,
    Thing,
    above,
    behind,
    below,
    beside,
    between,
    distance,
    in_front_of,
    layout,
    left_of,
    on_top_of,
    right_of,
)
from llmbt_compiler.relations.order import DIRECTIONS, Direction, by_size, in_a_row, nearest_first, ranked, ties

__all__ = [
    "ALIGNED_M",
    "DIRECTIONS",
    "SAME_HEIGHT_M",
    "Around",
    "Direction",
    "Thing",
    "above",
    "behind",
    "below",
    "beside",
    "between",
    "by_size",
    "distance",
    "facts_of",
    "in_a_row",
    "in_front_of",
    "layout",
    "left_of",
    "nearest_first",
    "on_top_of",
    "ranked",
    "right_of",
    "ties",
]
