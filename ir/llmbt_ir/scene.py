"""Scenes: what stands where before a run, as a person writes it (scenes/*.xml).

A scene names a robot, static fixtures, places with their surfaces, the objects in play, the obstacles that are
parked out of sight until a disturbance brings one in, and cameras. Metres, kilograms, radians; world frame, z up.
The schema is schemas/scene.rng; `docs` of each element is in scenes/cargo_sorting.xml.
"""

from __future__ import annotations

import importlib.resources
import math
from collections.abc import Iterable, Mapping
from pathlib import Path

from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span, nearest
from llmbt_ir.geometry import Box, Pose, Viewpoint, quat_from_yaw
from llmbt_ir.scene_model import (
    COLOURS,
    DEFAULT_FRICTION,
    DEFAULT_MASS_KG,
    DEFAULT_ROLLING,
    MAX_GRASP_M,
    PLATFORM_RADIUS_M,
    ROBOT_FOOTPRINT_M,
    SUPPORT_TOLERANCE_M,
    Body,
    Camera,
    Fixture,
    RobotModel,
    Scene,
    ScenePlace,
    Vec3,
)
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap
from llmbt_ir.solids import overlaps
from llmbt_ir.xml import Element, line_of, parse_xml, read_bytes

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
    "load_scene",
    "parse_scene",
    "read_scene",
    "scene_names",
    "to_semantic_map",
]

REACH_M = 0.8
"""How far from its base the arm puts things down from above."""

NEAREST_TARGET_M = 1e-3
"""A camera's target is at least so far from it."""


def to_semantic_map(scene: Scene) -> SemanticMap:
    """What the compiler gets to know of a scene at its start: objects and places; parked obstacles are left out."""
    objects = tuple(
        MapObject(
            id=o.id,
            name=o.name,
            colour=o.colour,
            shape=o.shape,
            size_m=o.size_m,
            pose=o.pose,
            place=scene.most_specific(*o.pose.xyz_m[:2], o.pose.xyz_m[2] - o.size_m[2] / 2),
            type=o.type,
            line=o.line,
        )
        for o in scene.objects
        if o.pose is not None
    )
    places = tuple(
        MapPlace(p.id, p.name, p.type, p.parent, p.buffer, p.line, p.surface_m, p.size_m) for p in scene.places
    )
    viewpoint = scene.viewer or Viewpoint("robot", scene.robot_xyz_m, scene.robot_yaw_rad)
    return SemanticMap(scene.name, scene.library, objects, places, scene.source, viewpoint)


def _folder() -> Path:
    """Where the shipped scenes are: in the wheel, or at the top of a checkout."""
    shipped = Path(str(importlib.resources.files("llmbt_ir"))) / "_shipped" / "scenes"
    return shipped if shipped.is_dir() else Path(__file__).resolve().parents[2] / "scenes"


def scene_names() -> tuple[str, ...]:
    """The scenes that are shipped."""
    return tuple(sorted(p.stem for p in _folder().glob("*.xml")))


def load_scene(name_or_path: str) -> Scene:
    """A shipped scene by its name, any other by its path. Errors as `parse_scene`, and E040 for an unknown name."""
    if name_or_path in scene_names():
        return read_scene(_folder() / f"{name_or_path}.xml")
    path = Path(name_or_path)
    if not path.exists() and path.suffix != ".xml":
        close = nearest(name_or_path, scene_names())
        raise LlmbtError(
            Diagnostic(
                "E040",
                f"unknown scene `{name_or_path}`",
                help=(f"did you mean {close[0]}? " if close else "")
                + f"shipped: {', '.join(scene_names())}; or give the path of an .xml file",
                candidates=close,
            )
        )
    return read_scene(path)


def read_scene(path: Path) -> Scene:
    """Read a scene file; errors as `parse_scene`, and E001, E002 where it cannot be read."""
    return parse_scene(read_bytes(path, "scene"), str(path))


def parse_scene(data: bytes, source: str = "scene.xml") -> Scene:
    """Parse and check a scene.

    Errors, all with a line: E003-E006 as XML; E020 an id used twice; E021 an unknown place; E022 a place that
    contains itself; E041 a body that stands on a place without a surface; E042 bodies that overlap at the start;
    E039 a camera that looks at where it is; E043 an unknown colour; E044 a body that the gripper cannot hold;
    E045 a ball or cylinder with two diameters; E046 an object with no position, or two.
    """
    root = parse_xml(data, source, schema="scene")
    return _Reader(root, source).scene()


_BODY = ("id", "colour", "shape", "size_m")
_REQUIRED: Mapping[str, tuple[str, ...]] = {
    "Scene": ("name", "library"),
    "Robot": ("model", "xyz_m"),
    "Fixture": ("id", "xyz_m", "size_m"),
    "Place": ("id", "type"),
    "Object": _BODY,
    "Obstacle": _BODY,
    "Camera": ("id", "eye_m", "target_m"),
    "Viewer": ("xyz_m",),
}


