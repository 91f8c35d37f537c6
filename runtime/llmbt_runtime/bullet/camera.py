"""Pictures of the world, by Bullet's software renderer in a client of its own: looking never changes the physics."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.geometry import Pose
from llmbt_ir.scene import Camera, Scene
from llmbt_runtime.bullet.client import BulletClient
from llmbt_runtime.bullet.robot import load_robot
from llmbt_runtime.bullet.scene_builder import add_bodies, add_fixtures, mark_slots

if TYPE_CHECKING:
    from llmbt_runtime.bullet.world import BulletWorld

__all__ = ["DEFAULT_CAMERA", "Renderer", "Snapshot", "encode_png", "render_png"]

DEFAULT_CAMERA = Camera("default", (0.95, 1.55, 1.35), (0.27, 0.15, 0.57), 43.0)
_NEAR_M, _FAR_M = 0.05, 6.0


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What is to be drawn: all joints of the robot, and the pose of every body in play, in the world."""

    joints: tuple[float, ...]
    poses: dict[str, Pose]


class Renderer:
    """Draws snapshots of one scene. The first one costs some 0.4 s for the robot's meshes."""

    def __init__(self, scene: Scene) -> None:
        self._client = client = BulletClient()
        add_fixtures(client, scene, visible=True)
        mark_slots(client, scene)
        self._robot = load_robot(client, scene, visible=True).body
        self._bodies = add_bodies(client, scene, visible=True)

    def draw(self, snapshot: Snapshot, camera: Camera, width: int, height: int) -> NDArray[np.uint8]:
        """An image, height x width x 3, red green blue."""
        client = self._client
        for j, value in enumerate(snapshot.joints):
            client.resetJointState(self._robot, j, value)
        for i, (id_, body) in enumerate(self._bodies.items()):
            pose = snapshot.poses.get(id_, Pose((90.0 + i, 90.0, 0.0)))
            client.resetBasePositionAndOrientation(body, pose.xyz_m, pose.quat_xyzw)
        view = client.computeViewMatrix(camera.eye_m, camera.target_m, (0, 0, 1))
        projection = client.computeProjectionMatrixFOV(camera.fov_deg, width / height, _NEAR_M, _FAR_M)
        image = client.getCameraImage(
            width,
            height,
            view,
            projection,
            lightDirection=(0.6, 0.9, 1.6),
            shadow=1,
            lightAmbientCoeff=0.55,
            lightDiffuseCoeff=0.5,
            lightSpecularCoeff=0.05,
            renderer=client.ER_TINY_RENDERER,
        )
        rgba = np.reshape(np.asarray(image[2], dtype=np.uint8), (height, width, 4))
        return np.ascontiguousarray(rgba[:, :, :3])

    def close(self) -> None:
        """Disconnect."""
        self._client.close()


def encode_png(rgb: NDArray[np.uint8]) -> bytes:
    """An image (height x width x 3) as PNG."""
    height, width, _ = rgb.shape
    rows = np.zeros((height, 1 + 3 * width), dtype=np.uint8)
    rows[:, 1:] = rgb.reshape(height, 3 * width)

    def chunk(kind: bytes, data: bytes) -> bytes:
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", header)
        + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9))
        + chunk(b"IEND", b"")
    )


def render_png(
    world: BulletWorld, path: Path, width: int = 960, height: int = 640, camera: Camera | None = None
) -> None:
    """Write a picture of the world as it is now; drawn at twice the size and averaged."""
    renderer = Renderer(world.scene)
    try:
        camera = camera or next(iter(world.scene.cameras), DEFAULT_CAMERA)
        large = renderer.draw(world.snapshot(), camera, 2 * width, 2 * height)
    finally:
        renderer.close()
    small = large.reshape(height, 2, width, 2, 3).mean(axis=(1, 3))
    path.write_bytes(encode_png(np.round(small).astype(np.uint8)))
