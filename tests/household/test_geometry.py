"""What geometry forbids comes back as facts, and the tree grows by them: each kind, in physics, to the end."""

from __future__ import annotations

from dataclasses import replace

from llmbt_atl.library import load_library
from llmbt_atl.state import domain_of
from llmbt_ir.condition import Condition
from llmbt_ir.geometry import Pose
from llmbt_ir.scene import Body, Scene, load_scene, to_semantic_map
from llmbt_ir.tree import goal_tree
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.executor import Change, Settings, execute
from llmbt_runtime.outcome import Outcome, Result

CARGO = load_scene("cargo_sorting")


def run(scene: Scene, *goals: Condition) -> tuple[Result, list[Change]]:
    """The goals from an empty tree, and how it grew."""
    world = BulletWorld(scene, goals=goals)
    kept: list[Change] = []
    try:
        domain = domain_of(load_library(scene.library), to_semantic_map(scene))
        found = execute(
            world,
            domain,
            goal_tree((goals,)),
            (goals,),
            keep=lambda c: kept.append(c) or "v",  # type: ignore[func-returns-value]
            settings=Settings(max_ticks=2_000),
        )
        return found, kept
    finally:
        world.close()


def on(thing: str, place: str) -> Condition:
    return Condition("On", (thing, place))


def also(scene: Scene, *more: Body) -> Scene:
    return replace(scene, objects=(*scene.objects, *more))


def block(id_: str, x: float, y: float, z: float, size: tuple[float, float, float]) -> Body:
    return Body(id_, id_, "object", "grey", "box", size, pose=Pose((x, y, z + size[2] / 2)))


def test_blocked_by_something_that_is_then_cleared_away() -> None:
    """A tall carton stands 5 mm beside object 3: the hand cannot come down over it."""
    three = next(o for o in CARGO.objects if o.id == "object_3")
    assert three.pose is not None
    x, y, _ = three.pose.xyz_m
    scene = also(CARGO, block("carton", x - 0.05, y, 0.4, (0.045, 0.045, 0.11)))
    found, grown = run(scene, on("object_3", "position_22"))
    assert found.outcome is Outcome.SUCCESS, found.reason
    assert found.actions[0].call.name == "clear_away" and found.actions[0].call.args[:2] == ("carton", "object_3")
    assert "Clear(object_3)" in " ".join(str(s) for c in grown for s in c.grown.steps)


def test_out_of_reach_cannot_be_solved_and_says_what() -> None:
    """A block on the far corner of the bench, where no pose of the arm's reaches."""
    scene = also(CARGO, block("far", 0.78, -0.58, 0.4, (0.045, 0.045, 0.045)))
    found, _ = run(scene, on("far", "position_22"))
    assert found.outcome is Outcome.UNSOLVABLE and found.actions == ()
    assert "far" in found.reason


def test_no_free_place_is_made_free() -> None:
    """The user's side of the desk is full: something there is put aside before the milk is put down."""
    room = load_scene("household")
    user = room.place("user").surface_m
    assert user is not None
    laid = ("water", "juice", "tea", "coke", "chocolate", "cookies")
    there = {o: (-0.2 + 0.2 * (i % 3), -0.07 + 0.14 * (i // 3)) for i, o in enumerate(laid)}
    x, y, z = user
    moved = tuple(
        replace(o, pose=Pose((x + there[o.id][0], y + there[o.id][1], z + o.size_m[2] / 2))) if o.id in there else o
        for o in room.objects
    )
    scene = replace(room, objects=moved)
    world = BulletWorld(scene)
    full = Condition("Free", ("user",)) not in world.truth()
    world.close()
    assert full
    found, _ = run(scene, on("milk", "user"))
    assert found.outcome is Outcome.SUCCESS, found.reason
    names = [a.call.name for a in found.actions if a.result == "SUCCESS"]
    assert names.index("move_aside") < names.index("place")
