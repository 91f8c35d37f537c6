"""Scene files: what they give, and how they complain."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from llmbt_ir.diagnostics import Diagnostic, LlmbtError
from llmbt_ir.geometry import Viewpoint
from llmbt_ir.scene import Scene, load_scene, parse_scene, read_scene, scene_names, to_semantic_map
from llmbt_ir.semantic_map import parse_map, write_map

SOURCE = load_scene("cargo_sorting").source


def text() -> str:
    return Path(SOURCE).read_text(encoding="utf-8")


def faults(changed: str) -> tuple[Diagnostic, ...]:
    with pytest.raises(LlmbtError) as raised:
        parse_scene(changed.encode(), "my.xml")
    for d in raised.value.diagnostics:
        assert d.span is not None
        assert d.span.source == "my.xml"
        assert d.span.line > 0
    return raised.value.diagnostics


def line_of(changed: str, needle: str) -> int:
    return next(i for i, line in enumerate(changed.splitlines(), start=1) if needle in line)


def test_the_shipped_scenes() -> None:
    assert {"cargo_sorting", "cargo_swap"} <= set(scene_names())
    scene = load_scene("cargo_sorting")
    assert [o.colour for o in scene.objects] == ["green", "green", "yellow", "green", "yellow", "red"]
    assert len([p for p in scene.places if p.is_slot]) == 12
    assert list(scene.with_containers("position_12")) == ["position_12", "shelf_level_1", "shelf"]
    swap = to_semantic_map(load_scene("cargo_swap"))
    assert {o.id: o.place for o in swap.objects if o.place != "sorting_area"} == {
        "object_1": "position_12",
        "object_3": "position_22",
    }


def test_the_map_leaves_parked_obstacles_out_and_survives_writing() -> None:
    scene = load_scene("cargo_sorting")
    semantic_map = to_semantic_map(scene)
    assert len(semantic_map.objects) == 6
    assert {o.place for o in semantic_map.objects} == {"sorting_area"}
    again = parse_map(write_map(semantic_map))
    assert [p.id for p in again.places] == [p.id for p in scene.places]
    assert [o.place for o in again.objects] == [o.place for o in semantic_map.objects]


def test_left_and_right_are_the_robots_unless_a_viewer_is_declared() -> None:
    assert to_semantic_map(load_scene("cargo_sorting")).viewpoint == Viewpoint("robot", (0.0, 0.0, 0.4), 0.0)
    viewer = '<Viewer of="guest" xyz_m="2 0 0" yaw_rad="3.14"/></Scene>'
    seen = to_semantic_map(parse_scene(text().replace("</Scene>", viewer).encode()))
    assert seen.viewpoint == Viewpoint("guest", (2.0, 0.0, 0.0), 3.14)
    assert [d.code for d in faults(text().replace("</Scene>", '<Viewer of="guest"/></Scene>'))] == ["E006"]


@pytest.mark.parametrize(("shape", "size"), [("sphere", "0.04 0.05 0.04"), ("cylinder", "0.04 0.05 0.08")])
def test_what_is_round_has_one_diameter(shape: str, size: str) -> None:
    changed = text().replace('shape="cube" size_m="0.045 0.045 0.045"', f'shape="{shape}" size_m="{size}"', 1)
    (found,) = faults(changed)
    assert found.code == "E045" and shape in found.title
    assert found.span is not None and found.span.line == line_of(changed, f'shape="{shape}"')


@pytest.mark.parametrize("value", ["9.5e-1", "nan", "one"])
def test_which_number_is_none(value: str) -> None:
    (found,) = faults(text().replace('eye_m="0.95 1.55', f'eye_m="{value} 1.55'))
    assert found.code == "E006" and found.title.startswith(f"`{value}` in `eye_m` of <Camera> is no plain decimal")


def test_a_camera_does_not_look_at_where_it_is() -> None:
    changed = text().replace('target_m="0.27 0.15 0.57"', 'target_m="0.95 1.55 1.35"')
    (found,) = faults(changed)
    assert found.code == "E039" and found.span is not None and found.span.line == line_of(changed, 'id="front"')


def test_unknown_scene_names_its_nearest() -> None:
    with pytest.raises(LlmbtError, match="E040") as raised:
        load_scene("cargo_sortin")
    assert raised.value.diagnostics[0].candidates[0] == "cargo_sorting"


def test_unknown_parent_and_place() -> None:
    changed = text().replace('parent="shelf_level_2"', 'parent="shelf_levl_2"', 1)
    found = faults(changed)
    assert [d.code for d in found] == ["E021"]
    assert found[0].candidates[0].startswith("shelf_level")
    assert found[0].span is not None
    assert found[0].span.line == line_of(changed, "shelf_levl_2")
    assert faults(text().replace('on="sorting_area"', 'on="sorting_aera"', 1))[0].candidates == ("sorting_area",)


def test_duplicate_ids() -> None:
    changed = text().replace('id="object_2"', 'id="object_1"')
    (found,) = faults(changed)
    assert found.code == "E020"
    assert found.span is not None
    assert str(line_of(changed, 'id="object_1"')) in found.title


def test_every_fault_at_once() -> None:
    changed = text().replace('colour="red"', 'colour="rde"').replace('on="sorting_area"', 'on="shelf"', 1)
    assert sorted(d.code for d in faults(changed)) == ["E041", "E043"]


@pytest.mark.parametrize(
    ("old", "new", "needle"),
    [
        ('on="sorting_area" offset_m="0.17 -0.07"', 'on="sorting_area" offset_m="0.05 -0.07"', "object_2"),
        ('on="sorting_area" offset_m="0.17 -0.07"', 'xyz_m="0.44 0.06 0.46"', "step_1"),
        ('on="sorting_area" offset_m="0.17 -0.07"', 'xyz_m="0.05 0.05 0.45"', "the robot"),
    ],
)
def test_overlaps_at_the_start(old: str, new: str, needle: str) -> None:
    found = faults(text().replace(old, new))
    assert {d.code for d in found} == {"E042"}
    assert any(needle in d.title for d in found)


def test_turned_neighbours_do_not_overlap() -> None:
    changed = text().replace('offset_m="0.04 -0.07"', 'offset_m="0.22 -0.02" yaw_rad="0.7854"')
    assert isinstance(parse_scene(changed.encode()), Scene)


def test_a_place_in_itself() -> None:
    changed = text().replace('id="shelf" type="container"', 'id="shelf" type="container" parent="shelf_level_1"')
    assert {d.code for d in faults(changed)} == {"E022"}


def test_too_wide_for_the_gripper() -> None:
    assert faults(text().replace('size_m="0.045 0.045 0.045" on', 'size_m="0.09 0.09 0.045" on', 1))[0].code == "E044"


@pytest.mark.parametrize(
    ("pattern", "replacement", "code"),
    [
        (r"</Objects>", "", "E003"),
        (r'mass_kg="0.1"', 'mass_kg="heavy"', "E006"),
        (r"<Objects>", "<Things>", "E003"),
        (r'shape="cube"', 'shape="pyramid"', "E006"),
        (r'size_m="0.045 0.045 0.045"', 'size_m="0.045 0.045"', "E006"),
        (r'size_m="0.045 0.045 0.045"', 'size_m="0.045 -1 0.045"', "E006"),
        (r'xyz_m="0 0 0.4"', 'xyz_m="0 0 NaN"', "E006"),
        (r' shape="cube"', "", "E006"),
        (r'id="object_3"', 'id="object 3"', "E006"),
        (r'type="slot"', 'type="slot" colour="red"', "E006"),
    ],
)
def test_malformed_documents(pattern: str, replacement: str, code: str) -> None:
    assert faults(re.sub(pattern, replacement, text(), count=1))[0].code == code


def test_an_object_stands_somewhere_and_only_there() -> None:
    for where in ("", 'xyz_m="0.1 0.4 0.4225" on="sorting_area"'):
        assert faults(text().replace('on="sorting_area" offset_m="0.17 -0.07"', where))[0].code == "E046"


def test_a_missing_file_is_a_diagnostic() -> None:
    with pytest.raises(LlmbtError, match="E001"):
        read_scene(Path("no_such_scene.xml"))
