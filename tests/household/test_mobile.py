"""The robot that drives, in the physics: where it is, what it carries, what is in its way."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from llmbt_ir.condition import ActionCall
from llmbt_ir.geometry import Pose, quat_from_yaw
from llmbt_ir.scene import load_scene
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.world import ActionReport, Status

S, F = Status.SUCCESS, Status.FAILURE


@pytest.fixture(scope="module")
def built() -> Iterator[BulletWorld]:
    made = BulletWorld(load_scene("household"))
    yield made
    made.close()


@pytest.fixture
def world(built: BulletWorld) -> BulletWorld:
    built.reset()
    return built


def act(world: BulletWorld, name: str, *args: str, halt_at: int = 0) -> ActionReport:
    world.start(ActionCall(name, args))
    for tick in range(900):
        if halt_at and tick >= halt_at and world.halt():
            return ActionReport(Status.IDLE, "halted")
        report = world.advance()
        if report.status is not Status.RUNNING:
            return report
    raise AssertionError(f"{name}{args} does not end")


def facts(world: BulletWorld, *names: str) -> set[str]:
    return {str(f) for f in world.observe() if f.name in names}


def put(world: BulletWorld, id_: str, x: float, y: float, yaw: float = 0.0, on_m: float = 0.0) -> None:
    height = world._bench.kinds[id_].size_m[2]
    world._bench.put(id_, Pose((x, y, on_m + height / 2 + 0.0005), quat_from_yaw(yaw)))
    world.settle(0.6)


def base(world: BulletWorld) -> tuple[float, float]:
    at = world._bench.base.measured()
    return at.x_m, at.y_m


# ------------------------------------------------------------------------------------------------ the start, the way


def test_the_start_is_what_the_map_says(world: BulletWorld) -> None:
    from llmbt_atl.library import load_library
    from llmbt_atl.state import domain_of
    from llmbt_ir.scene import to_semantic_map
    from llmbt_runtime.initial import facts_of_map

    found = to_semantic_map(load_scene("household"))
    assert world.observe() == facts_of_map(domain_of(load_library("household"), found), found)
    assert world.observe() == world.truth() and world.at_rest


def test_it_drives_to_where_it_should_be(world: BulletWorld) -> None:
    for place in ("bar", "user", "shelf", "table", "desk"):
        assert act(world, "navigate", place) == ActionReport(S)
        assert facts(world, "Near") == {f"Near({place})"}
        docks = world._skills.driver.terrain.docks[place]
        assert min(world._bench.base.measured().far_from(d)[0] for d in docks) < 1e-4


def test_near_ends_when_it_leaves_and_begins_with_the_end_of_the_drive(world: BulletWorld) -> None:
    act(world, "navigate", "bar")
    world.start(ActionCall("navigate", ("user",)))
    seen = []
    while world.advance().status is Status.RUNNING:
        seen.append(frozenset(facts(world, "Near")))
    assert set(seen) == {frozenset({"Near(bar)"}), frozenset()}
    assert facts(world, "Near") == {"Near(user)"}


def test_fetch_and_carry_by_hand(world: BulletWorld) -> None:
    steps = ("navigate", "bar"), ("pick", "coke", "bar"), ("navigate", "user"), ("place", "coke", "user")
    for name, *args in steps:
        assert act(world, name, *args) == ActionReport(S)
    assert "On(coke, user)" in facts(world, "On") and facts(world, "HandEmpty")


@pytest.mark.parametrize("thing", ["potato_chips", "chocolate", "bread", "cookies", "apple"])
def test_each_shape_can_be_brought(world: BulletWorld, thing: str) -> None:
    assert act(world, "navigate", "table").status is S
    assert act(world, "pick", thing, "table").status is S
    assert act(world, "navigate", "desk").status is S
    assert act(world, "place", thing, "desk").status is S
    assert f"On({thing}, desk)" in facts(world, "On")


def test_a_skill_that_was_halted_anywhere_can_be_started_again(world: BulletWorld) -> None:
    for halt_at in (3, 9, 17, 26):
        assert act(world, "navigate", "bar", halt_at=halt_at).status in (S, Status.IDLE)
        assert act(world, "navigate", "table", halt_at=2 * halt_at).status in (S, Status.IDLE)
    assert act(world, "navigate", "bar").status is S
    for halt_at in (2, 7, 12):
        act(world, "pick", "water", "bar", halt_at=halt_at)
        if "Holding(water)" in facts(world, "Holding"):
            break
    else:
        assert act(world, "pick", "water", "bar").status is S
    for halt_at in (4, 12, 20):
        assert act(world, "navigate", "shelf", halt_at=halt_at).status is Status.IDLE
        assert facts(world, "Holding") == {"Holding(water)"}
    assert act(world, "navigate", "shelf").status is S
    assert act(world, "place", "water", "shelf").status is S


# ------------------------------------------------------------------------------------------------ what is in the way


def test_it_goes_round_what_stands_in_the_room(world: BulletWorld) -> None:
    put(world, "obstacle_6", 0.55, 0.0)
    assert "Clear(bar)" in facts(world, "Clear")
    assert act(world, "navigate", "bar").status is S
    x, y, _ = world.objects()["obstacle_6"]
    assert math.hypot(x - 0.55, y) < 1e-3, "it was not touched"


def test_an_obstacle_that_turns_up_while_it_drives(world: BulletWorld) -> None:
    world.start(ActionCall("navigate", ("bar",)))
    for _ in range(12):
        world.advance()
    world._bench.put("obstacle_6", Pose((0.75, 0.0, 0.2505)))
    while (report := world.advance()).status is Status.RUNNING:
        pass
    assert report == ActionReport(S) and facts(world, "Near") == {"Near(bar)"}
    assert math.dist(world.objects()["obstacle_6"][:2], (0.75, 0.0)) < 1e-3


def test_another_docking_pose_where_one_is_taken(world: BulletWorld) -> None:
    first = world._skills.driver.terrain.docks["user"][0]
    put(world, "obstacle_3", first.x_m, first.y_m)
    assert "Clear(user)" in facts(world, "Clear")
    assert act(world, "navigate", "user").status is S
    assert math.dist(base(world), (first.x_m, first.y_m)) > 0.2


def wall_in(world: BulletWorld, last: str = "obstacle_3") -> None:
    """The only ways to the user are barred: fixtures would be a wall; here the docking poses are made one."""
    from llmbt_runtime.bullet.docking import Docks

    terrain = world._skills.driver.terrain
    terrain._docks = Docks({**terrain.docks.of, "user": terrain.docks["user"][:1]})
    dock = terrain.docks["user"][0]
    put(world, last, dock.x_m, dock.y_m, math.pi / 2)


def test_a_crate_before_the_only_docking_pose_is_told_and_cleared(world: BulletWorld) -> None:
    wall_in(world)
    assert "Clear(user)" not in facts(world, "Clear")
    assert "Blocks(obstacle_3, user)" in facts(world, "Blocks")
    assert {"Fallen(obstacle_3)", "Clear(obstacle_3)"} <= facts(world, "Fallen", "Clear")
    refused = act(world, "navigate", "user")
    assert (refused.status, refused.reason, refused.blocker) == (F, "no_path", "obstacle_3")
    assert act(world, "clear_way", "obstacle_3", "user") == ActionReport(S)
    assert facts(world, "Near") == {"Near(user)"} and "Clear(user)" in facts(world, "Clear")


def test_a_crate_is_set_down_before_its_clearing_can_be_halted(world: BulletWorld) -> None:
    """It has no room on any piece of furniture, so nothing else could be done with it."""
    wall_in(world)
    world.start(ActionCall("clear_way", ("obstacle_3", "user")))
    while world._bench.sensed.held is None:
        assert world.advance().status is Status.RUNNING
    waited = 0
    while not world.halt():
        world.advance()
        waited += 1
    assert 5 < waited < 100
    assert facts(world, "HandEmpty", "Holding") == {"HandEmpty"} and "Fallen(obstacle_3)" in facts(world, "Fallen")
    assert act(world, "navigate", "user").status is S


def test_an_armchair_there_cannot_be_cleared(world: BulletWorld) -> None:
    wall_in(world, "obstacle_6")
    assert "Blocks(obstacle_6, user)" in facts(world, "Blocks")
    assert not {"Clear(user)", "Clear(obstacle_6)"} & facts(world, "Clear")


def test_the_milk_behind_a_cereal_box(world: BulletWorld) -> None:
    x, y, _ = world.objects()["milk"]
    put(world, "obstacle_1", x - 0.053, y + 0.053, 3 * math.pi / 4, 0.46)
    assert facts(world, "Blocks") == {"Blocks(obstacle_1, milk)"}
    assert act(world, "navigate", "bar").status is S
    refused = act(world, "pick", "milk", "bar")
    assert (refused.status, refused.reason, refused.blocker) == (F, "not_approachable", "obstacle_1")
    assert act(world, "clear_away", "obstacle_1", "milk", "bar") == ActionReport(S)
    assert "Clear(milk)" in facts(world, "Clear") and "On(obstacle_1, bar)" in facts(world, "On")
    assert act(world, "pick", "milk", "bar").status is S


def test_what_lies_on_the_floor_is_recovered(world: BulletWorld) -> None:
    put(world, "milk", 0.3, 1.0, 0.4)
    assert facts(world, "Fallen") == {"Fallen(milk)"}
    assert act(world, "recover", "milk", "user") == ActionReport(S)
    assert {"On(milk, user)", "Near(user)"} <= facts(world, "On", "Near")


def test_a_full_place_takes_no_more(world: BulletWorld) -> None:
    x, y, z = world.places()["user"]
    for i, o in enumerate(("water", "juice", "tea", "coke", "chocolate", "cookies")):
        put(world, o, x - 0.2 + 0.2 * (i % 3), y - 0.07 + 0.14 * (i // 3), 0.0, z)
    assert "Free(user)" not in facts(world, "Free")
    act(world, "navigate", "bar")
    act(world, "pick", "milk", "bar")
    act(world, "navigate", "user")
    refused = act(world, "place", "milk", "user")
    assert (refused.status, refused.reason) == (F, "no_free_buffer")
    assert facts(world, "Holding") == {"Holding(milk)"}
