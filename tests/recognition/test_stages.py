"""Each stage of recognition against what is known of it: an oracle, a real counterpart, or points made for it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from llmbt_compiler.recognition.cluster import parts
from llmbt_compiler.recognition.colour import lab_of, term_of
from llmbt_compiler.recognition.explain import explain
from llmbt_compiler.recognition.measure import footprint, measure, top_of
from llmbt_compiler.recognition.open3d import open3d
from llmbt_compiler.recognition.registration import register
from llmbt_compiler.recognition.segment import without_fixtures, without_robot
from llmbt_compiler.recognition.solids import Fit, Geometry, Kind, distances, fit, orientations, quat_of, yaw_matrix
from llmbt_compiler.recognition.split import split
from llmbt_ir.capture import PointCloud
from llmbt_ir.scene import COLOURS, load_scene

Array = NDArray[np.float64]
SOLIDS = (
    Geometry(Kind.BOX, (0.045, 0.06, 0.08)),
    Geometry(Kind.CYLINDER, (0.05, 0.05, 0.09)),
    Geometry(Kind.SPHERE, (0.06, 0.06, 0.06)),
)


def surface(geometry: Geometry, rng: np.random.Generator, n: int = 1500) -> Array:
    """Points all over a solid, in its frame."""
    x, y, z = np.asarray(geometry.size_m) / 2
    if geometry.kind is Kind.SPHERE:
        p = rng.normal(size=(n, 3))
        return np.asarray(p / np.linalg.norm(p, axis=1, keepdims=True) * x)
    if geometry.kind is Kind.CYLINDER:
        turn, up = rng.uniform(0, 2 * math.pi, n), rng.uniform(-z, z, n)
        r = np.full(n, x)
        ends = rng.random(n) < 0.4
        r[ends], up[ends] = x * np.sqrt(rng.random(ends.sum())), z * rng.choice([-1, 1], ends.sum())
        return np.column_stack([r * np.cos(turn), r * np.sin(turn), up])
    p = rng.uniform(-1, 1, (n, 3))
    side = rng.integers(0, 3, n)
    p[np.arange(n), side] = rng.choice([-1, 1], n)
    return np.asarray(p * (x, y, z))


def seen(geometry: Geometry, rotation: Array, xyz: Array, seed: int = 0, noise_m: float = 0.0012) -> Array:
    """The points of a solid at a pose that two cameras see, with noise."""
    rng = np.random.default_rng(seed)
    p = surface(geometry, rng, 4000)
    step = 1e-5
    normals = np.column_stack(
        [(distances(geometry, p + step * e) - distances(geometry, p - step * e)) / (2 * step) for e in np.eye(3)]
    )
    rays = np.array([[0.8, 0.3, 0.6], [-0.6, 0.5, 0.7]])
    visible = ((normals @ rotation.T) @ rays.T > 0.2).any(axis=1)
    p = p[visible][:1500]
    return np.asarray(p @ rotation.T + xyz + rng.normal(0, noise_m, p.shape))


@pytest.mark.parametrize("geometry", SOLIDS, ids=lambda g: g.kind)
def test_distances_are_those_of_open3d(geometry: Geometry) -> None:
    o3d = open3d()
    x, y, z = geometry.size_m
    mesh = {
        Kind.BOX: lambda: o3d.geometry.TriangleMesh.create_box(x, y, z).translate((-x / 2, -y / 2, -z / 2)),
        Kind.CYLINDER: lambda: o3d.geometry.TriangleMesh.create_cylinder(x / 2, z, 400, 4),
        Kind.SPHERE: lambda: o3d.geometry.TriangleMesh.create_sphere(x / 2, 200),
    }[geometry.kind]()
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(mesh))
    points = np.random.default_rng(0).uniform(-0.08, 0.08, (500, 3))
    theirs = scene.compute_signed_distance(o3d.core.Tensor(points.astype(np.float32))).numpy()
    ours = distances(geometry, points)
    outside = theirs > 0
    assert np.abs(ours[outside] - theirs[outside]).max() < 5e-5
    assert (np.sign(ours) == np.sign(theirs))[np.abs(theirs) > 1e-4].all()


@pytest.mark.parametrize("geometry", SOLIDS, ids=lambda g: g.kind)
@given(yaw=st.floats(-3, 3), dx=st.floats(-0.006, 0.006), dy=st.floats(-0.006, 0.006))
def test_a_fit_finds_the_pose_that_points_were_made_with(geometry: Geometry, yaw: float, dx: float, dy: float) -> None:
    way = next(orientations(geometry))
    xyz = np.array([0.2, -0.1, 0.4 + way.extents_m[2] / 2])
    points = seen(geometry, yaw_matrix(yaw), xyz)
    found = fit(geometry, way, np.array([xyz[0] + dx, xyz[1] + dy, xyz[2], yaw + 0.1]), points)
    assert math.dist(found.xyz_m, xyz) < 0.0006
    if geometry.kind is Kind.BOX:
        assert abs(found.rotation - yaw_matrix(yaw)).max() < 0.02


@given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3))
def test_quaternions_turn_as_their_matrices_do(a: float, b: float, c: float) -> None:
    flat = np.array([[1, 0, 0], [0, math.cos(b), -math.sin(b)], [0, math.sin(b), math.cos(b)]])
    rotation = yaw_matrix(a) @ flat @ yaw_matrix(c)
    x, y, z, w = quat_of(rotation)
    assert math.isclose(x * x + y * y + z * z + w * w, 1.0)
    back = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    assert np.abs(back - rotation).max() < 1e-9


@given(st.integers(0, 10_000))
def test_clusters_are_those_of_a_naive_dbscan(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middles = rng.uniform(0, 0.08, (4, 5))
    points = middles[rng.integers(0, 4, 250)] + rng.normal(0, 0.003, (250, 5))
    near = np.linalg.norm(points[:, None] - points[None], axis=2) < 0.0075
    core = near.sum(axis=1) >= 8
    label = np.full(250, -1)
    for start in np.flatnonzero(core):
        if label[start] < 0:
            front = [start]
            label[start] = start
            while front:
                here = front.pop()
                for other in np.flatnonzero(near[here] & core & (label < 0)):
                    label[other] = start
                    front.append(other)
    naive = {frozenset(np.flatnonzero(label == k).tolist()) for k in set(label[core].tolist())}
    ours = [frozenset(p.tolist()) for p in parts(points, 1)]
    cores = set(np.flatnonzero(core).tolist())
    assert {p & cores for p in ours} == naive
    border = {i for i in range(250) if not core[i] and (near[i] & core).any()}
    assert set().union(*ours, set()) == cores | border


@pytest.mark.parametrize(
    ("rgb", "lab"),  # Lindbloom's calculator, sRGB and D65
    [((1, 1, 1), (100, 0, 0)), ((1, 0, 0), (53.24, 80.09, 67.20)), ((0, 0, 1), (32.30, 79.19, -107.86))],
)
def test_cielab(rgb: tuple[float, ...], lab: tuple[float, ...]) -> None:
    assert np.abs(lab_of(np.array([rgb], dtype=float))[0] - lab).max() < 0.02


@pytest.mark.parametrize("term", sorted(set(COLOURS) - {"silver", "beige", "wood"}))
def test_the_scenes_colours_have_their_own_names(term: str) -> None:
    assert term_of(np.array(COLOURS[term])) == term


@pytest.mark.parametrize("geometry", SOLIDS, ids=lambda g: g.kind)
def test_shape_and_size_are_measured_without_a_list(geometry: Geometry) -> None:
    for seed, way in enumerate(orientations(geometry)):
        rotation = yaw_matrix(0.3) @ np.array(way.turn)
        points = seen(geometry, rotation, np.array([0.1, 0.2, 0.4 + way.extents_m[2] / 2]), seed)
        found = measure(points[points[:, 2] > 0.405], 0.4)
        assert found.geometry.kind is geometry.kind
        assert np.abs(np.sort(found.geometry.size_m) - np.sort(geometry.size_m)).max() < 0.004
        assert math.dist(found.xyz_m, (0.1, 0.2, 0.4 + way.extents_m[2] / 2)) < 0.003


def test_a_footprint_is_the_least_rectangle() -> None:
    points = seen(SOLIDS[0], yaw_matrix(0.4), np.array([0.0, 0.0, 0.04]))
    found = footprint(points)
    assert abs(found.yaw_rad - 0.4) < 0.03
    assert np.abs(np.sort(found.size_m) - (0.045, 0.06)).max() < 0.007  # the noise is in it
    assert abs(top_of(points) - 0.08) < 0.001


def test_what_is_known_goes() -> None:
    fixture = load_scene("cargo_sorting").fixtures[0]
    above = np.array([[0.2, 0.2, fixture.top_m + h] for h in (-0.1, 0.0, 0.004, 0.006, 0.1)])
    left = without_fixtures(PointCloud(above, above), [fixture])
    assert left.xyz_m[:, 2].tolist() == [fixture.top_m + 0.006, fixture.top_m + 0.1]
    link = surface(SOLIDS[1], np.random.default_rng(0))
    points = np.array([[0, 0, 0], [0.02, 0, 0.04], [0.05, 0, 0], [0, 0, 0.07]], dtype=float)
    assert without_robot(PointCloud(points, points), [link]).xyz_m.tolist() == points[2:].tolist()


def touching(geometry: Geometry, offsets: list[tuple[float, float]], yaw: float) -> tuple[Array, list[Array]]:
    """Things beside each other, and where each is."""
    rotation = yaw_matrix(yaw)
    half = geometry.size_m[2] / 2
    at = [rotation @ np.array([x, y, 0]) + (0.2, 0.4, 0.4 + half) for x, y in offsets]
    points = np.concatenate([seen(geometry, rotation, xyz, k)[:700] for k, xyz in enumerate(at)])
    return points[points[:, 2] > 0.405], at


@pytest.mark.parametrize(
    "offsets",
    [
        [(0.0, 0.0), (0.0, 0.045)],
        [(0.0, 0.0), (0.015, 0.045)],
        [(0.0, 0.0), (0.0, 0.045), (0.0, 0.09)],
        [(0.0, 0.0), (0.045, 0.0), (0.0, 0.045)],
    ],
    ids=["pair", "staggered", "row", "corner"],
)
def test_touching_things_of_one_colour_are_split(offsets: list[tuple[float, float]]) -> None:
    cube = Geometry(Kind.BOX, (0.045, 0.045, 0.045))
    points, at = touching(cube, offsets, 0.5)
    found = split(points, 0.4, {cube: 4, Geometry(Kind.BOX, (0.05, 0.05, 0.1)): 1})
    assert len(found) == len(at)
    for xyz in at:
        assert min(math.dist(f.xyz_m, xyz) for f, _ in found) < 0.002
    assert sorted(np.concatenate([i for _, i in found]).tolist()) == list(range(len(points)))


def test_what_is_one_thing_is_not_split() -> None:
    plank = Geometry(Kind.BOX, (0.045, 0.11, 0.045))
    points = seen(plank, yaw_matrix(0.2), np.array([0.2, 0.4, 0.4225]))
    points = points[points[:, 2] > 0.405]
    assert split(points, 0.4, {Geometry(Kind.BOX, (0.045, 0.045, 0.045)): 3}) == []
    assert explain(points, measure(points, 0.4), 0.4, [plank])[0].geometry == plank


@pytest.mark.parametrize("geometry", SOLIDS[:2], ids=lambda g: g.kind)
def test_what_leans_is_registered(geometry: Geometry) -> None:
    tilt = math.radians(35)
    lean = np.array([[1, 0, 0], [0, math.cos(tilt), -math.sin(tilt)], [0, math.sin(tilt), math.cos(tilt)]])
    xyz = np.array([0.2, 0.4, 0.46])
    points = seen(geometry, yaw_matrix(0.7) @ lean, xyz)
    found = register(points, geometry)
    assert math.dist(found.xyz_m, xyz) < 0.003
    assert found.tail_m < 0.003 and not found.level
    axis = found.rotation[:, 2] if geometry.kind is Kind.CYLINDER else None
    if axis is not None:
        assert abs(axis @ (yaw_matrix(0.7) @ lean)[:, 2]) > 0.998
    for again in (register(points, geometry) for _ in range(4)):
        assert again.xyz_m == found.xyz_m and np.array_equal(again.rotation, found.rotation)


def test_a_fit_tells_distances() -> None:
    geometry = SOLIDS[0]
    found = Fit.at(geometry, np.zeros(3), np.eye(3), np.array([[0.0, 0.0, 0.05]]), level=True)
    assert found.off_m == pytest.approx(0.01)
    assert found.off(np.array([[0.0, 0.0, 0.0]]))[0] == pytest.approx(-0.0225)
