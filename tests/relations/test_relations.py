"""Each relation on scenes made at random, against a second computation that shares nothing with it."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest
from hypothesis import assume, given, settings

from llmbt_compiler import relations
from llmbt_compiler.relations import DIRECTIONS, by_size, facts_of, layout, nearest_first, ranked, ties
from llmbt_ir.geometry import Pose, Viewpoint
from llmbt_ir.scene import load_scene, scene_names, to_semantic_map
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap
from tests.relations.oracle import Oracle
from tests.relations.scenes import maps

RANDOM = settings(max_examples=80, deadline=None)


@pytest.mark.parametrize("name", ["left_of", "right_of", "in_front_of", "behind", "above", "on_top_of"])
@RANDOM
@given(semantic_map=maps())
def test_two_things(name, semantic_map):
    around, oracle = layout(semantic_map), Oracle(semantic_map)
    for a, b in itertools.permutations(semantic_map.objects, 2):
        expected = getattr(oracle, name)(a.id, b.id)
        if not oracle.near():
            assert getattr(relations, name)(around[a.id], around[b.id]) == expected, (a.id, b.id)


@RANDOM
@given(maps())
def test_beside(semantic_map):
    around, oracle = layout(semantic_map), Oracle(semantic_map)
    objects = {o.id: around[o.id] for o in semantic_map.objects}
    for a, b in itertools.product(objects, repeat=2):
        expected = oracle.beside(a, b)
        if not oracle.near():
            assert relations.beside(objects[a], objects[b], objects) == expected, (a, b)


@RANDOM
@given(maps(most=5))
def test_between(semantic_map):
    around, oracle = layout(semantic_map), Oracle(semantic_map)
    for a, b, c in itertools.permutations([o.id for o in semantic_map.objects], 3):
        expected = oracle.between(a, b, c)
        if not oracle.near():
            assert relations.between(around[a], around[b], around[c]) == expected, (a, b, c)


VALUES = {
    "left": (lambda o, i: o.centre[i][0], 0.025),
    "right": (lambda o, i: -o.centre[i][0], 0.025),
    "front": (lambda o, i: o.centre[i][1], 0.025),
    "back": (lambda o, i: -o.centre[i][1], 0.025),
    "small": (lambda o, i: math.log(o.volume[i]), math.log(1.15)),
    "large": (lambda o, i: -math.log(o.volume[i]), math.log(1.15)),
    "short": (lambda o, i: o.high[i][2] - o.low[i][2], 0.0075),
    "tall": (lambda o, i: o.low[i][2] - o.high[i][2], 0.0075),
}


@pytest.mark.parametrize("name", sorted(VALUES))
@RANDOM
@given(semantic_map=maps())
def test_orders_and_ranks(name, semantic_map):
    """From the left, from the front, by size and by height, with what is level told together."""
    around, oracle = layout(semantic_map), Oracle(semantic_map)
    ids = [o.id for o in semantic_map.objects]
    value, margin = VALUES[name]
    expected = oracle.groups(ids, lambda i: value(oracle, i), margin)
    assume(not oracle.near())
    things = [around[i] for i in ids]
    assert ties(things, DIRECTIONS[name]) == expected
    flat = [g for g in expected for _ in g]
    assert [ranked(things, DIRECTIONS[name], k + 1) for k in range(len(ids))] == flat
    assert ranked(things, DIRECTIONS[name], len(ids) + 1) == ()
    if name == "small":
        assert by_size(things) == expected


@RANDOM
@given(maps())
def test_nearest(semantic_map):
    around, oracle = layout(semantic_map), Oracle(semantic_map)
    ids = [o.id for o in semantic_map.objects]
    for to in ids:
        others = [i for i in ids if i != to]
        away = {i: math.dist(oracle.centre[i][:2], oracle.centre[to][:2]) for i in others}
        expected = oracle.groups(others, away.__getitem__, 0.015)
        if not oracle.near():
            assert nearest_first([around[i] for i in ids], around[to]) == expected


@RANDOM
@given(maps(most=4))
def test_in_a_row(semantic_map):
    around, oracle = layout(semantic_map), Oracle(semantic_map)
    for n in (1, 2, 3):
        for ids in itertools.combinations([o.id for o in semantic_map.objects], n):
            spread = [max(c) - min(c) for c in zip(*(oracle.centre[i][:2] for i in ids), strict=True)]
            apart = [
                len(oracle.groups(ids, lambda i, axis=axis: oracle.centre[i][axis], 0.025)) == n for axis in (0, 1)
            ]
            level = [not s > 0.025 for s in spread]
            on_edge = any(abs(s - 0.025) < 1e-7 for s in spread)
            if not oracle.near() and not on_edge:
                expected = n > 1 and ((level[1] and apart[0]) or (level[0] and apart[1]))
                assert relations.in_a_row(around[i] for i in ids) == expected, ids


@RANDOM
@given(maps())
def test_laws(semantic_map):
    """Opposites exclude each other; nothing is related to itself; to look from behind turns everything round."""
    around = layout(semantic_map)
    view = semantic_map.viewpoint
    turned = layout(replace(semantic_map, viewpoint=replace(view, yaw_rad=view.yaw_rad + math.pi)))
    oracle = Oracle(semantic_map)
    for a, b in itertools.product([o.id for o in semantic_map.objects], repeat=2):
        x, y = around[a], around[b]
        assert not (relations.left_of(x, y) and relations.right_of(x, y))
        assert not (relations.in_front_of(x, y) and relations.behind(x, y))
        assert relations.left_of(x, y) == relations.right_of(y, x)
        assert a != b or not (relations.left_of(x, y) or relations.behind(x, y) or relations.on_top_of(x, y))
        oracle.left_of(a, b), oracle.behind(a, b)
        if not oracle.near():
            assert relations.left_of(x, y) == relations.right_of(turned[a], turned[b])
            assert relations.behind(x, y) == relations.in_front_of(turned[a], turned[b])


def block(id_, x, y, size=0.045, z=None):
    return MapObject(id_, id_, "red", "cube", (size,) * 3, Pose((x, y, size / 2 if z is None else z)), "table")


def seen(*objects, viewpoint=None):
    return SemanticMap("s", "l", objects, (MapPlace("table", "table", "region"),), viewpoint=viewpoint or Viewpoint())


def test_left_is_the_viewers():
    """The world's y is to the left of somebody who looks along x, and to the right of somebody who looks back."""
    objects = (block("a", 1, 0.2), block("b", 1, -0.2))
    assert relations.left_of(*(layout(seen(*objects))[i] for i in "ab"))
    guest = layout(seen(*objects, viewpoint=Viewpoint("guest", (2, 0, 0), math.pi)))
    assert relations.right_of(guest["a"], guest["b"])


