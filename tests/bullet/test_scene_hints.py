"""What a scene hardly means, in scenes of a few lines; each hint names its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_ir.condition import Condition
from llmbt_ir.scene import Scene, load_scene, parse_scene, to_semantic_map
from llmbt_ir.scene_hints import hints
from llmbt_runtime.bullet.checking import findings
from llmbt_runtime.bullet.world import BulletWorld

CARGO = {"slot", "region", "buffer"}
ROBOT = '<Robot model="panda" xyz_m="0 0 0.3"/>'
TABLE = '<Fixture id="table" xyz_m="0.3 0 0.15" size_m="1.2 1.2 0.3"/>'
SLOT = '<Place id="p" type="slot" surface_m="0.5 0 0.3" size_m="0.1 0.1"/>'
ASIDE = '<Place id="aside" type="buffer" buffer="true" surface_m="0.4 0.3 0.3" size_m="0.2 0.2"/>'
CUBE = '<Object id="o" colour="red" shape="cube" size_m="0.04 0.04 0.04" xyz_m="0.4 0.3 0.32"/>'


def scene(places: str = SLOT, *, robot: str = ROBOT, aside: str = ASIDE, objects: str = CUBE) -> Scene:
    text = f"""<Scene name="mine" library="cargo_sorting">{robot}
<Fixtures>{TABLE}</Fixtures><Places>{aside}
{places}
</Places><Objects>
{objects}
</Objects></Scene>"""
    return parse_scene(text.encode())


def found(made: Scene, *, drives: bool = False) -> list[tuple[str, str, int]]:
    return [(d.code, d.title, d.span.line if d.span is not None else 0) for d in hints(made, CARGO, drives=drives)]


def test_a_scene_in_order() -> None:
    assert found(scene()) == []


@pytest.mark.parametrize(
    ("places", "code", "says"),
    [
        (SLOT.replace("0.5 0 0.3", "0.5 0.6 0.3"), "W047", "under 50 % of `p` only"),
        (SLOT.replace("slot", "region").replace("0.5 0 0.3", "0.5 0 0.5"), "E047", "no fixture's top is at 0.5 m"),
        (SLOT + SLOT.replace('"p"', '"q"').replace("0.5 0", "0.53 0"), "W042", "`p` and `q` overlap"),
        (SLOT.replace("0.5 0 0.3", "0.4 0.2 0.3"), "W042", "`p` and `aside` overlap, and neither is in the other"),
    ],
)
def test_places(places: str, code: str, says: str) -> None:
    ((given, title, line),) = found(scene(places))
    assert (given, line) == (code, 3) and says in title


def test_places_in_one_another_overlap_rightly() -> None:
    assert found(scene(SLOT.replace('id="p"', 'id="p" parent="aside"').replace("0.5 0 0.3", "0.4 0.2 0.3"))) == []


@pytest.mark.parametrize(
    ("objects", "code", "says"),
    [
        (CUBE.replace("0.4 0.3 0.32", "0.4 -0.3 0.32"), "W041", "`o` is on no place"),
        (CUBE.replace("0.4 0.3 0.32", "0.4 0.3 0.5"), "W041", "nothing is under it at 0.48 m"),
        (CUBE.replace("0.04 0.04 0.04", "0.001 0.001 0.001").replace("0.32", "0.3005"), "W044", "1 mm small"),
    ],
)
def test_things(objects: str, code: str, says: str) -> None:
    ((given, title, line),) = found(scene(objects=objects))
    assert (given, line) == (code, 5) and says in title


def test_what_stands_on_another_thing_is_on_no_place() -> None:
    on_it = CUBE.replace('id="o"', 'id="upper"').replace("0.32", "0.36")
    ((code, title, line),) = found(scene(objects=f"{CUBE}\n{on_it}"))
    assert (code, line) == ("W041", 6) and "it stands on `o`" in title


def test_the_robot() -> None:
    ((code, title, _),) = found(scene(robot=ROBOT.replace("0 0 0.3", "0 0 0.1")))
    assert code == "E042" and "the robot stands in `table`, whose top is at 0.3 m" in title
    ((code, title, _),) = found(scene(), drives=True)
    assert code == "E023" and "bolted down" in title
    ((code, title, _),) = found(scene(robot='<Robot model="mobile_panda" xyz_m="-1 0 0.4"/>'))
    assert code == "W023" and "it stays where it stands" in title


def test_nowhere_to_put_things_aside() -> None:
    region = ASIDE.replace('type="buffer" buffer="true"', 'type="region"')
    ((code, title, _),) = found(scene(aside=region))
    assert code == "W045" and "no place is a buffer" in title


@pytest.mark.parametrize("slot", ["p", "a_slot"])
def test_a_slot_goes_before_a_region_of_its_depth_whatever_they_are_called(slot: str) -> None:
    places = SLOT.replace('"p"', f'"{slot}"') + '<Place id="b" type="region" surface_m="0.3 0 0.3" size_m="1.2 1.2"/>'
    made = scene(places, aside="", objects=CUBE.replace("0.4 0.3 0.32", "0.5 0 0.32"))
    assert to_semantic_map(made).objects[0].place == slot
    world = BulletWorld(made)
    try:
        facts = {c for c in world.observe() if c.name == "On"}
    finally:
        world.close()
    assert facts == {Condition("On", ("o", slot))}


# ------------------------------------------------------------------------------------------------ what the arm can do

TALL = '<Object id="tall" colour="red" shape="cylinder" size_m="0.04 0.04 0.1" on="aside"/>'
FAR = ASIDE.replace("0.4 0.3 0.3", "0.15 0.55 0.3")


def warned(made: Scene) -> list[tuple[str, str, int]]:
    return [(d.code, d.title, d.span.line if d.span is not None else 0) for d in findings(made)]


@pytest.mark.parametrize(
    ("change", "said"), [('mass_kg="40"', "40 kg"), ('friction="0.01"', "a friction of 0.01"), ('mass_kg="1"', None)]
)
def test_what_slips_out_of_the_fingers(change: str, said: str | None) -> None:
    told = warned(scene(objects=CUBE.replace("shape", f"{change} shape")))
    assert [(code, line) for code, _, line in told] == ([("W044", 5)] if said else [])
    assert said is None or said in told[0][1]


def test_a_cylinder_that_nobody_sets_upright_again() -> None:
    assert warned(scene(objects=TALL)) == []
    ((code, title, line),) = warned(scene(aside=FAR, objects=TALL))
    assert (code, line) == ("W045", 5) and "`tall` is lost when it falls over" in title
    assert warned(scene(aside=FAR, objects=TALL.replace("0.04 0.1", "0.04 0.03"))) == [], "a disc stays as it is"


def test_a_place_without_a_surface_where_the_robot_drives() -> None:
    """Another's ward (fixtures/requests/scenes): a tray, a rack, a shelf and a crate that are but their parts."""
    ward = load_scene(str(Path(__file__).parents[2] / "fixtures" / "requests" / "scenes" / "ward.xml"))
    told = {title.split("`")[1] for code, title, _ in warned(ward) if code == "W046"}
    assert told == {"pill_tray", "saline_rack", "dressing_shelf", "pharmacy_crate"}
