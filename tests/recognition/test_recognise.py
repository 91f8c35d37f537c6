"""Recognition as a whole: rendered scenes in, maps out."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from llmbt_compiler.recognition.doubts import doubts
from llmbt_compiler.recognition.files import read_capture, write_capture
from llmbt_compiler.recognition.recognise import STAGES, recognise
from llmbt_ir.capture import Capture, Gripper, PointCloud
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.geometry import Pose, quat_from_yaw
from llmbt_ir.scene import Camera, Scene, load_scene, scene_names, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap, parse_map, write_map
from llmbt_runtime.bullet.camera import DepthCameras, Snapshot
from llmbt_runtime.perception.rgbd import cloud_of, noisy, project
from llmbt_runtime.perception.rig import cameras_of
from tests.recognition.random_scenes import DEVELOPMENT, REST, Staged, stage

REACHED_OVER = (0.4, 0.6, 0.0, -1.2, 0.0, 1.8, 0.785, 0.0, 0.0, 0.04, 0.04, 0.0)


def seen(scene: Scene, poses: dict[str, Pose], joints: tuple[float, ...] = REST, seed: int = 0) -> Capture:
    """What the scene's cameras see of things at poses, with 1.5 mm of noise."""
    cameras = DepthCameras(scene)
    snapshot, rng = Snapshot(joints, poses), np.random.default_rng(seed)
    try:
        images = [noisy(cameras.look(snapshot, c), 0.0015, rng) for c in cameras_of(scene)]
        return Capture(PointCloud.join([cloud_of(i) for i in images]), cameras.robot(snapshot))
    finally:
        cameras.close()


def start(scene: Scene) -> dict[str, Pose]:
    return {o.id: o.pose for o in scene.objects if o.pose is not None}


@cache
def cargo() -> Capture:
    scene = load_scene("cargo_sorting")
    return seen(scene, start(scene))


def off_m(found: SemanticMap, poses: dict[str, Pose]) -> dict[str, float]:
    return {o.id: math.dist(o.pose.xyz_m, poses[o.id].xyz_m) for o in found.objects}


@pytest.mark.parametrize("name", scene_names())
def test_the_map_of_the_cameras_is_the_scenes_own(name: str) -> None:
    scene = load_scene(name)
    own = to_semantic_map(scene)
    found = recognise(cargo() if name == "cargo_sorting" else seen(scene, start(scene)), scene)
    assert found.places == own.places
    plain = [(o.id, o.name, o.type, o.colour, o.shape, o.size_m, o.place) for o in found.objects]
    assert plain == [(o.id, o.name, o.type, o.colour, o.shape, o.size_m, o.place) for o in own.objects]
    assert max(off_m(found, start(scene)).values()) < 0.003
    assert parse_map(write_map(found)).objects == parse_map(write_map(replace(found, source="x"))).objects


def test_the_stages_are_those_of_the_table() -> None:
    heard: list[str] = []
    recognise(cargo(), load_scene("cargo_sorting"), observe=lambda stage, s: heard.append(stage) if s >= 0 else None)
    assert tuple(heard) == STAGES


def test_the_same_capture_gives_the_same_map_in_another_process_too(tmp_path: Path) -> None:
    scene = load_scene("cargo_sorting")
    write_capture(tmp_path, {"all": cargo().cloud}, cargo())
    here = write_map(recognise(read_capture((tmp_path,)), scene))
    code = (
        "import sys; from pathlib import Path; from llmbt_compiler.recognition.files import read_capture;"
        "from llmbt_compiler.recognition.recognise import recognise; from llmbt_ir.scene import load_scene;"
        "from llmbt_ir.semantic_map import write_map;"
        "m = recognise(read_capture((Path(sys.argv[1]),)), load_scene('cargo_sorting'));"
        "sys.stdout.buffer.write(write_map(m))"
    )
    there = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, check=True).stdout
    assert there == here


