"""The semantic map: what stands where in a scene, as the compiler and a person read it (paper, section IV.A).

Every thing has an id, a name, a colour, a shape, a size and a pose in metres in the world frame, and the most
specific place it stands on. Places form a forest by `parent`: a thing on a place is on each of its containers; where
they have a surface, the map says where it is. The viewpoint is the one that "left" and "behind" are said from.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from lxml import etree

from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span, nearest
from llmbt_ir.geometry import Pose, Viewpoint
from llmbt_ir.xml import Element, line_of, parse_xml, read_bytes

__all__ = ["MapObject", "MapPlace", "SemanticMap", "parse_map", "read_map", "write_map"]


@dataclass(frozen=True, slots=True)
class MapObject:
    """A movable thing. `place` is the most specific place it stands on, None where it stands on none. `held`: the
    gripper holds it."""

    id: str
    name: str
    colour: str
    shape: str
    size_m: tuple[float, float, float]
    pose: Pose
    place: str | None = None
    type: str = "object"
    held: bool = False
    line: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class MapPlace:
    """A place. `type` is one of the library's place types (as slot, region, level); `buffer` allows putting aside.

    `surface_m` is the centre of its horizontal surface and `size_m` the surface's extents in x and y; None where the
    place has none of its own, or where it is not known.
    """

    id: str
    name: str
    type: str
    parent: str | None = None
    buffer: bool = False
    line: int = field(default=0, compare=False)
    surface_m: tuple[float, float, float] | None = None
    size_m: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class SemanticMap:
    """Objects and places of one scene; ids are unique over both."""

    scene: str
    library: str
    objects: tuple[MapObject, ...] = ()
    places: tuple[MapPlace, ...] = ()
    source: str = field(default="map.xml", compare=False)
    viewpoint: Viewpoint = field(default_factory=Viewpoint)

    def object(self, id_: str) -> MapObject | None:
        """The object with this id."""
        return next((o for o in self.objects if o.id == id_), None)

    def place(self, id_: str) -> MapPlace | None:
        """The place with this id."""
        return next((p for p in self.places if p.id == id_), None)

    def containers(self, place: str) -> Iterator[str]:
        """The places that contain `place`, innermost first."""
        here = self.place(place)
        while here is not None and here.parent is not None:
            yield here.parent
            here = self.place(here.parent)

    def inside(self, container: str) -> tuple[MapPlace, ...]:
        """The places within a place, at any depth, in the order of the file."""
        return tuple(p for p in self.places if container in self.containers(p.id))

    def on(self, place: str) -> tuple[MapObject, ...]:
        """The objects that stand on a place or on a place within it."""
        return tuple(
            o for o in self.objects if o.place is not None and (o.place == place or place in self.containers(o.place))
        )


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(f"{v:.4f}".rstrip("0").rstrip(".") if round(v, 4) else "0" for v in values)


def write_map(semantic_map: SemanticMap) -> bytes:
    """The map as canonical XML: fixed attribute order, one element a line, lengths to a tenth of a millimetre."""
    root = etree.Element("SemanticMap", scene=semantic_map.scene, library=semantic_map.library, frame="world")
    seen_by = semantic_map.viewpoint
    attributes = {"of": seen_by.of, "xyz_m": _numbers(seen_by.xyz_m), "yaw_rad": _numbers((seen_by.yaw_rad,))}
    etree.SubElement(root, "Viewpoint", attributes)
    places = etree.SubElement(root, "Places")
    for p in semantic_map.places:
        node = etree.SubElement(places, "Place", id=p.id, name=p.name, type=p.type)
        if p.parent is not None:
            node.set("parent", p.parent)
        if p.buffer:
            node.set("buffer", "true")
        if p.surface_m is not None:
            node.set("surface_m", _numbers(p.surface_m))
            node.set("size_m", _numbers(p.size_m))
    objects = etree.SubElement(root, "Objects")
    for o in semantic_map.objects:
        node = etree.SubElement(
            objects,
            "Object",
            id=o.id,
            name=o.name,
            type=o.type,
            colour=o.colour,
            shape=o.shape,
            size_m=_numbers(o.size_m),
            xyz_m=_numbers(o.pose.xyz_m),
            quat_xyzw=_numbers(o.pose.quat_xyzw),
        )
        if o.place is not None:
            node.set("place", o.place)
        if o.held:
            node.set("held", "true")
    etree.indent(root)
    return bytes(etree.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def read_map(path: Path) -> SemanticMap:
    """Read a map file; faults are diagnostics with the line (E001-E006, E020-E022)."""
    return parse_map(read_bytes(path, "semantic map"), str(path))


def parse_map(data: bytes, source: str = "map.xml") -> SemanticMap:
    """Parse and check a map: ids are unique, every parent and place exists, no place contains itself."""
    root = parse_xml(data, source, schema="semantic_map")
    lines: dict[str, int] = {}
    faults: list[Diagnostic] = []

    def claim(node: Element) -> str:
        id_, line = node.get("id", ""), line_of(node)
        if id_ in lines:
            faults.append(
                Diagnostic("E020", f"id `{id_}` is used twice, first in line {lines[id_]}", Span(source, line))
            )
        lines[id_] = line
        return id_

    places = tuple(
        MapPlace(
            claim(n),
            n.get("name") or n.get("id", "").replace("_", " "),
            n.get("type", "place"),
            n.get("parent"),
            (n.get("buffer") or "").strip() in ("true", "1"),
            line_of(n),
            _triple(n.get("surface_m", "")) if n.get("surface_m") else None,
            _pair(n.get("size_m", "0 0")),
        )
        for n in root.iterfind("Places/Place")
    )
    objects = tuple(
        MapObject(
            claim(n),
            n.get("name") or n.get("id", "").replace("_", " "),
            n.get("colour", ""),
            n.get("shape", ""),
            _triple(n.get("size_m", "0 0 0")),
            Pose(_triple(n.get("xyz_m", "0 0 0")), _quat(n.get("quat_xyzw", "0 0 0 1"))),
            n.get("place"),
            n.get("type", "object"),
            (n.get("held") or "").strip() in ("true", "1"),
            line_of(n),
        )
        for n in root.iterfind("Objects/Object")
    )
    place_ids = {p.id for p in places}
    for id_, wanted in [(p.id, p.parent) for p in places] + [(o.id, o.place) for o in objects]:
        if wanted is not None and wanted not in place_ids:
            close = nearest(wanted, place_ids)
            faults.append(
                Diagnostic(
                    "E021",
                    f"`{id_}` names the unknown place `{wanted}`",
                    Span(source, lines[id_]),
                    help=f"did you mean {', '.join(close)}?" if close else "declare it under <Places>",
                    candidates=close,
                )
            )
    parent = {p.id: p.parent for p in places}
    for p in places:
        seen, here = {p.id}, p.parent
        while here is not None and here in parent:
            if here in seen:
                faults.append(Diagnostic("E022", f"place `{p.id}` contains itself", Span(source, lines[p.id])))
                break
            seen.add(here)
            here = parent[here]
    if faults:
        raise LlmbtError(*faults)
    viewpoint = _viewpoint(root.find("Viewpoint"))
    return SemanticMap(root.get("scene", ""), root.get("library", ""), objects, places, source, viewpoint)


def _viewpoint(node: Element | None) -> Viewpoint:
    if node is None:
        return Viewpoint()
    return Viewpoint(node.get("of", "robot"), _triple(node.get("xyz_m", "0 0 0")), float(node.get("yaw_rad", "0")))


def _pair(text: str) -> tuple[float, float]:
    x, y = (float(v) for v in text.split())
    return x, y


def _triple(text: str) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in text.split())
    return x, y, z


def _quat(text: str) -> tuple[float, float, float, float]:
    x, y, z, w = (float(v) for v in text.split())
    return x, y, z, w
