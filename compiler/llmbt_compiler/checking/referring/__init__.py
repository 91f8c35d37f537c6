"""Noun phrases of a request, and the objects that each may mean on the map as it is at the start."""

from llmbt_compiler.checking.referring.apart import told_apart
from llmbt_compiler.checking.referring.landmarks import landmark, pointed_to
from llmbt_compiler.checking.referring.lists import MASS
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.predicates import predicated
from llmbt_compiler.checking.referring.reading import meant_objects
from llmbt_compiler.checking.referring.standing import place_named, standing_there

__all__ = [
    "MASS",
    "Meant",
    "landmark",
    "meant_objects",
    "place_named",
    "pointed_to",
    "predicated",
    "standing_there",
    "told_apart",
]
