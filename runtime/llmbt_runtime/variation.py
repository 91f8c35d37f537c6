"""A scene with its things a little elsewhere, of other sizes, weights and friction, seen from a little elsewhere: for
evidence over many scenes.

Each thing keeps its place; nothing overlaps that did not.
"""

from __future__ import annotations

import math
from dataclasses import replace

from llmbt_ir.geometry import Pose, Vec3, quat_from_yaw, yaw_from_quat
from llmbt_ir.scene import MAX_GRASP_M, Body, Camera, Scene
from llmbt_ir.solids import overlaps
from llmbt_runtime.chance import Chance

__all__ = ["varied"]

_SHIFT_M, _SLOT_SHIFT_M, _TURN_RAD = 0.015, 0.006, 0.25
_SIZE, _MASS, _FRICTION = 0.06, 0.2, 0.15
_EYE_M, _TARGET_M, _FIELD = 0.06, 0.02, 0.04
_TRIES = 40


def varied(scene: Scene, rng: Chance) -> Scene:
    """The scene with poses within 1.5 cm (on a slot 6 mm) and 0.25 rad, sizes within 6 %, masses within 20 % and
    friction within 15 % of what it says, drawn evenly; cameras within 6 cm, what they look at within 2 cm, fields of
    view within 4 %. What would overlap, or leave its place, is drawn again."""
    objects: list[Body] = []
    for number, body in enumerate(scene.objects):
        rest = scene.objects[number + 1 :]
        for _ in range(_TRIES):
            other = _drawn(scene, body, rng)
            now = (*objects, other, *rest)
            if not any(overlaps(scene.fixtures, now, scene.robot_xyz_m, scene.robot)) and _place(
                scene, other
            ) == _place(scene, body):
                break
        else:
            other = body
        objects.append(other)
    return replace(scene, objects=tuple(objects), cameras=tuple(_seen_from(c, rng) for c in scene.cameras))


def _seen_from(camera: Camera, rng: Chance) -> Camera:
    def off(reach: float) -> float:
        return reach * (2 * rng.random() - 1)

    def moved(xyz: Vec3, reach: float) -> Vec3:
        return xyz[0] + off(reach), xyz[1] + off(reach), xyz[2] + off(reach)

    eye, target = moved(camera.eye_m, _EYE_M), moved(camera.target_m, _TARGET_M)
    return replace(camera, eye_m=eye, target_m=target, fov_deg=camera.fov_deg * (1 + off(_FIELD)))


def _drawn(scene: Scene, body: Body, rng: Chance) -> Body:
    def around(tolerance: float) -> float:
        return 1 + tolerance * (2 * rng.random() - 1)

    def within(reach: float) -> float:
        return reach * (2 * rng.random() - 1)

    if body.pose is None:
        return body
    place = _place(scene, body)
    shift = _SLOT_SHIFT_M if place is not None and scene.place(place).is_slot else _SHIFT_M
    factor = around(_SIZE)
    x, y, z = (min(s * factor, max(s, MAX_GRASP_M)) if s <= MAX_GRASP_M else s * factor for s in body.size_m)
    bx, by, bz = body.pose.xyz_m
    pose = Pose(
        (bx + within(shift), by + within(shift), bz + (z - body.size_m[2]) / 2),
        quat_from_yaw(math.remainder(yaw_from_quat(body.pose.quat_xyzw) + within(_TURN_RAD), 2 * math.pi)),
    )
    mass, friction = body.mass_kg * around(_MASS), body.friction * around(_FRICTION)
    return replace(body, size_m=(x, y, z), pose=pose, mass_kg=mass, friction=friction)


def _place(scene: Scene, body: Body) -> str | None:
    assert body.pose is not None
    x, y, z = body.pose.xyz_m
    return scene.most_specific(x, y, z - body.size_m[2] / 2)
