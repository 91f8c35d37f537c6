"""What a scene that can be loaded hardly means, by its geometry alone: places over nothing, places that overlap, things
on no place, a robot in a fixture or of the wrong kind."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from itertools import combinations

from llmbt_ir.diagnostics import Diagnostic, Severity, Span
from llmbt_ir.geometry import Box
from llmbt_ir.scene_model import SUPPORT_TOLERANCE_M, Body, RobotModel, Scene, ScenePlace
from llmbt_ir.solids import Solid, robot_solid

__all__ = ["hints"]

_GRID = 20
_SUPPORTED = 0.95
"""A place may jut out of what is under it by the rest."""
_OVERLAP_M = 0.001
_LEAST_M = 0.005


def hints(scene: Scene, types: Collection[str], *, drives: bool) -> Iterator[Diagnostic]:
    """E023 and W023 a robot that does not fit the library, of which are given its types and whether its robot drives;
    E042 a robot in a fixture; E047 and W047 a place over nothing, or partly; W041 a thing on no place; W042 places that
    overlap, none being in the other; W044 a thing too small; W045 nowhere to put things aside."""
    yield from _robot(scene, drives=drives)
    for place in scene.places:
        yield from _footing(scene, place)
    yield from _overlapping(scene)
    if "buffer" in types and not any(p.buffer for p in scene.places):
        title = "no place is a buffer: nothing that is in the way, or fell, can be put aside"
        hint = 'declare a region with type="buffer" buffer="true" where the arm comes to'
        yield Diagnostic("W045", title, Span(scene.source), help=hint, severity=Severity.WARNING)
    for body in scene.objects:
        yield from _thing(scene, body)


def _warning(scene: Scene, code: str, title: str, line: int, hint: str) -> Diagnostic:
    return Diagnostic(code, title, Span(scene.source, line), help=hint, severity=Severity.WARNING)


def _robot(scene: Scene, *, drives: bool) -> Iterator[Diagnostic]:
    bolted = scene.robot is RobotModel.PANDA
    if bolted and drives:
        title = f"the robot is bolted down, and the actions of library `{scene.library}` drive"
        hint = 'model="mobile_panda", or a library whose actions stay in one place (cargo_sorting)'
        yield Diagnostic("E023", title, Span(scene.source), help=hint)
    if not bolted and not drives:
        title = f"the robot can drive, and no action of library `{scene.library}` does: it stays where it stands"
        yield _warning(scene, "W023", title, 0, 'model="panda", or a library whose actions drive (household)')
    if bolted:
        robot = robot_solid(scene.robot_xyz_m, scene.robot)
        for fixture in scene.fixtures:
            if robot.overlaps(Solid(fixture.id, fixture.xyz_m, fixture.size_m, 0.0)):
                title = f"the robot stands in `{fixture.id}`, whose top is at {fixture.top_m:g} m"
                hint = "the third number of the robot's xyz_m is the height that its base stands at"
                yield Diagnostic("E042", title, Span(scene.source, fixture.line), help=hint)


def _under(scene: Scene, z_m: float) -> Callable[[float, float], bool]:
    """Whether something has its top at a height, at a point seen from above."""
    on_floor = abs(z_m) < SUPPORT_TOLERANCE_M
    tops = [Box(f.xyz_m, f.size_m) for f in scene.fixtures if abs(f.top_m - z_m) < SUPPORT_TOLERANCE_M]
    return lambda x, y: on_floor or any(t.contains_xy(x, y) for t in tops)


def _footing(scene: Scene, place: ScenePlace) -> Iterator[Diagnostic]:
    if place.surface_m is None:
        return
    x, y, z = place.surface_m
    under = _under(scene, z)
    offsets = [(k + 0.5) / _GRID - 0.5 for k in range(_GRID)]
    held = [under(x + u * place.size_m[0], y + v * place.size_m[1]) for u in offsets for v in offsets]
    share = sum(held) / len(held)
    hint = "set its surface on a fixture, or add one: the surface's height is that of the fixture's top"
    if not share:
        title = f"nothing is under `{place.id}`: no fixture's top is at {z:g} m there"
        yield Diagnostic("E047", title, Span(scene.source, place.line), help=hint)
    elif share < _SUPPORTED:
        title = f"something is under {100 * share:.0f} % of `{place.id}` only: what is put on the rest falls"
        yield _warning(scene, "W047", title, place.line, hint)


def _overlapping(scene: Scene) -> Iterator[Diagnostic]:
    flat = [p for p in scene.places if p.surface_m is not None]
    for one, other in combinations(flat, 2):
        if one.id in scene.with_containers(other.id) or other.id in scene.with_containers(one.id):
            continue
        if not _overlap(one, other):
            continue
        first, second = sorted((one, other), key=scene.precedence)
        title = f"`{first.id}` and `{second.id}` overlap, and neither is in the other"
        hint = f'what stands where both are counts as on `{first.id}` alone: parent="{second.id}", or draw them apart'
        yield _warning(scene, "W042", title, first.line, hint)


def _overlap(one: ScenePlace, other: ScenePlace) -> bool:
    a, b = one.surface_m, other.surface_m
    assert a is not None
    assert b is not None
    return abs(a[2] - b[2]) <= SUPPORT_TOLERANCE_M and all(
        abs(a[k] - b[k]) < (one.size_m[k] + other.size_m[k]) / 2 - _OVERLAP_M for k in (0, 1)
    )


def _thing(scene: Scene, body: Body) -> Iterator[Diagnostic]:
    if min(body.size_m) < _LEAST_M:
        title = f"`{body.id}` is {1e3 * min(body.size_m):g} mm small: the fingers hardly take what is below 5 mm"
        yield _warning(scene, "W044", title, body.line, "size_m is in metres")
    if body.pose is None:
        return
    x, y, z = body.pose.xyz_m
    bottom = z - body.size_m[2] / 2
    if scene.most_specific(x, y, bottom) is not None:
        return
    below = next((o for o in scene.objects if o is not body and _carries(o, x, y, bottom)), None)
    if below is not None:
        why, hint = f"it stands on `{below.id}`, which is no place", "stand it beside that"
    elif _under(scene, bottom)(x, y):
        why, hint = "none of them is where it stands", 'declare a region under it, or set it on a place by on="PLACE"'
    else:
        why, hint = f"nothing is under it at {bottom:g} m", 'xyz_m is the centre of a body; on="PLACE" puts it onto one'
    title = f"`{body.id}` is on no place, so that it cannot be planned with: {why}"
    yield _warning(scene, "W041", title, body.line, hint)


def _carries(body: Body, x: float, y: float, bottom_m: float) -> bool:
    """Whether a point is over a thing, at the height of its top."""
    if body.pose is None:
        return False
    at, size = body.pose.xyz_m, body.size_m
    return abs(at[2] + size[2] / 2 - bottom_m) < SUPPORT_TOLERANCE_M and Box(at, size).contains_xy(x, y)
