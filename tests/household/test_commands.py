"""`llmbt scene`, films, variation: what a person calls."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import pytest

from llmbt.main import main
from llmbt_ir.scene import Scene, load_scene
from llmbt_ir.solids import overlaps
from llmbt_runtime.chance import chance
from llmbt_runtime.variation import varied

SHIPPED = ("cargo_sorting", "cargo_swap", "household")


def called(capfd: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = main([str(a) for a in arguments])
    out, err = capfd.readouterr()
    return code, out, err


def as_json(capfd: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, dict[str, Any]]:
    code, out, _ = called(capfd, *arguments, "--json")
    return code, json.loads(out)


# ------------------------------------------------------------------------------------------------ scene


def test_the_list_says_what_each_scene_is(capfd: pytest.CaptureFixture[str]) -> None:
    code, found = as_json(capfd, "scene", "list")
    by_name = {s["name"]: s for s in found["scenes"]}
    assert code == 0 and set(SHIPPED) <= set(by_name)
    assert by_name["household"]["robot"] == "mobile_panda" and by_name["cargo_sorting"]["objects"] == 6


def test_a_scene_in_words_and_as_a_picture(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    code, out, _ = called(capfd, "scene", "show", "household")
    assert code == 0 and "bar (location): milk (white box), coke (red cylinder)" in out
    file = tmp_path / "bar.png"
    code, found = as_json(capfd, "scene", "show", "household", "-o", file, "--camera", "bar_left", "--size", "96x64")
    assert code == 0 and found["file"] == str(file) and len(found["objects"]) == 10
    assert file.read_bytes().startswith(b"\x89PNG")
    assert called(capfd, "scene", "show", "household", "-o", file, "--camera", "attic")[0] == 2
    assert called(capfd, "scene", "show", "household", "-o", file, "--size", "wide")[0] == 2


@pytest.mark.parametrize("name", [*SHIPPED, "docs/examples/depot.xml", "docs/examples/pantry.xml"])
def test_the_shipped_scenes_are_in_order(capfd: pytest.CaptureFixture[str], name: str) -> None:
    path = Path(__file__).resolve().parents[2] / name
    code, found = as_json(capfd, "scene", "check", path if path.is_file() else name, "--strict")
    assert (code, found["diagnostics"]) == (0, [])


def edited(tmp_path: Path, scene: str, old: str, new: str) -> Path:
    text = Path(load_scene(scene).source).read_text(encoding="utf-8")
    assert text.count(old) == 1
    path = tmp_path / "scene.xml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


PANDA, MOBILE = '<Robot model="panda" xyz_m="0 0 0.4"/>', '<Robot model="mobile_panda" xyz_m="0 0 0.4"/>'
STEP = '{}"/>\n    <Fixture id="step_2"'
WRONG = [
    ("cargo_sorting", "E042", 'offset_m="0.17 0.06"', 'offset_m="0.06 0.06"', "`object_5` overlaps `object_3`"),
    ("cargo_sorting", "E020", 'id="object_5"', 'id="object_3"', "id `object_3` is used twice"),
    ("cargo_sorting", "E048", PANDA, PANDA.replace("0 0 0.4", "-0.25 0 0.4"), "out of the arm's reach"),
    ("cargo_sorting", "E049", PANDA, PANDA.replace("0 0 0.4", "-0.08 0 0.4"), "`position_34` is out of reach"),
    ("cargo_sorting", "E021", STEP.format("shelf"), STEP.format("shef"), "unknown place `shef`"),
    ("household", "E049", '1.53 0 0.46" size_m="0.28 0.62', '1.53 0 0.46" size_m="0.38 1.00', "`bar` is out of reach"),
    ("household", "E042", MOBILE, MOBILE.replace("0 0 0.4", "-0.7 -1.45 0.4"), "the robot overlaps a fixture"),
    ("household", "E044", "0.065 0.065 0.17", "0.085 0.085 0.17", "wider than the gripper opens"),
    (
        "household",
        "E036",
        'id="shelf" type="location"',
        'id="shelf" type="slott"',
        "which library `household` does not",
    ),
]


@pytest.mark.parametrize(("scene", "code", "old", "new", "title"), WRONG, ids=[f"{w[0]}-{w[1]}" for w in WRONG])
def test_what_a_scene_gets_wrong_is_found(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, scene: str, code: str, old: str, new: str, title: str
) -> None:
    exit_code, found = as_json(capfd, "scene", "check", edited(tmp_path, scene, old, new))
    assert exit_code == 6
    hits = [d for d in found["diagnostics"] if d["code"] == code and title in d["title"]]
    assert hits, found["diagnostics"]


def test_a_thing_that_cannot_be_taken_is_a_warning(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    corner = edited(tmp_path, "cargo_sorting", 'offset_m="0.17 -0.07"', 'offset_m="0.09 -0.07"')
    code, found = as_json(capfd, "scene", "check", corner)
    assert code == 0 and {d["code"] for d in found["diagnostics"]} <= {"W049"}
    assert called(capfd, "scene", "check", tmp_path / "none.xml")[0] == 1


def test_the_pantry_of_the_worked_example(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """docs/own-scene.md, by the letter."""
    examples = Path(__file__).resolve().parents[2] / "docs" / "examples"
    request, scene, tape = "Bring the guest the lemonade.", examples / "pantry.xml", tmp_path / "pantry.yaml"
    reply = ["--reply", examples / "pantry-reply.txt", "-o", tape]
    assert called(capfd, "cassette", "author", request, "--scene", scene, *reply)[0] == 0
    order = ["run", request, "--scene", scene, "--cassette", tape, "-o", tmp_path / "o", "--disturb", "base_blocked"]
    code, found = as_json(capfd, *order)
    assert code == 0 and [(g["name"], g["args"]) for g in found["goals"]] == [("On", ["lemonade", "guest"])]
    assert [d["name"] for d in found["disturbances"]] == ["base_blocked"]
    assert "clear_way" in [a["name"] for a in found["actions"]]


# ------------------------------------------------------------------------------------------------ films, variation


def tree(tmp_path: Path) -> Path:
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M"><ReactiveSequence>'
        '<Holding target="milk"/></ReactiveSequence></BehaviorTree></root>',
        encoding="utf-8",
    )
    return path


def test_a_film_of_a_run(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    from PIL import Image

    film = tmp_path / "run.gif"
    order = ["execute", tree(tmp_path), "--scene", "household", "-q"]
    code, _, err = called(capfd, *order, "-o", tmp_path / "a", "--video", film)
    assert code == 0, err
    with Image.open(film) as picture:
        assert picture.format == "GIF" and 8 <= picture.n_frames <= 40 and picture.size == (480, 320)
    plain = called(capfd, *order, "-o", tmp_path / "b")
    assert plain[0] == 0
    runs = [json.loads((tmp_path / x / "result.json").read_bytes()) for x in "ab"]
    assert runs[0]["sim_time_s"] == runs[1]["sim_time_s"] and runs[0]["objects"] == runs[1]["objects"]


def test_what_cannot_be_filmed_is_said_before_anything_runs(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    order = ["execute", tree(tmp_path), "--scene", "household", "--force", "-o", tmp_path / "o"]
    for more, code in (
        (["--video", "x.avi"], "E067"),
        (["--video", "x.gif", "--world", "symbolic"], "E067"),
        (["--gui"], "E068"),
    ):
        exit_code, found = as_json(capfd, *order, *more)
        assert exit_code == 2 and found["diagnostics"][0]["code"] == code


@pytest.mark.extras
@pytest.mark.skipif(importlib.util.find_spec("imageio_ffmpeg") is None, reason="the extra `video`")
def test_a_film_as_mp4(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    film = tmp_path / "run.mp4"
    order = ["execute", tree(tmp_path), "--scene", "household", "-q", "-o", tmp_path / "a", "--video", film]
    assert called(capfd, *order)[0] == 0
    assert film.read_bytes()[4:8] == b"ftyp"


@pytest.mark.parametrize("name", SHIPPED)
def test_a_varied_scene_is_the_same_scene_a_little_off(name: str) -> None:
    scene = load_scene(name)
    seen: set[tuple[float, ...]] = set()
    for seed in range(20):
        other = varied(scene, chance(seed, "vary"))
        assert other == varied(scene, chance(seed, "vary"))
        assert not list(overlaps(other.fixtures, other.objects, other.robot_xyz_m, other.robot))
        assert [where(other, o.id) for o in other.objects] == [where(scene, o.id) for o in scene.objects]
        for a, b in zip(scene.objects, other.objects, strict=True):
            assert a.pose is not None and b.pose is not None
            assert max(abs(p - q) for p, q in zip(a.pose.xyz_m[:2], b.pose.xyz_m[:2], strict=True)) <= 0.015
            assert min(b.size_m[:2]) <= 0.07 and abs(b.mass_kg / a.mass_kg - 1) <= 0.2
        seen.add(other.objects[0].size_m)
    assert len(seen) == 20


def where(scene: Scene, id_: str) -> str | None:
    body = next(o for o in scene.objects if o.id == id_)
    assert body.pose is not None
    x, y, z = body.pose.xyz_m
    return scene.most_specific(x, y, z - body.size_m[2] / 2)