@pytest.mark.parametrize("seed", [3, 12])
def test_random_scenes(seed: int) -> None:
    staged = stage(DEVELOPMENT, seed)
    found = recognise(look(staged, seed), staged.told)
    left = {b.id: b for b in staged.truth.objects}
    for thing in found.objects:
        near = min(left.values(), key=lambda b: math.dist(b.pose.xyz_m, thing.pose.xyz_m) if b.pose else math.inf)
        assert near.pose is not None and math.dist(near.pose.xyz_m, thing.pose.xyz_m) < 0.004
        del left[near.id]
        assert np.abs(np.sort(thing.size_m) - np.sort(near.size_m)).max() < 0.005
    assert not left


def look(staged: Staged, seed: int) -> Capture:
    """What a random scene's cameras see."""
    cameras = DepthCameras(staged.truth, staged.paint)
    rng = np.random.default_rng(seed)
    try:
        images = [noisy(cameras.look(staged.snapshot, c), 0.0015, rng) for c in staged.truth.cameras]
        return Capture(PointCloud.join([cloud_of(i) for i in images]), cameras.robot(staged.snapshot))
    finally:
        cameras.close()


def test_things_keep_their_ids_from_one_map_to_the_next() -> None:
    """Three green blocks look alike: the one that has moved is the one whose place is empty."""
    scene = load_scene("cargo_sorting")
    before = recognise(cargo(), scene)
    poses = start(scene)
    moved = {
        **poses,
        "object_4": Pose((0.44, 0.06, 0.4825)),
        "object_6": Pose((0.36, 0.42, 0.4225), quat_from_yaw(0.4)),
    }
    after = recognise(seen(scene, moved), scene, before)
    assert max(off_m(after, moved).values()) < 0.003
    assert {o.id: o.place for o in after.objects}["object_4"] == "position_12"
    # and without the map before, the declared poses decide
    assert max(off_m(recognise(seen(scene, moved), scene), moved).values()) < 0.003


def test_what_nobody_declared_is_an_obstacle_and_keeps_its_name() -> None:
    """The first obstacle_N that the scene does not declare itself."""
    scene = load_scene("cargo_sorting")
    told = replace(scene, objects=scene.objects[1:])
    fresh = f"obstacle_{len(scene.obstacles) + 1}"
    assert fresh not in {b.id for b in scene.obstacles}
    first = recognise(cargo(), told)
    assert [o.id for o in first.objects] == ["object_2", "object_3", "object_4", "object_5", "object_6", fresh]
    stranger = first.objects[-1]
    assert (stranger.name, stranger.colour, stranger.shape) == ("green cube", "green", "cube")
    assert np.abs(np.array(stranger.size_m) - 0.045).max() < 0.006, "neither camera sees its far side"
    poses = {**start(scene), "object_1": Pose((0.44, 0.18, 0.4825))}
    second = recognise(seen(scene, poses), told, first)
    assert next(o for o in second.objects if o.id == fresh).place == "position_11"


@pytest.mark.parametrize("gap_m", [0.012, 0.02])
def test_what_is_half_hidden_lies_behind_what_hides_it(gap_m: float) -> None:
    """No camera sees the sides of the juice across which it may slide and look the same: it ends where what is seen of
    it ends, and what is not seen of it is behind the box."""
    scene = load_scene("household_milk")
    scene = replace(scene, cameras=scene.cameras[:3])
    x, y, z = start(scene)["box"].xyz_m
    juice = Pose((x + 0.06 + gap_m, y, start(scene)["juice"].xyz_m[2]), quat_from_yaw(0.05))
    poses = {"box": Pose((x, y, z)), "juice": juice}
    assert max(off_m(recognise(seen(scene, poses), scene), poses).values()) < 0.003


def test_a_parked_obstacle_is_known_when_it_turns_up() -> None:
    scene = load_scene("cargo_sorting")
    poses = {**start(scene), "obstacle_2": Pose((0.565, -0.06, 0.575))}
    found = {o.id: o for o in recognise(seen(scene, poses), scene).objects}
    assert found["obstacle_2"].place == "position_23" and found["obstacle_2"].name == "purple carton"


def test_touching_blocks_of_one_colour() -> None:
    scene = load_scene("cargo_sorting")
    poses = {**start(scene), "object_2": Pose((0.2, 0.4, 0.4225)), "object_4": Pose((0.155, 0.405, 0.4225))}
    found = recognise(seen(scene, poses), scene)
    assert len(found.objects) == 6 and max(off_m(found, poses).values()) < 0.004


