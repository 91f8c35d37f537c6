"""Random scenes over the cargo table, with what is really there: for developing recognition and for judging it.

A `Kit` says what may come: colours, sizes, where cameras stand. The one for judging is in tests/evidence/recognition.py
and was drawn apart from the one for developing, which is here.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from llmbt_ir.geometry import Pose, Vec3, quat_from_yaw
from llmbt_ir.scene import Body, Camera, Scene, load_scene
from llmbt_runtime.bullet.camera import Snapshot
from llmbt_runtime.bullet.robot import REST_Q

__all__ = ["DEVELOPMENT", "HARDER", "REST", "Kit", "Staged", "stage"]

Range = tuple[float, float]
REST = (*(float(q) for q in REST_Q), 0.0, 0.0, 0.04, 0.04, 0.0)
"""The robot's joints before a run."""
SHAPES = ("box", "cube", "cylinder", "sphere")


@dataclass(frozen=True)
class Kit:
    """What scenes are made of. `palette`: sRGB examples (hex) of each colour term; `cameras`: azimuths (degrees, from
    the middle of the table) of the sectors in which one camera each stands."""

    palette: Mapping[str, tuple[str, ...]]
    width_m: Range
    height_m: Range
    cameras: tuple[Range, ...]
    radius_m: Range
    eye_height_m: Range
    fov_deg: Range
    touching: float = 0.25
    lying: float = 0.15
    undeclared: float = 0.15
    on_shelf: float = 0.4


CSS = {
    "red": ("ff0000", "dc143c", "b22222", "8b0000"),
    "green": ("008000", "228b22", "32cd32", "2e8b57"),
    "blue": ("0000ff", "4169e1", "1e90ff", "000080", "4682b4"),
    "yellow": ("ffff00", "ffd700"),
    "orange": ("ffa500", "ff8c00"),
    "purple": ("800080", "663399", "9932cc", "9370db"),
    "pink": ("ffc0cb", "ffb6c1", "ff69b4"),
    "brown": ("8b4513", "a0522d"),
    "black": ("000000", "191919"),
    "white": ("ffffff", "f5f5f5"),
    "grey": ("808080", "696969", "a9a9a9"),
}
DEVELOPMENT = Kit(
    CSS, (0.035, 0.06), (0.035, 0.10), ((60, 110), (150, 210), (240, 300)), (1.1, 1.4), (1.0, 1.3), (42, 48)
)

PAINTS = {
    "red": ("a72920", "9b2423", "8d1d2c", "c1121c", "b32821"),
    "green": ("327662", "0f4336", "61993b", "008351", "008754", "00b51a"),
    "blue": ("13447c", "0b4a80", "005387", "2271b3", "0e518d", "004f7c"),
    "yellow": ("f6b600", "f7b500", "fcbd1f", "f3a505"),
    "orange": ("dd7907", "be4e20", "e55137", "f46f29"),
    "purple": ("6d3f5b", "7c4d7f", "844c82", "a03472"),
    "pink": ("d8a0a6", "d36e70", "e1a6ad"),
    "brown": ("7e4b26", "7b5141", "8f4e35", "59351f", "45322e"),
    "black": ("0a0a0d", "131516"),
    "white": ("fcfcff", "ecece7", "f1ede1"),
    "grey": ("78858b", "8b9298", "7f7679", "6f7c7c", "9b9b9b", "8d948d"),
}
"""After a paint maker's chart (RAL Classic), by hand and approximately; several are on a border between two terms."""
HARDER = Kit(
    {term: (*CSS[term], *PAINTS[term]) for term in CSS},
    (0.028, 0.072),
    (0.03, 0.13),
    ((40, 130), (135, 230), (235, 320)),
    (1.0, 1.6),
    (0.9, 1.5),
    (40, 55),
    touching=0.4,
    lying=0.25,
    undeclared=0.25,
)


@dataclass(frozen=True)
class Staged:
    """A scene, what the recogniser is told of it, and what is really there."""

    truth: Scene
    told: Scene
    paint: Mapping[str, Vec3]
    terms: Mapping[str, str]
    snapshot: Snapshot
    touching: frozenset[str] = field(default=frozenset())


