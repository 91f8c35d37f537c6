"""Semantic maps: what is written is read back; faults have a line and a suggestion."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.geometry import Pose, Viewpoint
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap, parse_map, read_map, write_map

LENGTH = st.integers(-100_000, 100_000).map(lambda n: n / 10_000)
TEXT = st.text(
    st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="\ufffe\uffff"), min_size=1, max_size=15
)


@st.composite
def maps(draw: st.DrawFn) -> SemanticMap:
    ids = draw(st.lists(st.from_regex(r"[A-Za-z0-9_\-]{1,12}", fullmatch=True), min_size=1, max_size=8, unique=True))
    cut = draw(st.integers(0, len(ids)))
    places, objects = ids[:cut], ids[cut:]
    triple = st.tuples(LENGTH, LENGTH, LENGTH)
    surface = st.one_of(st.just((None, (0.0, 0.0))), st.tuples(triple, st.tuples(LENGTH, LENGTH)))
    made = tuple(
        MapPlace(p, draw(TEXT), "slot", draw(st.sampled_from([None, *places[:i]])), draw(st.booleans()), 0, *on)
        for i, (p, on) in enumerate((p, draw(surface)) for p in places)
    )
    things = tuple(
        MapObject(
            o,
            draw(TEXT),
            draw(TEXT),
            "cube",
            draw(triple),
            Pose(draw(triple), (0.0, 0.0, 0.0, 1.0)),
            draw(st.sampled_from([None, *places])),
        )
        for o in objects
    )
    viewpoint = Viewpoint(draw(TEXT), draw(triple), draw(LENGTH))
    return SemanticMap("s", "cargo_sorting", things, made, viewpoint=viewpoint)


@given(maps())
def test_what_is_written_is_read_back(semantic_map: SemanticMap) -> None:
    data = write_map(semantic_map)
    assert parse_map(data) == semantic_map
    assert write_map(parse_map(data)) == data


def test_lengths_are_written_to_a_tenth_of_a_millimetre() -> None:
    thing = MapObject("o", "o", "red", "cube", (0.1, 0.12345, 1), Pose((-0.00001, 2.5, -3), (0.0, 0.0, 0.0, 1.0)))
    data = write_map(SemanticMap("s", "l", (thing,)))
    assert b'size_m="0.1 0.1235 1" xyz_m="0 2.5 -3" quat_xyzw="0 0 0 1"' in data


def test_places_lie_in_places() -> None:
    found = parse_map(
        b"""<SemanticMap scene="s" library="l"><Places>
        <Place id="shelf" type="container"/><Place id="level" type="level" parent="shelf"/>
        <Place id="slot" type="slot" parent="level" buffer="1"/></Places>
        <Objects><Object id="a" place="slot"/><Object id="b" place="level"/><Object id="c"/></Objects></SemanticMap>"""
    )
    assert tuple(found.containers("slot")) == ("level", "shelf")
    assert [p.id for p in found.inside("shelf")] == ["level", "slot"]
    assert [o.id for o in found.on("shelf")] == ["a", "b"]
    assert found.place("slot") == MapPlace("slot", "slot", "slot", "level", True)


HEAD = '<SemanticMap scene="s" library="l">\n<Places>\n<Place id="shelf" type="level"/>\n'
TAIL = "\n</Places><Objects/></SemanticMap>"


@pytest.mark.parametrize(
    ("code", "line", "help_", "place"),
    [
        ("E020", 4, "", '<Place id="shelf" type="slot"/>'),
        ("E021", 4, "did you mean shelf?", '<Place id="slot" type="slot" parent="shelff"/>'),
        ("E021", 4, "declare it", '<Place id="slot" type="slot" parent="zzz"/>'),
        ("E022", 4, "", '<Place id="a" type="slot" parent="a"/>'),
        ("E022", 4, "", '<Place id="a" type="slot" parent="b"/><Place id="b" type="slot" parent="a"/>'),
        ("E006", 4, "", '<Place id="a"/>'),
        ("E006", 4, "", '<Place id="a" type="slot" size="1"/>'),
        ("E006", 4, "", '<Place id="a b" type="slot"/>'),
        ("E006", 4, "", "<Spot/>"),
    ],
)
def test_faults(code: str, line: int, help_: str, place: str) -> None:
    with pytest.raises(LlmbtError) as caught:
        parse_map((HEAD + place + TAIL).encode(), "m.xml")
    found = caught.value.diagnostics[0]
    assert (found.code, found.span and found.span.line) == (code, line)
    assert help_ in found.help


@pytest.mark.parametrize("xyz", ["1 2", "1 2 3 4", "a b c", "nan 0 0", "1e5 0 0", ""])
def test_coordinates_are_three_numbers(xyz: str) -> None:
    data = (
        f'<SemanticMap scene="s" library="l"><Places/><Objects>\n<Object id="a" xyz_m="{xyz}"/></Objects></SemanticMap>'
    )
    with pytest.raises(LlmbtError) as caught:
        parse_map(data.encode())
    assert caught.value.diagnostics[0].code == "E006"


def test_hostile_maps_are_refused(tmp_path: Path) -> None:
    for code, data in {
        "E005": b'<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]><SemanticMap/>',
        "E004": b"<a>" * 100_000 + b"</a>" * 100_000,
        "E003": b"",
    }.items():
        with pytest.raises(LlmbtError) as caught:
            parse_map(data)
        assert caught.value.diagnostics[0].code == code


def test_a_file_that_is_not_there_is_a_diagnostic_with_the_nearest(tmp_path: Path) -> None:
    (tmp_path / "map.xml").write_bytes(b"")
    with pytest.raises(LlmbtError) as caught:
        read_map(tmp_path / "maps.xml")
    (found,) = caught.value.diagnostics
    assert (found.code, found.candidates) == ("E001", ("map.xml",))
    for path in (tmp_path, tmp_path / "no" / "map.xml", tmp_path / ("x" * 300), tmp_path / ("x" * 300) / "y"):
        with pytest.raises(LlmbtError) as caught:
            read_map(path)
        assert caught.value.diagnostics[0].code == "E001"


def test_a_file_without_an_end_is_too_large() -> None:
    with pytest.raises(LlmbtError) as caught:
        read_map(Path("/dev/zero"))
    assert caught.value.diagnostics[0].code == "E002"