def test_a_block_that_leans_is_on_no_place() -> None:
    scene = load_scene("cargo_sorting")
    tilt = math.radians(28)
    lean = (0.0, math.sin(tilt / 2), 0.0, math.cos(tilt / 2))
    poses = {**start(scene), "object_6": Pose((0.345, 0.1, 0.431), lean)}
    thing = recognise(seen(scene, poses), scene).object("object_6")
    assert thing is not None and thing.place is None
    assert math.dist(thing.pose.xyz_m, poses["object_6"].xyz_m) < 0.006


def test_the_robot_is_no_thing_wherever_its_arm_is() -> None:
    scene = load_scene("cargo_sorting")
    found = recognise(seen(scene, start(scene), REACHED_OVER), scene)
    assert all(o.id.startswith("object_") for o in found.objects)
    # and where nobody tells where its links are, what hangs in the air or stands on its base is taken for it
    blind = replace(cargo(), robot=())
    assert [o.id for o in recognise(blind, scene).objects] == [o.id for o in scene.objects]


def test_what_the_gripper_holds() -> None:
    scene = load_scene("cargo_sorting")
    cameras = DepthCameras(scene)
    closed = (*REST[:9], 0.0225, 0.0225, 0.0)
    tip = cameras.tip(closed)
    cameras.close()
    held = Pose((tip.xyz_m[0], tip.xyz_m[1], tip.xyz_m[2] - 0.008), quat_from_yaw(0.4))
    poses = {**start(scene), "object_5": held}
    capture = replace(seen(scene, poses, closed), gripper=Gripper(tip, gripping=True))
    thing = recognise(capture, scene, recognise(cargo(), scene)).object("object_5")
    assert thing is not None and thing.held and thing.place is None
    assert math.dist(thing.pose.xyz_m, held.xyz_m) < 0.006


DOWN = Camera("down", (0.16, 0.5, 1.5), (0.16, 0.5, 0.4), 45.0)
"""As over a bench: straight down."""


def test_a_camera_may_look_straight_down() -> None:
    """Beside one that sees sides as well."""
    scene = load_scene("cargo_sorting")
    scene = replace(scene, cameras=(scene.cameras[1], DOWN))
    found = recognise(seen(scene, start(scene)), scene)
    assert max(off_m(found, start(scene)).values()) < 0.004 and len(found.objects) == 6


def test_points_lie_where_things_are() -> None:
    """A pixel's ray goes through its middle: the table is at its height and blocks are at their sides, to 0.1 mm."""
    scene = load_scene("cargo_sorting")
    cameras = DepthCameras(scene)
    snapshot = Snapshot(REST, start(scene))
    try:
        for camera in (*scene.cameras, DOWN, replace(DOWN, target_m=(0.161, 0.5, 0.4))):
            image = cameras.look(snapshot, camera)
            cloud = cloud_of(image)
            z = cloud.xyz_m[:, 2]
            assert abs(float(z[np.abs(z - 0.4) < 0.004].mean()) - 0.4) < 1e-4
            pixels, depth = project(camera, cloud.xyz_m, camera.width_px, camera.height_px)
            rows, columns = np.nonzero(np.isfinite(image.depth_m))
            assert (pixels == np.column_stack([columns, rows])).all()
            assert np.abs(depth - image.depth_m[rows, columns]).max() < 1e-9
    finally:
        cameras.close()


@pytest.mark.parametrize("suffix", [".ply", ".pcd"])
def test_clouds_in_files(tmp_path: Path, suffix: str) -> None:
    some = cargo().cloud.take(np.arange(0, 600_000, 300))
    capture = replace(cargo(), gripper=Gripper(Pose((0.1, 0.2, 0.3)), gripping=True))
    written = write_capture(tmp_path, {"one": some, "two": some}, capture, suffix)
    back = read_capture((tmp_path,))
    assert len(back.cloud) == 2 * len(some) and back.coloured
    assert np.abs(back.cloud.xyz_m[: len(some)] - some.xyz_m).max() < 1e-6
    assert np.abs(back.cloud.rgb[: len(some)] - some.rgb).max() < 1e-6
    assert back.gripper == capture.gripper
    assert max(np.abs(a - b).max() for a, b in zip(back.robot, capture.robot, strict=True)) < 1e-4
    assert len(read_capture((written[0],)).cloud) == len(some)


