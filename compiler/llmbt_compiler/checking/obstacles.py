"""Why a request cannot be carried out as it stands, whatever anybody makes of it: for a model's question that does not
say so itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

from llmbt_atl.library import Library
from llmbt_atl.state import domain_of
from llmbt_compiler.checking.abilities import unable
from llmbt_compiler.checking.crowding import too_many
from llmbt_compiler.checking.kept import moved_all_the_same
from llmbt_compiler.checking.request import lacking
from llmbt_compiler.checking.unknown import unknown_names
from llmbt_compiler.parsing import LabelledStep, ParseResult, say
from llmbt_ir.diagnostics import Diagnostic
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["obstacles"]

_OF_THE_WORLD = frozenset({"E307", "E308"})
"""What the parser says of a place that is full, or that is not where it is said to be."""
_NOT_THERE = ("there is no", "the scene has no position", "the scene has no level")


def obstacles(
    request: str, sentences: Sequence[LabelledStep], own: ParseResult, semantic_map: SemanticMap, library: Library
) -> Iterator[Diagnostic]:
    """The reasons, the surest first: an ability that the robot lacks, what the map lacks, more on a place than it
    holds, what is to stay and to go; then what the request's `own` reading runs into."""
    yield from unable(request, semantic_map, library)
    point = lacking(request, semantic_map, library)
    if point is not None:
        yield point.diagnostic
    yield from too_many(request, own.goals, semantic_map, library)
    yield from moved_all_the_same(request, own.goals, semantic_map, library)
    for fault in own.errors():
        if fault.code in _OF_THE_WORLD or (fault.code == "E302" and fault.title.startswith(_NOT_THERE)):
            yield fault
    domain = domain_of(library, semantic_map)
    for a, b in combinations((g.condition for g in own.goals), 2):
        if domain.mutex(a, b):
            yield Diagnostic("E343", f"the request contradicts itself: {say(a, library)}, and {say(b, library)}")
    yield from (p.diagnostic for p in unknown_names(sentences, (), semantic_map, library))
