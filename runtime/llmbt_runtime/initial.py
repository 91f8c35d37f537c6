"""The facts that a semantic map implies, for a world of facts: the conditions settled for all shipped libraries."""

from __future__ import annotations

from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Facts
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["facts_of_map"]


def facts_of_map(domain: Domain, semantic_map: SemanticMap) -> Facts:
    """Everything stands where the map says and can be approached, the hand is empty but for what it holds there, what
    holds nothing is free; a robot that drives is near nothing.

    Only conditions that the library declares are given. Slots take one thing; every other spot has room.
    """
    known = domain.library.conditions
    facts: set[Condition] = set()
    taken: set[str] = set()
    held = [o.id for o in semantic_map.objects if o.held]
    if "HandEmpty" in known and not held:
        facts.add(Condition("HandEmpty"))
    if "Holding" in known:
        facts.update(Condition("Holding", (id_,)) for id_ in held)
    for thing in semantic_map.objects:
        if thing.place is not None and "On" in known:
            facts.update(domain.upward(Condition("On", (thing.id, thing.place))))
            taken.add(thing.place)
    if "Clear" in known:
        type_ = known["Clear"].params[0].type
        facts.update(Condition("Clear", (thing,)) for thing in domain.by_type.get(type_, ()))
    if "Free" in known:
        type_ = known["Free"].params[0].type
        for place in domain.by_type.get(type_, ()):
            if place not in taken or not domain.fits(place, "slot"):
                facts.add(Condition("Free", (place,)))
    return frozenset(facts)
