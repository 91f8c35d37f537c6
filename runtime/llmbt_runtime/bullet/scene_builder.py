"""A scene's fixtures and movable bodies as pybullet bodies, in the physics and in its kinematic shadow alike."""

from __future__ import annotations

from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import COLOURS, Body, RobotModel, Scene
from llmbt_runtime.bullet.client import BulletClient

__all__ = ["GROUND", "add_bodies", "add_fixtures", "mark_slots", "parking_spot"]

GROUND = "ground"
_GROUND_M, _AROUND_M = 2.6, 0.3
"""The floor that is seen: so large at least, and so far beyond what stands on it."""


def parking_spot(index: int, height_m: float) -> Vec3:
    """Where the index-th body waits while out of play: far away, on the ground, apart from the others."""
    return (50.0 + 2.0 * index, 50.0, height_m / 2)


def _shape(client: BulletClient, body: Body) -> int:
    sx, sy, sz = body.size_m
    if body.shape == "sphere":
        return int(client.createCollisionShape(client.GEOM_SPHERE, radius=sx / 2))
    if body.shape == "cylinder":
        return int(client.createCollisionShape(client.GEOM_CYLINDER, radius=sx / 2, height=sz))
    return int(client.createCollisionShape(client.GEOM_BOX, halfExtents=(sx / 2, sy / 2, sz / 2)))


def visual_of(client: BulletClient, shape: str, size: Vec3, colour: str) -> int:
    """A visual shape in a scene's colour."""
    rgba = (*COLOURS[colour], 1.0)
    if shape == "sphere":
        return int(client.createVisualShape(client.GEOM_SPHERE, radius=size[0] / 2, rgbaColor=rgba))
    if shape == "cylinder":
        return int(client.createVisualShape(client.GEOM_CYLINDER, radius=size[0] / 2, length=size[2], rgbaColor=rgba))
    half = (size[0] / 2, size[1] / 2, size[2] / 2)
    return int(client.createVisualShape(client.GEOM_BOX, halfExtents=half, rgbaColor=rgba))


def add_fixtures(client: BulletClient, scene: Scene, *, visible: bool = False) -> dict[str, int]:
    """The ground and the fixtures: ids of the scene to ids of pybullet."""
    found = {GROUND: _ground(client, scene, visible)}
    for f in scene.fixtures:
        half = (f.size_m[0] / 2, f.size_m[1] / 2, f.size_m[2] / 2)
        body = int(
            client.createMultiBody(
                0,
                client.createCollisionShape(client.GEOM_BOX, halfExtents=half),
                visual_of(client, "box", f.size_m, f.colour) if visible else -1,
                f.xyz_m,
            )
        )
        client.changeDynamics(body, -1, lateralFriction=f.friction)
        found[f.id] = body
    return found


def _ground(client: BulletClient, scene: Scene, visible: bool) -> int:
    """An endless plane at z = 0; a slab where it is to be seen."""
    if not visible:
        return int(client.createMultiBody(0, client.createCollisionShape(client.GEOM_PLANE)))
    reach = [abs(f.xyz_m[i]) + f.size_m[i] / 2 + _AROUND_M for f in scene.fixtures for i in (0, 1)]
    side = max(_GROUND_M, 2 * max(reach, default=0.0)) if scene.robot is RobotModel.MOBILE_PANDA else _GROUND_M
    slab = visual_of(client, "box", (side, side, 0.1), "white")
    return int(client.createMultiBody(0, -1, slab, (0, 0, -0.05)))


def add_bodies(client: BulletClient, scene: Scene, *, visible: bool = False) -> dict[str, int]:
    """Objects at their poses, obstacles parked: ids of the scene to ids of pybullet."""
    found: dict[str, int] = {}
    for i, b in enumerate((*scene.objects, *scene.obstacles)):
        xyz = b.pose.xyz_m if b.pose is not None else parking_spot(i, b.size_m[2])
        quat = b.pose.quat_xyzw if b.pose is not None else (0.0, 0.0, 0.0, 1.0)
        body = int(
            client.createMultiBody(
                b.mass_kg,
                _shape(client, b),
                visual_of(client, b.shape, b.size_m, b.colour) if visible else -1,
                xyz,
                quat,
            )
        )
        rolls = b.shape in ("cylinder", "sphere")
        client.changeDynamics(
            body,
            -1,
            lateralFriction=b.friction,
            spinningFriction=0.002,
            rollingFriction=b.rolling if rolls else 0.0,
            activationState=client.ACTIVATION_STATE_DISABLE_SLEEPING,
        )
        found[b.id] = body
    return found


def mark_slots(client: BulletClient, scene: Scene) -> None:
    """Thin tiles that show where slots and buffers are; for pictures only."""
    for p in scene.places:
        if p.surface_m is None or not (p.is_slot or p.buffer):
            continue
        inset = 0.03 if p.is_slot else 0.0
        size = (p.size_m[0] - inset, p.size_m[1] - inset, 0.001)
        tile = visual_of(client, "box", size, "white" if p.is_slot else "silver")
        client.createMultiBody(0, -1, tile, p.surface_m)