def test_an_object_that_moved_stands_in_the_middle_of_its_place():
    slot = MapPlace("p1", "p1", "slot", surface_m=(0.5, 0.3, 0.2), size_m=(0.1, 0.1))
    semantic_map = replace(seen(block("a", 0, 0), block("b", 0, 0.3)), places=(slot,))
    around = layout(semantic_map, {"a": "p1", "b": None})
    assert (around["a"].right, around["a"].ahead) == pytest.approx((-0.3, 0.5))
    assert (around["a"].bottom, around["a"].top) == pytest.approx((0.2, 0.245))
    assert around.get("b") is None


def test_a_millimetre_changes_nothing_in_the_shipped_scenes():
    """So a map recognised from cameras gives the prompt of the scene's own map."""
    for name in scene_names():
        semantic_map = to_semantic_map(load_scene(name))
        for i, (dx, dy) in enumerate(itertools.product((-0.001, 0.001), repeat=2)):
            moved = tuple(
                replace(o, pose=Pose((o.pose.xyz_m[0] + dx * (k % 2 or -1), o.pose.xyz_m[1] + dy, o.pose.xyz_m[2])))
                for k, o in enumerate(semantic_map.objects, i)
            )
            assert facts_of(replace(semantic_map, objects=moved)) == facts_of(semantic_map)


def test_facts_are_few_however_large_the_map_is():
    many = seen(*(block(f"o{i}", (i % 50) / 10, (i // 50) / 10, 0.02 + i / 1e4) for i in range(2000)))
    lines = facts_of(many)
    assert len(lines) <= 60
    assert max(map(len, lines)) < 3000


def test_facts_say_orders_neighbours_stacks_and_sizes():
    tower = block("c", 0.5, 0.2, 0.03, 0.045 + 0.015)
    lines = facts_of(seen(block("a", 0.5, 0.2), block("b", 0.5, 0.0, 0.06), tower))
    assert lines == (
        "on table from left to right: a = c, b",
        "on table next to each other: a and b",
        "stacked: c on a",
        "objects from small to large: c, a, b",
    )
