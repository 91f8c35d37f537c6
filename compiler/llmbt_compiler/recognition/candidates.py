"""The things that may be seen: those that a scene declares, and those that a map before had besides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.recognition.colour import colour_distances, lit_colour, term_of
from llmbt_compiler.recognition.solids import Geometry
from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import COLOURS, Scene
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["OTHER_COLOUR", "Candidate", "candidates", "colour_off", "may_be_in"]

Array = NDArray[np.float64]

OTHER_COLOUR = 17.0
"""Of this distance on, a thing has another colour than it is declared to have: of the paints of one term (development),
nine in ten are nearer to the scene's colour of that name, and two in ten of those nearest to them in other terms."""
_QUITE_ANOTHER, _SOME = 25.0, 0.1


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A thing that may be seen: its attributes, and where it was last."""

    id: str
    name: str
    type: str
    colour: str
    shape: str
    geometry: Geometry
    last_m: Vec3 | None = None
    held: bool = False
    likely: bool = True


def candidates(scene: Scene, previous: SemanticMap | None) -> tuple[Candidate, ...]:
    """What the scene declares, and what the map before had besides; where each was: in that map, or as declared."""
    before = {o.id: o for o in previous.objects} if previous is not None else {}
    found = []
    for b in (*scene.objects, *scene.obstacles):
        seen = before.pop(b.id, None)
        pose = seen.pose if seen is not None else b.pose if previous is None else None
        found.append(
            Candidate(
                b.id,
                b.name,
                b.type,
                b.colour,
                b.shape,
                Geometry.of(b.shape, b.size_m),
                pose.xyz_m if pose is not None else None,
                seen is not None and seen.held,
                b in scene.objects or seen is not None,
            )
        )
    for o in before.values():
        geometry = Geometry.of(o.shape, o.size_m)
        found.append(Candidate(o.id, o.name, o.type, o.colour, o.shape, geometry, o.pose.xyz_m, o.held))
    return tuple(found)


def colour_off(candidate: Candidate, rgb: Array, term: str) -> float:
    """How far a colour is from the declared one: not at all where people use the same word for both, or where no colour
    was seen."""
    declared = COLOURS.get(candidate.colour)
    if declared is None or not term or term in (candidate.colour, term_of(np.array(declared))):
        return 0.0
    return float(colour_distances(np.array(declared), rgb[None])[0])


def may_be_in(candidate: Candidate, rgb: Array) -> bool:
    """Whether some of the points of a cluster (N x 3, sRGB), a tenth or more, are not of quite another colour."""
    declared = COLOURS.get(candidate.colour)
    if declared is None:
        return True
    few = rgb[:: max(1, len(rgb) // 200)]
    if float((colour_distances(np.array(declared), few) < _QUITE_ANOTHER).mean()) >= _SOME:
        return True
    lit = lit_colour(few)
    return colour_off(candidate, lit, term_of(lit)) == 0.0
