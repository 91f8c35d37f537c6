"""What is known of things: seen, hidden, unseen, gone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_ir.geometry import Pose, quat_from_yaw
from llmbt_ir.scene import Camera
from llmbt_ir.semantic_map import MapObject, SemanticMap
from llmbt_runtime.perception.belief import Sight, Standing, Thing, looked_for, revised, sight_of
from llmbt_runtime.perception.rgbd import RgbdImage, cloud_of, points_of, project
from llmbt_runtime.perception.watch import Box, Watch

ABOVE = Camera("above", (0.0, -0.6, 1.2), (0.0, 0.0, 0.0), 45.0, 160, 120)
BLOCK = MapObject("o", "o", "red", "cube", (0.05, 0.05, 0.05), Pose((0.02, 0.03, 0.025), quat_from_yaw(0.3)), "table")


def seen(*things: MapObject) -> SemanticMap:
    return SemanticMap("s", "l", things)


def picture(*boxes: tuple[tuple[float, float, float], tuple[float, float, float]], colour: int = 90) -> RgbdImage:
    """A floor at z = 0 with boxes (low and high corner) on it: rays against slabs, an oracle of its own."""
    blank = RgbdImage(ABOVE, np.full((120, 160, 3), colour, np.uint8), np.ones((120, 160)))
    v, u = np.nonzero(np.isfinite(blank.depth_m))
    eye = np.array(ABOVE.eye_m)
    rays = points_of(blank, u, v) - eye
    depth = -eye[2] / rays[:, 2]
    for low, high in boxes:
        with np.errstate(divide="ignore"):
            a, b = (np.array(low) - eye) / rays, (np.array(high) - eye) / rays
        near, far = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
        depth = np.where((near < far) & (near > 0), np.minimum(depth, near), depth)
    image = np.zeros((120, 160))
    image[v, u] = depth
    return RgbdImage(ABOVE, blank.rgb, image)


HERE = ((-0.005, 0.005, 0.0), (0.045, 0.055, 0.05))
BEFORE_IT = ((-0.06, -0.12, 0.0), (0.1, -0.08, 0.3))


@pytest.mark.parametrize(
    ("boxes", "sight"),
    [((HERE,), Sight.THERE), ((), Sight.PAST), ((HERE, BEFORE_IT), Sight.HIDDEN), ((BEFORE_IT,), Sight.HIDDEN)],
)
def test_what_a_picture_says_of_a_place(boxes: tuple[object, ...], sight: Sight) -> None:
    assert sight_of(BLOCK, (picture(*boxes),)) is sight  # type: ignore[arg-type]


def test_one_camera_that_looks_past_is_enough() -> None:
    other = RgbdImage(ABOVE, picture().rgb, picture(BEFORE_IT).depth_m)
    assert sight_of(BLOCK, (other,)) is Sight.HIDDEN
    assert sight_of(BLOCK, (other, picture())) is Sight.PAST
    assert sight_of(BLOCK, ()) is Sight.HIDDEN


@pytest.mark.parametrize(
    ("before", "found", "sight", "after"),
    [
        (Standing.SEEN, True, Sight.PAST, Standing.SEEN),
        (Standing.SEEN, False, Sight.HIDDEN, Standing.HIDDEN),
        (Standing.SEEN, False, Sight.THERE, Standing.HIDDEN),
        (Standing.SEEN, False, Sight.PAST, Standing.UNSEEN),
        (Standing.HIDDEN, False, Sight.PAST, Standing.UNSEEN),
        (Standing.HIDDEN, False, Sight.HIDDEN, Standing.HIDDEN),
        (Standing.UNSEEN, False, Sight.HIDDEN, Standing.UNSEEN),
        (Standing.UNSEEN, True, Sight.HIDDEN, Standing.SEEN),
        (Standing.GONE, False, Sight.PAST, Standing.GONE),
        (Standing.GONE, True, Sight.PAST, Standing.SEEN),
    ],
)
def test_what_a_look_makes_of_what_was_known(before: Standing, found: bool, sight: Sight, after: Standing) -> None:
    things = {"o": Thing(before, BLOCK)}
    assert revised(things, seen(BLOCK) if found else seen(), lambda _: sight)["o"].standing is after


def test_only_what_is_unseen_can_be_gone() -> None:
    for standing in Standing:
        after = looked_for({"o": Thing(standing, BLOCK)}, "o")["o"].standing
        assert after is (Standing.GONE if standing is Standing.UNSEEN else standing)
    assert looked_for({}, "o") == {}


def test_what_turns_up_is_known_from_then_on() -> None:
    assert revised({}, seen(BLOCK), lambda _: Sight.PAST) == {"o": Thing(Standing.SEEN, BLOCK)}
    assert Thing(Standing.UNSEEN, BLOCK).located is False and Thing(Standing.SEEN).located is False


@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(0.0, 0.3))
def test_a_point_is_shown_by_the_pixel_it_is_projected_to(x: float, y: float, z: float) -> None:
    image = picture()
    (pixel,), (depth,) = project(ABOVE, np.array([[x, y, z]]), 160, 120)
    here = RgbdImage(ABOVE, image.rgb, np.full_like(image.depth_m, depth))
    back = points_of(here, pixel[:1], pixel[1:])[0]
    assert math.dist(back, (x, y, z)) < 0.012  # half a pixel's diagonal


def test_changes_are_noticed() -> None:
    watch = Watch()
    hand = np.array([[-0.06, -0.12, 0.0], [0.1, -0.08, 0.3]])
    assert not watch.changed([picture()], [])
    assert not watch.changed([picture()], []), "nothing has changed"
    assert watch.changed([picture(HERE)], []), "a block has come"
    assert not watch.changed([picture(HERE)], [])
    assert not watch.changed([picture(HERE, BEFORE_IT)], [hand]), "the hand comes before it"
    assert not watch.changed([picture(BEFORE_IT)], [hand]), "it is taken away behind the hand"
    assert watch.changed([picture()], []), "which is seen when the hand goes"
    around = Box(np.array(HERE[0]) - 0.05, np.array(HERE[1]) + 0.05)
    assert not watch.changed([picture(HERE)], [], [around]), "what the hand holds does not count"


def test_a_change_of_colour_is_noticed_and_noise_is_not() -> None:
    watch, rng = Watch(), np.random.default_rng(0)

    def noisy(colour: int) -> RgbdImage:
        image = picture(HERE, colour=colour)
        return RgbdImage(ABOVE, image.rgb, image.depth_m + rng.normal(0, 0.0015, image.depth_m.shape))

    assert not any(watch.changed([noisy(90)], []) for _ in range(50))
    assert watch.changed([noisy(150)], [])


def test_a_cloud_leaves_out_what_is_out_of_range() -> None:
    image = picture()
    image.depth_m[:60] = np.inf
    assert len(cloud_of(image)) == 60 * 160