def test_a_users_own_file(tmp_path: Path) -> None:
    """ASCII, double precision, colours as the field's tools write them; and one without colours."""
    cloud = cargo().cloud.take(np.arange(0, len(cargo().cloud), 3))
    rows = np.column_stack([cloud.xyz_m, np.round(cloud.rgb * 255)])
    head = "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
    colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    path, bare = tmp_path / "own.ply", tmp_path / "bare.ply"
    for file, properties, form in ((path, colours, "%.6f %.6f %.6f %d %d %d"), (bare, "", "%.6f %.6f %.6f")):
        columns = rows[:, : form.count("%")]
        np.savetxt(file, columns, form, header=head.format(len(rows)) + properties + "end_header", comments="")
    scene = load_scene("cargo_sorting")
    assert [o.id for o in recognise(read_capture((path,)), scene).objects] == [o.id for o in scene.objects]
    colourless = read_capture((bare,))
    assert not colourless.coloured
    assert max(off_m(recognise(colourless, scene), start(scene)).values()) < 0.004


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("none.ply", None, "E001"),
        ("cloud.obj", "v 1 2 3", "E451"),
        ("bad.ply", "hello", "E451"),
        ("bad.pcd", "hello", "E451"),
        ("empty.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nend_header\n", "E451"),
    ],
)
def test_what_is_no_cloud(tmp_path: Path, name: str, content: str | None, code: str) -> None:
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(LlmbtError) as fault:
        read_capture((tmp_path / name,))
    assert fault.value.diagnostics[0].code == code


def test_one_point_is_no_way_apart_from_others() -> None:
    one = Capture(PointCloud(np.array([[0.3, 0.3, 0.4]]), np.full((1, 3), 0.5)))
    assert [(d.code, d.title) for d in doubts(one, load_scene("cargo_sorting"))] == [("W454", "it has one point there")]


@pytest.mark.parametrize("suffix", [".ply", ".pcd"])
@pytest.mark.parametrize("ascii_", [False, True])
def test_a_torn_cloud_is_none(tmp_path: Path, suffix: str, ascii_: bool) -> None:
    """As a copy that was broken off leaves it: its reader would fill up what is missing."""
    from llmbt_compiler.recognition.open3d import open3d

    o3d = open3d()
    whole = o3d.t.geometry.PointCloud(o3d.core.Tensor(cargo().cloud.xyz_m[:500].astype(np.float32)))
    whole.point.colors = o3d.core.Tensor(np.round(cargo().cloud.rgb[:500] * 255).astype(np.uint8))
    path = tmp_path / f"whole{suffix}"
    o3d.t.io.write_point_cloud(str(path), whole, write_ascii=ascii_)
    assert len(read_capture((path,)).cloud) == 500
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(LlmbtError, match=r"promises 500 points, and it holds 4\d\d") as fault:
        read_capture((path,))
    assert fault.value.diagnostics[0].code == "E451"


def test_coordinates_that_nothing_has(tmp_path: Path) -> None:
    head = "ply\nformat ascii 1.0\nelement vertex 2\n" + "".join(f"property float {a}\n" for a in "xyz")
    (tmp_path / "far.ply").write_text(head + "end_header\n0.1 0.2 0.3\n0.1 nan 4.6e32\n")
    with pytest.raises(LlmbtError, match="beyond 1e\\+07"):
        read_capture((tmp_path / "far.ply",))


@pytest.mark.parametrize("content", ["", "[]", '{"clouds": ["../x.ply"]}', '{"clouds": []}'])
def test_what_is_no_capture(tmp_path: Path, content: str) -> None:
    (tmp_path / "capture.json").write_text(content)
    with pytest.raises(LlmbtError) as fault:
        read_capture((tmp_path,))
    assert fault.value.diagnostics[0].code == "E452"
