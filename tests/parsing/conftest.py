"""Maps and libraries for the parser's tests, and steps written with their labels in brackets."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_atl.library import Library, load_library, parse_library
from llmbt_compiler.parsing.evaluate import read_scene
from llmbt_ir.geometry import Pose
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap

FIXTURES = Path(__file__).parents[2] / "fixtures" / "parsing"

HOUSEHOLD = b"""<library name="mini_household">
  <types>
    <type name="movable"/><type name="object" parent="movable"/>
    <type name="place"/><type name="furniture" parent="place"/><type name="person" parent="place"/>
  </types>
  <conditions>
    <condition name="On" goal="true" words="{target} is at {place}">
      <param name="target" type="movable"/><param name="place" type="place" upward="true"/>
    </condition>
    <condition name="Holding" goal="true" words="the robot holds {target}">
      <param name="target" type="movable"/></condition>
    <condition name="HandEmpty" goal="true" words="the hand is empty"/>
    <condition name="Near" goal="true" words="the robot is near {location}">
      <param name="location" type="place"/></condition>
  </conditions>
  <templates>
    <template name="navigate" words="go to {location}" verbs="go drive walk move travel head">
      <param name="location" type="place" role="L"/>
      <post><Near location="{location}"/></post>
    </template>
    <template name="pick" words="pick up {target}" verbs="pick grasp grab take fetch get">
      <param name="target" type="movable" role="T"/><param name="location" type="place" role="L"/>
      <start><HandEmpty/><On target="{target}" place="{location}"/></start>
      <hold><Near location="{location}"/></hold>
      <post><Holding target="{target}"/></post>
    </template>
    <template name="place" words="put {target} on {place}" verbs="place put bring deliver carry">
      <param name="target" type="movable" role="T"/><param name="place" type="place" role="D"/>
      <hold><Holding target="{target}"/><Near location="{place}"/></hold>
      <post><On target="{target}" place="{place}"/><HandEmpty/></post>
    </template>
  </templates>
</library>"""

_COLOURS = {1: "green", 2: "green", 3: "yellow", 4: "green", 5: "yellow", 6: "red"}


def cargo_map(*, at: dict[str, str] | None = None) -> SemanticMap:
    """The cargo scene; `at` puts objects on other places."""
    at = at or {}
    objects = tuple(
        MapObject(
            f"object_{i}", f"{c} block", c, "cube", (0.04, 0.04, 0.05), Pose((0.0, 0.0, 0.0)),
            at.get(f"object_{i}", "sorting_area"),
        )
        for i, c in _COLOURS.items()
    )  # fmt: skip
    levels = tuple(MapPlace(f"shelf_level_{n}", f"level {n}", "level", "shelf") for n in (1, 2, 3))
    slots = tuple(
        MapPlace(f"position_{n}{k}", f"position {n}{k}", "slot", f"shelf_level_{n}")
        for n in (1, 2, 3)
        for k in (1, 2, 3, 4)
    )
    ground = (
        MapPlace("workbench", "workbench", "region"),
        MapPlace("sorting_area", "sorting area", "buffer", "workbench", buffer=True),
        MapPlace("shelf", "shelf", "container"),
    )
    return SemanticMap("cargo_sorting", "cargo_sorting", objects, ground + levels + slots)


def household_map() -> SemanticMap:
    """Three things to drink and eat, and where they are served."""
    things = (("milk", "white", "table"), ("coke", "red", "bar"), ("potato_chips", "yellow", "table"))
    objects = tuple(
        MapObject(i, i.replace("_", " "), c, "box", (0.1, 0.1, 0.1), Pose((0.0, 0.0, 0.0)), p) for i, c, p in things
    )
    furniture = (MapPlace(i, i, "furniture") for i in ("table", "bar", "desk"))
    places = (*furniture, MapPlace("user", "user", "person"))
    return SemanticMap("home", "mini_household", objects, places)


@pytest.fixture(scope="session")
def cargo() -> tuple[SemanticMap, Library]:
    return cargo_map(), load_library("cargo_sorting")


@pytest.fixture(scope="session")
def swapped() -> tuple[SemanticMap, Library]:
    return cargo_map(at={"object_1": "position_12", "object_3": "position_22"}), load_library("cargo_sorting")


@pytest.fixture(scope="session")
def shelf() -> tuple[SemanticMap, Library]:
    return read_scene(FIXTURES, "shelf")


@pytest.fixture(scope="session")
def depot() -> tuple[SemanticMap, Library]:
    return read_scene(FIXTURES, "depot")


@pytest.fixture(scope="session")
def flat() -> tuple[SemanticMap, Library]:
    return read_scene(FIXTURES, "home")


@pytest.fixture(scope="session")
def home() -> tuple[SemanticMap, Library]:
    return household_map(), parse_library(HOUSEHOLD, "mini_household.xml")
