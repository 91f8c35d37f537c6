"""Pictures of the world, by Bullet's software renderer in a client of its own: looking never changes the physics.

For people there is the `Renderer`, for the robot the `DepthCameras`: the same scene without shadows and markings, the
robot by its collision meshes, which takes a quarter of the time.
"""

from __future__ import annotations

import itertools
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.geometry import Pose, Vec3
from llmbt_ir.scene import Camera, Scene
from llmbt_runtime.bullet.client import BulletClient
from llmbt_runtime.bullet.robot import load_robot
from llmbt_runtime.bullet.scene_builder import add_bodies, add_fixtures, mark_slots
from llmbt_runtime.perception.rgbd import RgbdImage

if TYPE_CHECKING:
    from llmbt_runtime.bullet.world import BulletWorld

__all__ = ["DEFAULT_CAMERA", "DepthCameras", "Renderer", "Snapshot", "Window", "encode_png", "render_png"]

DEFAULT_CAMERA = Camera("default", (0.95, 1.55, 1.35), (0.27, 0.15, 0.57), 43.0)
_NEAR_M, _FAR_M = 0.05, 6.0


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What is to be drawn: all joints of the robot, the pose of every body in play, in the world, and where the
    fixtures are once some were pushed."""

    joints: tuple[float, ...]
    poses: dict[str, Pose]
    pushed: dict[str, Vec3] = field(default_factory=dict)


class _Shadow:
    """A scene as it is to be seen, in a client of its own; `detailed` for people, else without the room around."""

    def __init__(self, scene: Scene, *, detailed: bool, window: bool = False) -> None:
        self.client = client = BulletClient(window=window)
        self._fixtures = add_fixtures(client, scene, visible=True) if detailed else {}
        if detailed:
            mark_slots(client, scene)
        loaded = load_robot(client, scene, visible=detailed)
        self.robot, self.tip = loaded.body, loaded.joints.tip
        self._bodies = add_bodies(client, scene, visible=True)
        self._detailed = detailed

    def set(self, snapshot: Snapshot) -> None:
        """Put everything where it is."""
        client = self.client
        for j, value in enumerate(snapshot.joints):
            client.resetJointState(self.robot, j, value)
        for i, (id_, body) in enumerate(self._bodies.items()):
            pose = snapshot.poses.get(id_, Pose((90.0 + i, 90.0, 0.0)))
            client.resetBasePositionAndOrientation(body, pose.xyz_m, pose.quat_xyzw)
        for id_, xyz in snapshot.pushed.items() if self._fixtures else ():
            client.resetBasePositionAndOrientation(self._fixtures[id_], xyz, (0, 0, 0, 1))

    def paint(self, id_: str, rgb: Vec3) -> None:
        """Give a body a colour."""
        self.client.changeVisualShape(self._bodies[id_], -1, rgbaColor=(*rgb, 1.0))

    def image(self, camera: Camera, width: int, height: int) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Colours (height x width x 3) and what Bullet keeps of the depth (height x width, in [0, 1])."""
        return _image(self.client, camera, width, height, shadow=self._detailed)


def _image(
    client: BulletClient, camera: Camera, width: int, height: int, *, shadow: bool
) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    view = client.computeViewMatrix(camera.eye_m, camera.target_m, camera.up_m)
    projection = list(client.computeProjectionMatrixFOV(camera.fov_deg, width / height, _NEAR_M, _FAR_M))
    # the renderer samples a pixel at its lower left corner: half a pixel aside, it is at the centre
    projection[8] += 1 / width
    projection[9] += 1 / height
    image = client.getCameraImage(
        width,
        height,
        view,
        projection,
        lightDirection=(0.6, 0.9, 1.6),
        shadow=int(shadow),
        lightAmbientCoeff=0.55,
        lightDiffuseCoeff=0.5,
        lightSpecularCoeff=0.05,
        renderer=client.ER_TINY_RENDERER,
    )
    rgba = np.reshape(np.asarray(image[2], dtype=np.uint8), (height, width, 4))
    depth = np.reshape(np.asarray(image[3], dtype=np.float32), (height, width))
    return np.ascontiguousarray(rgba[:, :, :3]), depth


class _Room:
    """The floor and the fixtures, which are drawn once for each view, and again only once some were pushed."""

    def __init__(self, scene: Scene) -> None:
        self.client = BulletClient()
        self._fixtures = add_fixtures(self.client, scene, visible=True)
        self._pushed: dict[str, Vec3] = {}
        self._images: dict[tuple[Camera, int, int], tuple[NDArray[np.uint8], NDArray[np.float32]]] = {}

    def image(
        self, pushed: Mapping[str, Vec3], camera: Camera, width: int, height: int
    ) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """As `_image` has it; not to be written to."""
        if pushed != self._pushed:
            self._pushed, self._images = dict(pushed), {}
            for id_, xyz in pushed.items():
                self.client.resetBasePositionAndOrientation(self._fixtures[id_], xyz, (0, 0, 0, 1))
        key = camera, width, height
        if key not in self._images:
            self._images[key] = _image(self.client, camera, width, height, shadow=False)
        return self._images[key]