class _Reader:
    """Collects every fault of a document before it raises."""

    def __init__(self, root: Element, source: str) -> None:
        self.root, self.source = root, source
        self.faults: list[Diagnostic] = []
        self.lines: dict[str, int] = {}

    def fault(self, code: str, title: str, line: int, help_: str = "", candidates: tuple[str, ...] = ()) -> None:
        self.faults.append(Diagnostic(code, title, Span(self.source, line), help=help_, candidates=candidates))

    def check_required(self) -> None:
        """What every element must have, which the schema leaves to us for the sake of the line numbers."""
        nodes: list[Element] = [self.root, *self.root.iterfind(".//*")]
        for node in nodes:
            for name in _REQUIRED.get(str(node.tag), ()):
                if node.get(name) is None:
                    self.fault("E006", f"<{node.tag}> lacks the attribute `{name}`", line_of(node))
        if self.faults:
            raise LlmbtError(*self.faults)

    def scene(self) -> Scene:
        root = self.root
        self.check_required()
        robot = root.find("Robot")
        assert robot is not None  # the schema wants it
        fixtures = tuple(self.fixture(n) for n in root.iterfind("Fixtures/Fixture"))
        places = tuple(self.place(n) for n in root.iterfind("Places/Place"))
        self.check_hierarchy(places)
        by_id = {p.id: p for p in places}
        for f in fixtures:
            if f.moves_with is not None and f.moves_with not in by_id:
                self.unknown_place(f.id, f.moves_with, by_id)
        objects = tuple(self.body(n, "object", by_id) for n in root.iterfind("Objects/Object"))
        obstacles = tuple(self.body(n, "obstacle", by_id) for n in root.iterfind("Obstacles/Obstacle"))
        cameras = tuple(self.camera(n) for n in root.iterfind("Cameras/Camera"))
        xyz = _triple(robot.get("xyz_m"))
        model = RobotModel(robot.get("model", "panda"))
        if not self.faults:
            for o, other in overlaps(fixtures, objects, xyz, model):
                hint = 'xyz_m is the centre of a body; on="..." with offset_m puts it onto a surface'
                self.fault("E042", f"`{o.id}` overlaps {other} at the start", o.line, hint)
            self.check_slots(fixtures, places, xyz, model)
        if self.faults:
            raise LlmbtError(*self.faults)
        return Scene(
            name=root.get("name", ""),
            library=root.get("library", ""),
            robot_xyz_m=xyz,
            robot_yaw_rad=float(robot.get("yaw_rad", "0")),
            fixtures=fixtures,
            places=places,
            objects=objects,
            obstacles=obstacles,
            cameras=cameras,
            viewer=self.viewer(),
            description=" ".join((root.findtext("Description") or "").split()),
            robot=model,
            source=self.source,
        )

    def claim(self, node: Element) -> str:
        id_, line = node.get("id", ""), line_of(node)
        if id_ in self.lines:
            self.fault("E020", f"id `{id_}` is used twice, first in line {self.lines[id_]}", line)
        self.lines.setdefault(id_, line)
        return id_

    def colour(self, node: Element, default: str) -> str:
        colour = node.get("colour", default)
        if colour not in COLOURS:
            close = nearest(colour, COLOURS)
            hint = f"did you mean {', '.join(close)}?" if close else f"known: {', '.join(COLOURS)}"
            self.fault("E043", f"unknown colour `{colour}`", line_of(node), hint, close)
        return colour

    def fixture(self, node: Element) -> Fixture:
        return Fixture(
            id=self.claim(node),
            xyz_m=_triple(node.get("xyz_m")),
            size_m=_triple(node.get("size_m")),
            colour=self.colour(node, "grey"),
            friction=float(node.get("friction", DEFAULT_FRICTION)),
            moves_with=node.get("moves_with"),
            line=line_of(node),
        )

    def place(self, node: Element) -> ScenePlace:
        id_ = self.claim(node)
        sx, sy = (float(v) for v in node.get("size_m", "0 0").split())
        return ScenePlace(
            id=id_,
            name=node.get("name") or id_.replace("_", " "),
            type=node.get("type", ""),
            parent=node.get("parent"),
            buffer=node.get("buffer", "").strip() in ("true", "1"),
            surface_m=_triple(node.get("surface_m")) if node.get("surface_m") else None,
            size_m=(sx, sy),
            line=line_of(node),
        )

    def camera(self, node: Element) -> Camera:
        id_, eye, target = self.claim(node), _triple(node.get("eye_m")), _triple(node.get("target_m"))
        if math.dist(eye, target) < NEAREST_TARGET_M:
            title = f"camera `{id_}` looks at where it is: its target_m is its eye_m"
            self.fault("E039", title, line_of(node), "target_m is a point that it has in the middle of its image")
        return Camera(
            id=id_,
            eye_m=eye,
            target_m=target,
            fov_deg=float(node.get("fov_deg", "45")),
            width_px=int(node.get("width_px", "640")),
            height_px=int(node.get("height_px", "480")),
        )

    def viewer(self) -> Viewpoint | None:
        node = self.root.find("Viewer")
        if node is None:
            return None
        return Viewpoint(node.get("of", "user"), _triple(node.get("xyz_m")), float(node.get("yaw_rad", "0")))

    def body(self, node: Element, type_: str, places: Mapping[str, ScenePlace]) -> Body:
        id_, line = self.claim(node), line_of(node)
        size = _triple(node.get("size_m"))
        movable = (node.get("movable") or "true").strip() in ("true", "1")
        if movable and min(size[0], size[1]) > MAX_GRASP_M:
            self.fault(
                "E044",
                f"`{id_}` is wider than the gripper opens ({MAX_GRASP_M:g} m) in x and in y",
                line,
                "make one of the first two numbers of size_m smaller",
            )
        self.check_round(id_, node.get("shape", "box"), size, line)
        return Body(
            id=id_,
            name=node.get("name") or id_.replace("_", " "),
            type=node.get("type") or type_,
            colour=self.colour(node, "grey"),
            shape=node.get("shape", "box"),
            size_m=size,
            mass_kg=float(node.get("mass_kg", DEFAULT_MASS_KG)),
            friction=float(node.get("friction", DEFAULT_FRICTION)),
            rolling=float(node.get("rolling", DEFAULT_ROLLING)),
            pose=self.pose(node, id_, size, places),
            movable=movable,
            line=line,
        )

    def check_round(self, id_: str, shape: str, size: Vec3, line: int) -> None:
        """What is round has one diameter."""
        across = {"sphere": size, "cylinder": size[:2]}.get(shape, (1.0,))
        if not math.isclose(min(across), max(across)):
            hint = f"size_m of a {shape} is diameter, diameter, {'height' if shape == 'cylinder' else 'diameter'}"
            self.fault("E045", f"the {shape} `{id_}` has more than one diameter", line, hint)

    def pose(self, node: Element, id_: str, size: Vec3, places: Mapping[str, ScenePlace]) -> Pose | None:
        quat = quat_from_yaw(float(node.get("yaw_rad", "0")))
        if node.tag == "Object" and (node.get("xyz_m") is None) == (node.get("on") is None):
            self.fault(
                "E046",
                f"`{id_}` needs either xyz_m or on to say where it stands",
                self.lines[id_],
                'on="PLACE" with offset_m="dx dy", or xyz_m="x y z" of its centre',
            )
            return None
        if node.get("xyz_m"):
            return Pose(_triple(node.get("xyz_m")), quat)
        wanted = node.get("on")
        if wanted is None:
            return None
        if wanted not in places:
            self.unknown_place(id_, wanted, places)
            return None
        surface = places[wanted].surface_m
        if surface is None:
            inside = tuple(p.id for p in places.values() if p.parent == wanted)
            self.fault(
                "E041",
                f"`{id_}` cannot stand on `{wanted}`, which has no surface of its own",
                self.lines[id_],
                f"name a place in it, as {inside[0]}" if inside else "give the place surface_m and size_m",
                inside,
            )
            return None
        dx, dy = (float(v) for v in node.get("offset_m", "0 0").split())
        return Pose((surface[0] + dx, surface[1] + dy, surface[2] + size[2] / 2), quat)

    def unknown_place(self, id_: str, wanted: str, places: Iterable[str]) -> None:
        close = nearest(wanted, places)
        hint = f"did you mean {', '.join(close)}?" if close else "declare it under <Places>"
        self.fault("E021", f"`{id_}` names the unknown place `{wanted}`", self.lines[id_], hint, close)

    def check_hierarchy(self, places: tuple[ScenePlace, ...]) -> None:
        parent = {p.id: p.parent for p in places}
        for p in places:
            if p.parent is not None and p.parent not in parent:
                self.unknown_place(p.id, p.parent, parent)
            seen, here = {p.id}, p.parent
            while here is not None and here in parent:
                if here in seen:
                    self.fault("E022", f"place `{p.id}` contains itself", self.lines[p.id])
                    break
                seen.add(here)
                here = parent[here]

    def check_slots(
        self, fixtures: tuple[Fixture, ...], places: tuple[ScenePlace, ...], robot: Vec3, model: RobotModel
    ) -> None:
        """What is put on a slot stays there, and an arm that is bolted down comes to it."""
        for p in places:
            if not p.is_slot or p.surface_m is None:
                continue
            x, y, z = p.surface_m
            under = [f for f in fixtures if abs(f.top_m - z) < SUPPORT_TOLERANCE_M]
            if not any(Box(f.xyz_m, f.size_m).contains_xy(x, y) for f in under):
                title = f"nothing is under the slot `{p.id}`: no fixture's top is at {z:g} m there"
                self.fault("E047", title, p.line, "set its surface on a fixture, or add one")
            elif model is RobotModel.PANDA and math.hypot(x - robot[0], y - robot[1]) > REACH_M:
                title = f"the slot `{p.id}` is out of the arm's reach of {REACH_M:g} m"
                self.fault("E048", title, p.line, "move it, or the robot")


def _triple(text: str | None) -> Vec3:
    x, y, z = (float(v) for v in (text or "0 0 0").split())
    return x, y, z
