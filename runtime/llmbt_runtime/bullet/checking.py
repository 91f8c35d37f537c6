"""What is wrong with a scene that only the robot's own kinematics can tell: what it cannot reach, or not take."""

from __future__ import annotations

from collections.abc import Iterator

from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import Diagnostic, Severity, Span
from llmbt_ir.scene import Scene, ScenePlace
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.erecting import UPRIGHT_M, can_stand_at
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.navigation import Floor
from llmbt_runtime.bullet.robot import FINGER_FORCE_N
from llmbt_runtime.bullet.spots import free_spots, small_half_m
from llmbt_runtime.bullet.stage import Stage
from llmbt_runtime.bullet.terrain import Terrain
from llmbt_runtime.bullet.world import BulletWorld

__all__ = ["docks_of", "findings"]

_ABOVE_M = (0.02, 0.12)
_WEIGHT_N = 9.81
"""Of a kilogram."""
_SLIPS = 3
"""The fingers have to hold this many times a thing's weight."""


def findings(scene: Scene) -> Iterator[Diagnostic]:
    """E042 the robot stands in something, E049 a place that the arm does not come to, W049 a thing that it cannot take
    where it stands at the start, W044 that slips, W045 that nobody sets upright when it fell, W046 a place without a
    surface to which a robot would have to drive."""
    world = BulletWorld(scene)
    try:
        terrain = world.terrain
        if terrain.drives:
            yield from _driven(scene, terrain)
        else:
            yield from _bolted(scene, terrain.approach)
            yield from _fallen(scene)
        yield from _things(scene, world)
        yield from _grip(scene)
    finally:
        world.close()


def _fault(scene: Scene, place: ScenePlace, why: str, hint: str) -> Diagnostic:
    return Diagnostic("E049", f"`{place.id}` is out of reach: {why}", Span(scene.source, place.line), help=hint)


def _driven(scene: Scene, terrain: Terrain) -> Iterator[Diagnostic]:
    floor = Floor.of(scene)
    here = scene.robot_xyz_m[:2]
    if not floor.stands(here):
        yield Diagnostic("E042", "the robot overlaps a fixture at the start", Span(scene.source), help="move it")
        return
    for place in scene.places:
        if place.surface_m is None:
            title = f"`{place.id}` has no surface: the robot cannot drive to it, or put anything on it but in its parts"
            span = Span(scene.source, place.line)
            yield Diagnostic(
                "W046",
                title,
                span,
                help="name its parts where the robot is to go, or give it a surface_m",
                severity=Severity.WARNING,
            )
        if place.surface_m is None or place.is_slot:
            continue
        docks = terrain.docks[place.id]
        if not docks:
            hint = "a panda reaches 0.3 to 0.7 m from its base: make the place smaller, lower, or leave room beside it"
            yield _fault(scene, place, "there is no pose of the base from which all of it is reached", hint)
        elif not any(floor.connected(here, (d.x_m, d.y_m)) for d in docks):
            yield _fault(scene, place, "there is no way to where the robot would have to stand", "leave 0.6 m to pass")


def _bolted(scene: Scene, approach: Approach) -> Iterator[Diagnostic]:
    base = BasePose.of_scene(scene)
    holding_slots = {q for p in scene.places if p.is_slot for q in scene.with_containers(p.id)}
    for place in scene.places:
        if place.surface_m is None:
            continue
        x, y, z = place.surface_m
        if place.is_slot:
            if not approach.reaches(base, [(x, y, z + above) for above in _ABOVE_M]):
                hint = "move it to 0.3 to 0.74 m from the robot's base, with room above it"
                yield _fault(scene, place, "the hand does not come to it from above", hint)
        elif place.id not in holding_slots:
            spots = free_spots(place, small_half_m(drives=False), (), scene.fixtures, base)
            if not any(approach.reaches(base, [(u, v, z + above) for above in _ABOVE_M]) for u, v in spots[:20]):
                yield _fault(scene, place, "there is no spot on it to which the hand comes", "move it nearer")


def _things(scene: Scene, world: BulletWorld) -> Iterator[Diagnostic]:
    facts = world.observe()
    for o in scene.objects:
        if Condition("Clear", (o.id,)) in facts:
            continue
        blockers = sorted(f.args[0] for f in facts if f.name == "Blocks" and f.args[1] == o.id)
        why = f"`{blockers[0]}` is in the way" if blockers else "it is out of reach, or a fixture is in the way"
        yield Diagnostic(
            "W049",
            f"`{o.id}` cannot be taken from where it stands: {why}",
            Span(scene.source, o.line),
            severity=Severity.WARNING,
        )


def _grip(scene: Scene) -> Iterator[Diagnostic]:
    """The friction of two fingers holds a thing's weight several times, or it slips when it is moved."""
    for o in (*scene.objects, *scene.obstacles):
        weight = o.mass_kg * _WEIGHT_N
        if o.movable and _SLIPS * weight > 2 * FINGER_FORCE_N * o.friction:
            title = f"`{o.id}` slips out of the fingers: {o.mass_kg:g} kg, with a friction of {o.friction:g}"
            hint = f"two fingers press with {FINGER_FORCE_N:g} N each; mass_kg and friction have defaults"
            yield Diagnostic("W044", title, Span(scene.source, o.line), help=hint, severity=Severity.WARNING)


def _fallen(scene: Scene) -> Iterator[Diagnostic]:
    """A bolted arm sets a cylinder upright on a buffer at some distances only."""
    base = BasePose.of_scene(scene)
    for o in scene.objects:
        if o.shape != "cylinder" or o.size_m[2] <= o.size_m[0]:
            continue
        half = o.size_m[0] / 2
        buffers = [p for p in scene.places if p.buffer]
        spots = [s for p in buffers for s in free_spots(p, (half, half), (), scene.fixtures, base)]
        if not any(can_stand_at(base, spot) for spot in spots):
            title = f"`{o.id}` is lost when it falls over: there is no buffer to set it upright on"
            hint = f"a buffer with room {UPRIGHT_M[0]:g} to {UPRIGHT_M[1]:g} m from the robot's base"
            yield Diagnostic("W045", title, Span(scene.source, o.line), help=hint, severity=Severity.WARNING)


def docks_of(scene: Scene) -> dict[str, list[tuple[float, float, float]]]:
    """Where the robot stands for each location: x, y, heading."""
    approach = Approach(Stage(scene))
    try:
        docks = Terrain(approach.stage, approach, {}).docks
        return {p: [(d.x_m, d.y_m, d.yaw_rad) for d in found] for p, found in docks.of.items()}
    finally:
        approach.close()