@dataclass
class _Stage:
    kit: Kit
    rng: np.random.Generator
    base: Scene
    taken: list[tuple[float, float, float]] = field(default_factory=list)

    def size(self, shape: str) -> Vec3:
        a, b = self.rng.uniform(*self.kit.width_m, 2)
        h = float(self.rng.uniform(*self.kit.height_m))
        a, b = round(float(a), 3), round(float(b), 3)
        match shape:
            case "cube" | "sphere":
                return a, a, a
            case "cylinder":
                return a, a, round(h, 3)
            case _:
                return a, b, round(h, 3)

    def free(self, x: float, y: float, r: float) -> bool:
        return all(math.hypot(x - u, y - v) > r + s + 0.012 for u, v, s in self.taken)

    def spots(self, size: Vec3) -> Iterator[tuple[Vec3, float]]:
        """Places for a thing of this size, its bottom's centre and a yaw: on a shelf level, or on the workbench."""
        r = math.hypot(size[0], size[1]) / 2
        levels = [p for p in self.base.places if p.is_slot and p.surface_m is not None]
        for _ in range(200):
            if self.rng.random() < self.kit.on_shelf and max(size[:2]) < 0.075:
                slot = levels[int(self.rng.integers(len(levels)))]
                assert slot.surface_m is not None
                dx, dy = self.rng.uniform(-0.008, 0.008), self.rng.uniform(-0.03, 0.03)
                x, y, z = slot.surface_m[0] + dx, slot.surface_m[1] + dy, slot.surface_m[2]
                yaw = float(self.rng.uniform(-0.3, 0.3))
            else:
                x, y, z = float(self.rng.uniform(-0.08, 0.40)), float(self.rng.uniform(0.33, 0.61)), 0.4
                yaw = float(self.rng.uniform(-math.pi, math.pi))
            if self.free(x, y, r):
                self.taken.append((x, y, r))
                yield (float(x), float(y), z), yaw


def stage(kit: Kit, seed: int) -> Staged:
    """The scene of a seed."""
    rng = np.random.default_rng(seed)
    base = load_scene("cargo_sorting")
    here = _Stage(kit, rng, base)
    bodies: list[Body] = []
    paint: dict[str, Vec3] = {}
    terms: dict[str, str] = {}
    touching: set[str] = set()

    def add(shape: str, size: Vec3, pose: Pose, term: str, hex_: str) -> None:
        id_ = f"object_{len(bodies) + 1}"
        bodies.append(Body(id_, f"{term} {shape}", "object", term, shape, size, pose=pose))
        paint[id_] = (int(hex_[:2], 16) / 255, int(hex_[2:4], 16) / 255, int(hex_[4:], 16) / 255)
        terms[id_] = term

    for _ in range(int(rng.integers(5, 9))):
        shape = str(rng.choice(SHAPES))
        size = here.size(shape)
        term = str(rng.choice(sorted(kit.palette)))
        hex_ = str(rng.choice(kit.palette[term]))
        pair = shape in ("box", "cube") and rng.random() < kit.touching
        lies = shape == "cylinder" and rng.random() < kit.lying
        around = (size[0], 2.2 * size[1], size[2]) if pair else (size[2], size[0], size[0]) if lies else size
        found = next(here.spots(around), None)
        if found is None:
            continue
        (x, y, z), yaw = found
        if pair:
            slide = float(rng.uniform(-0.4, 0.4)) * size[0]
            for side in (-1, 1):
                across = side * (size[1] / 2 + 0.0002)
                along = side * slide / 2
                px = x + math.cos(yaw) * along - math.sin(yaw) * across
                py = y + math.sin(yaw) * along + math.cos(yaw) * across
                add(shape, size, Pose((px, py, z + size[2] / 2), quat_from_yaw(yaw)), term, hex_)
                touching.add(bodies[-1].id)
        elif lies:
            half = math.sqrt(0.5)
            c, s = math.cos(yaw / 2), math.sin(yaw / 2)
            quat = (-s * half, c * half, s * half, c * half)  # about y by 90 degrees, then about z by yaw
            add(shape, size, Pose((x, y, z + size[0] / 2), quat), term, hex_)
        else:
            add(shape, size, Pose((x, y, z + size[2] / 2), quat_from_yaw(yaw)), term, hex_)
    cameras = tuple(_camera(kit, rng, k, sector) for k, sector in enumerate(kit.cameras))
    truth = replace(base, objects=tuple(bodies), obstacles=(), cameras=cameras)
    declared = tuple(replace(b, pose=None) for b in bodies if b.id in touching or rng.random() >= kit.undeclared)
    snapshot = Snapshot(REST, {b.id: b.pose for b in bodies if b.pose is not None})
    return Staged(truth, replace(truth, objects=declared), paint, terms, snapshot, frozenset(touching))


def _camera(kit: Kit, rng: np.random.Generator, k: int, sector: Range) -> Camera:
    azimuth, radius = math.radians(rng.uniform(*sector)), rng.uniform(*kit.radius_m)
    middle = (0.29 + rng.uniform(-0.05, 0.05), 0.2 + rng.uniform(-0.05, 0.05), 0.45)
    eye = (
        float(middle[0] + radius * math.cos(azimuth)),
        float(middle[1] + radius * math.sin(azimuth)),
        0.4 + float(rng.uniform(*kit.eye_height_m)),
    )
    return Camera(f"camera_{k + 1}", eye, middle, float(rng.uniform(*kit.fov_deg)))


assert set(itertools.chain(CSS)) == set(DEVELOPMENT.palette)
