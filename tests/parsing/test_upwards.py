"""What is the top, and what lies one level up, is told by the heights of the map, not by the numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from llmbt_atl.library import Library, load_library
from llmbt_compiler.parsing import parse
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.stages import tagged
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.semantic_map import MapPlace, SemanticMap


@pytest.fixture(scope="module")
def upside_down() -> tuple[SemanticMap, Library]:
    """The cargo shelf with its level 1 uppermost."""
    scene = load_scene("cargo_swap")
    map_ = to_semantic_map(scene)

    def turned(place: MapPlace) -> MapPlace:
        if place.surface_m is None or not place.id.startswith(("shelf_level", "position")):
            return place
        x, y, z = place.surface_m
        return replace(place, surface_m=(x, y, 2.0 - z))

    places = tuple(map(turned, map_.places))
    return replace(map_, places=places), load_library(scene.library, beside=Path(scene.source).parent)


def read(text: str, scene: tuple[SemanticMap, Library]) -> set[str]:
    return {str(g.condition) for g in parse(tagged([text], "default"), *scene).goals}


def test_levels_from_the_lowest_up(upside_down):
    levels = ("shelf_level_1", "shelf_level_2", "shelf_level_3")
    assert Scene(*upside_down).upwards(levels) == levels[::-1]
    flat = replace(upside_down[0], places=tuple(replace(p, surface_m=None) for p in upside_down[0].places))
    assert Scene(flat, upside_down[1]).upwards(levels) == levels


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("Put object 6 on the top level.", "position_11"),
        ("Put object 6 on the bottom level.", "position_31"),
        ("Lift the yellow block on the shelf up by one level.", "position_11"),
    ],
)
def test_the_map_tells_what_is_high(upside_down, text, place):
    (goal,) = read(text, upside_down)
    assert goal.endswith(f"{place})") or goal.endswith(f"shelf_level_{place[-2]})")