class Renderer:
    """Draws snapshots of one scene. The first one costs some 0.4 s for the robot's meshes."""

    def __init__(self, scene: Scene) -> None:
        self._shadow = _Shadow(scene, detailed=True)

    def draw(self, snapshot: Snapshot, camera: Camera, width: int, height: int) -> NDArray[np.uint8]:
        """An image, height x width x 3, red green blue."""
        self._shadow.set(snapshot)
        return self._shadow.image(camera, width, height)[0]

    def close(self) -> None:
        """Disconnect."""
        self._shadow.client.close()


class Window:
    """Bullet's own window, where there is a screen."""

    def __init__(self, scene: Scene) -> None:
        self._shadow = _Shadow(scene, detailed=True, window=True)

    def show(self, snapshot: Snapshot) -> None:
        """What it shows from now on."""
        self._shadow.set(snapshot)

    def close(self) -> None:
        """Close it."""
        self._shadow.client.close()


class DepthCameras:
    """The scene's cameras, as sensors of colour and depth: ideal but for their resolution (add noise to taste).

    `paint` gives bodies other colours than their words' (by id; red, green, blue in [0, 1]).
    """

    def __init__(self, scene: Scene, paint: Mapping[str, Vec3] | None = None) -> None:
        self._shadow, self._room = _Shadow(scene, detailed=False), _Room(scene)
        for id_, rgb in (paint or {}).items():
            self._shadow.paint(id_, rgb)
        self._links = _links(self._shadow.client, self._shadow.robot)

    def look(self, snapshot: Snapshot, camera: Camera, scale: float = 1.0) -> RgbdImage:
        """What a camera sees, at a part of its resolution."""
        self._shadow.set(snapshot)
        width, height = max(1, round(camera.width_px * scale)), max(1, round(camera.height_px * scale))
        rgb, near = self._shadow.image(camera, width, height)
        behind, far = self._room.image(snapshot.pushed, camera, width, height)
        stored = np.minimum(near, far).astype(np.float64)
        depth = _FAR_M * _NEAR_M / (_FAR_M - (_FAR_M - _NEAR_M) * stored)
        rgb = np.where((near <= far)[:, :, None], rgb, behind)
        return RgbdImage(camera, rgb, np.where(stored < 1.0, depth, np.inf))

    def robot(self, snapshot: Snapshot) -> tuple[NDArray[np.float64], ...]:
        """The vertices (M x 3, world) of each of the robot's links, by its joints and its model."""
        self._shadow.set(snapshot)
        client, robot = self._shadow.client, self._shadow.robot
        found = []
        for link, vertices in self._links.items():
            if link < 0:
                xyz, quat = client.getBasePositionAndOrientation(robot)
            else:
                xyz, quat = client.getLinkState(robot, link, computeForwardKinematics=1)[:2]
            turn = np.reshape(client.getMatrixFromQuaternion(quat), (3, 3))
            found.append(vertices @ turn.T + np.asarray(xyz))
        return tuple(found)

    def tip(self, joints: tuple[float, ...]) -> Pose:
        """Where the fingers meet, by the joints."""
        self._shadow.set(Snapshot(joints, {}))
        client, robot = self._shadow.client, self._shadow.robot
        xyz, quat = client.getLinkState(robot, self._shadow.tip, computeForwardKinematics=1)[4:6]
        return Pose(tuple(xyz), tuple(quat))

    def close(self) -> None:
        """Disconnect."""
        self._shadow.client.close()
        self._room.client.close()


def _links(client: BulletClient, robot: int) -> dict[int, NDArray[np.float64]]:
    """The collision vertices of each link that has some, in the frame of its centre of mass."""
    found = {}
    for link in range(-1, client.getNumJoints(robot)):
        shapes = [_vertices(client, robot, link, s) for s in client.getCollisionShapeData(robot, link)]
        if shapes:
            found[link] = np.concatenate(shapes)
    return found


def _vertices(client: BulletClient, robot: int, link: int, shape: Any) -> NDArray[np.float64]:
    """The corners of one collision shape, those of a box around a cylinder, in the frame of the link's centre."""
    kind, size, at, turn = shape[2], shape[3], shape[5], shape[6]
    if kind == client.GEOM_MESH:
        return np.asarray(client.getMeshData(robot, link)[1], dtype=np.float64)
    x, y, z = (size[1], size[1], size[0]) if kind == client.GEOM_CYLINDER else size
    if kind == client.GEOM_CYLINDER:
        x, y = 2 * x, 2 * y
    corners = np.array(list(itertools.product((-x / 2, x / 2), (-y / 2, y / 2), (-z / 2, z / 2))))
    rotation = np.reshape(np.asarray(client.getMatrixFromQuaternion(turn), dtype=np.float64), (3, 3))
    return corners @ rotation.T + np.asarray(at, dtype=np.float64)


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
