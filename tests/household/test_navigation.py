"""Ways over the floor and poses to stand at, against a naive search and against pybullet's own distances."""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise

import numpy as np
import pytest

from llmbt_ir.scene import PLATFORM_RADIUS_M, load_scene
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.docking import find_docks
from llmbt_runtime.bullet.navigation import MARGIN_M, Floor, Footprint
from llmbt_runtime.bullet.stage import Stage

Point = tuple[float, float]


def room(rng: np.random.Generator, boxes: int) -> Floor:
    things = tuple(
        Footprint(
            f"box_{i}",
            (float(rng.uniform(-1.6, 1.6)), float(rng.uniform(-1.6, 1.6))),
            (float(rng.uniform(0.02, 0.4)), float(rng.uniform(0.02, 0.4))),
            float(rng.uniform(0, math.pi)),
            0.5,
        )
        for i in range(boxes)
    )
    return Floor(things, (-2.0, -2.0), (2.0, 2.0))


def flooded(floor: Floor, start: Point, end: Point, cell_m: float = 0.05) -> bool:
    """Whether a platform gets there in steps of a cell, by flooding: with the margin at every point."""

    def clear(p: Point) -> bool:
        return bool(floor.room(np.array([p[0]]), np.array([p[1]]))[0] >= MARGIN_M)

    def key(p: Point) -> tuple[int, int]:
        return round(p[0] / cell_m), round(p[1] / cell_m)

    seen, todo = {key(start)}, deque([key(start)])
    while todo:
        i, j = todo.popleft()
        if (i, j) == key(end):
            return True
        for a, b in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            p = (a * cell_m, b * cell_m)
            if (a, b) not in seen and min(p) >= -2 and max(p) < 2 and clear(p):
                seen.add((a, b))
                todo.append((a, b))
    return False


@pytest.mark.parametrize("seed", range(4))
def test_a_route_is_found_just_where_there_is_one_and_keeps_off_everything(seed: int) -> None:
    rng = np.random.default_rng(seed)
    floor = room(rng, int(rng.integers(4, 16)))
    ends = [(x, y) for x in (-1.8, 0.0, 1.8) for y in (-1.8, 0.0, 1.8)]
    ends = [p for p in ends if floor.room(np.array([p[0]]), np.array([p[1]]))[0] > 0.1]
    for start, end in pairwise(ends):
        route = floor.route(start, end)
        assert (route is not None) == flooded(floor, start, end)
        if route is None:
            continue
        assert route[0] == start and route[-1] == end
        for a, b in pairwise(route):
            for s in np.linspace(0, 1, 50):
                p = np.array([a[0] + s * (b[0] - a[0])]), np.array([a[1] + s * (b[1] - a[1])])
                assert floor.room(*p)[0] > 0.0


def test_the_distance_to_a_turned_box_is_the_true_one() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        box = Footprint("b", (0.3, -0.2), tuple(rng.uniform(0.05, 0.5, 2)), float(rng.uniform(0, 3)))  # type: ignore[arg-type]
        c, s = math.cos(box.yaw_rad), math.sin(box.yaw_rad)
        u, v = np.meshgrid(*(np.linspace(-h, h, 81) for h in box.half_m))
        x, y = 0.3 + c * u - s * v, -0.2 + s * u + c * v
        p = rng.uniform(-1, 1, 2)
        nearest = float(np.hypot(x - p[0], y - p[1]).min())
        assert abs(float(box.distance(p[:1], p[1:])[0]) - nearest) < 0.02


def test_every_location_has_docking_poses_that_reach_it_and_keep_off_everything() -> None:
    scene = load_scene("household")
    approach = Approach(Stage(scene))
    docks = find_docks(scene, approach)
    floor = Floor.of(scene)
    assert set(docks.of) == {"table", "bar", "desk", "shelf", "user"}
    for place in scene.places:
        assert len(docks[place.id]) >= 2, f"{place.id}: another way to stand there"
        assert place.surface_m is not None
        for dock in docks[place.id]:
            assert floor.room(np.array([dock.x_m]), np.array([dock.y_m]), low_only=True)[0] > 0.01
            assert floor.connected((0.0, 0.0), (dock.x_m, dock.y_m))
            corners = [
                (
                    place.surface_m[0] + i * (place.size_m[0] / 2 - 0.03),
                    place.surface_m[1] + j * (place.size_m[1] / 2 - 0.03),
                )
                for i in (-1, 1)
                for j in (-1, 1)
            ]
            assert approach.reaches(dock, [(x, y, place.surface_m[2] + 0.1) for x, y in corners])
    mine = [(p, d) for p, ds in docks.of.items() for d in ds]
    for i, (p, a) in enumerate(mine):
        for q, b in mine[i + 1 :]:
            assert p == q or a.far_from(b)[0] > 0.2, "two locations at one pose"
    approach.close()


def test_what_is_tall_keeps_the_arm_off() -> None:
    low, tall = (Footprint("x", (0.0, 0.0), (0.2, 0.2), 0.0, top) for top in (0.5, 1.2))
    at = np.array([0.2 + PLATFORM_RADIUS_M + 0.1]), np.array([0.0])
    assert Floor((low,)).room(*at)[0] == pytest.approx(0.1)
    assert Floor((tall,)).room(*at)[0] < 0
