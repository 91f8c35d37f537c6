"""What a scene is made of: robot, fixtures, places, bodies, cameras. Metres, kilograms, radians, world frame."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType

from llmbt_ir.geometry import Pose, Viewpoint

__all__ = [
    "COLOURS",
    "MAX_GRASP_M",
    "PLATFORM_RADIUS_M",
    "ROBOT_FOOTPRINT_M",
    "SUPPORT_TOLERANCE_M",
    "Body",
    "Camera",
    "Fixture",
    "RobotModel",
    "Scene",
    "ScenePlace",
]

Vec2 = tuple[float, float]
Vec3 = tuple[float, float, float]

SLOT_TOLERANCE_M = 0.02
"""A body is on a slot when its centre is within this of the slot's, in x and in y."""
SUPPORT_TOLERANCE_M = 0.01
"""A body is on a surface when its bottom is within this of it."""
ROBOT_FOOTPRINT_M = (0.22, 0.22, 0.40)
"""Of an arm that is bolted down: the extents of its base."""
PLATFORM_RADIUS_M = 0.25
"""The mobile robot's platform is a disc from the floor up to the arm's base."""
MAX_GRASP_M = 0.07
"""The widest thing that the gripper of a panda closes on, with room for the fingers."""
_PLUMB = 1e-3
"""A camera looks straight down, or up, where it goes aside by less than this part of its way."""
DEFAULT_MASS_KG = 0.08
DEFAULT_FRICTION = 0.8
DEFAULT_ROLLING = 0.001
"""Rolling friction of cylinders and spheres: the lever arm in metres, as on a hard floor."""

COLOURS: Mapping[str, Vec3] = MappingProxyType(
    {
        "red": (0.82, 0.16, 0.15),
        "green": (0.20, 0.62, 0.25),
        "blue": (0.16, 0.36, 0.75),
        "yellow": (0.95, 0.80, 0.15),
        "orange": (0.95, 0.50, 0.10),
        "purple": (0.50, 0.24, 0.62),
        "pink": (0.93, 0.52, 0.66),
        "brown": (0.45, 0.30, 0.18),
        "black": (0.10, 0.10, 0.10),
        "white": (0.95, 0.95, 0.95),
        "grey": (0.55, 0.56, 0.58),
        "silver": (0.75, 0.76, 0.78),
        "beige": (0.86, 0.80, 0.68),
        "wood": (0.72, 0.56, 0.38),
    }
)
"""The colours a scene may name, as red, green, blue in [0, 1]."""


class RobotModel(StrEnum):
    """A Panda that is bolted down, or one on a platform that drives."""

    PANDA = "panda"
    MOBILE_PANDA = "mobile_panda"


@dataclass(frozen=True, slots=True)
class Fixture:
    """A static, axis-aligned box: centre and full extents. What `moves_with` a place is pushed along with it."""

    id: str
    xyz_m: Vec3
    size_m: Vec3
    colour: str = "grey"
    friction: float = DEFAULT_FRICTION
    moves_with: str | None = None
    line: int = field(default=0, compare=False)

    @property
    def top_m(self) -> float:
        """Height of the upper face."""
        return self.xyz_m[2] + self.size_m[2] / 2


@dataclass(frozen=True, slots=True)
class ScenePlace:
    """A place. `surface_m` is the centre of its horizontal surface, `size_m` its extents in x and y.

    A place without a surface is no more than the sum of the places in it (a shelf of levels).
    """

    id: str
    name: str
    type: str
    parent: str | None = None
    buffer: bool = False
    surface_m: Vec3 | None = None
    size_m: Vec2 = (0.0, 0.0)
    line: int = field(default=0, compare=False)

    @property
    def is_slot(self) -> bool:
        """Whether it takes one object, centred."""
        return self.type == "slot"

    def covers(self, x_m: float, y_m: float, slack_m: float = 0.0) -> bool:
        """Whether a point seen from above counts as on the place: near a slot's centre, or within a region."""
        if self.surface_m is None:
            return False
        dx, dy = abs(x_m - self.surface_m[0]), abs(y_m - self.surface_m[1])
        if self.is_slot:
            return max(dx, dy) <= SLOT_TOLERANCE_M + slack_m
        return dx <= self.size_m[0] / 2 + slack_m and dy <= self.size_m[1] / 2 + slack_m


@dataclass(frozen=True, slots=True)
class Body:
    """A thing that is not fixed: an object in play, with its pose at the start, or a parked obstacle, with none.

    `size_m` are full extents along the body's own axes; a cylinder's are diameter, diameter, height. `rolling` is
    the rolling friction of what is round. What is not `movable` is too wide or too heavy for the robot.
    """

    id: str
    name: str
    type: str
    colour: str
    shape: str
    size_m: Vec3
    mass_kg: float = DEFAULT_MASS_KG
    friction: float = DEFAULT_FRICTION
    pose: Pose | None = None
    rolling: float = DEFAULT_ROLLING
    movable: bool = True
    line: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Camera:
    """A pinhole camera that looks from `eye_m` at `target_m`, up being up; `fov_deg` is the vertical angle. Where it
    looks straight down or up, the top of its image is where x points."""

    id: str
    eye_m: Vec3
    target_m: Vec3
    fov_deg: float = 45.0
    width_px: int = 640
    height_px: int = 480

    @property
    def up_m(self) -> Vec3:
        """A direction that shows upwards in its image, never that in which it looks."""
        dx, dy, dz = (b - a for a, b in zip(self.eye_m, self.target_m, strict=True))
        return (1.0, 0.0, 0.0) if math.hypot(dx, dy) < _PLUMB * abs(dz) else (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Scene:
    """Everything a world is built from. Ids are unique over fixtures, places, objects, obstacles and cameras."""

    name: str
    library: str
    robot_xyz_m: Vec3
    robot_yaw_rad: float
    fixtures: tuple[Fixture, ...]
    places: tuple[ScenePlace, ...]
    objects: tuple[Body, ...]
    obstacles: tuple[Body, ...] = ()
    cameras: tuple[Camera, ...] = ()
    viewer: Viewpoint | None = None
    description: str = ""
    robot: RobotModel = RobotModel.PANDA
    source: str = field(default="scene.xml", compare=False)

    def place(self, id_: str) -> ScenePlace:
        """The place with this id; KeyError where there is none."""
        for p in self.places:
            if p.id == id_:
                return p
        raise KeyError(id_)

    def with_containers(self, place: str) -> Iterator[str]:
        """The place itself and the places that contain it, innermost first."""
        here: str | None = place
        while here is not None:
            yield here
            here = self.place(here).parent

    def depth(self, place: str) -> int:
        """How many places contain it."""
        return sum(1 for _ in self.with_containers(place)) - 1

    def precedence(self, place: ScenePlace) -> tuple[float, bool, float, str]:
        """The order in which places are asked whether something is on them: the innermost first, a slot before what
        takes many, the smaller surface before the larger."""
        return -self.depth(place.id), not place.is_slot, place.size_m[0] * place.size_m[1], place.id

    def most_specific(self, x_m: float, y_m: float, bottom_m: float) -> str | None:
        """The innermost place that a body stands on, given its centre from above and the height of its bottom."""
        found = [
            p
            for p in self.places
            if p.surface_m is not None and p.covers(x_m, y_m) and abs(bottom_m - p.surface_m[2]) <= SUPPORT_TOLERANCE_M
        ]
        return min(found, key=self.precedence).id if found else None
