"""`llmbt scene`: what stands where, pictures, what is wrong with a scene, and what its cameras see."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from llmbt.commands.scene_clouds import capture, map_
from llmbt.options import json_flag
from llmbt_ir.diagnostics import ExitCode, Severity

if TYPE_CHECKING:
    from llmbt_ir.diagnostics import Diagnostic
    from llmbt_ir.scene import Scene

__all__ = ["scene"]

FOUND = ("E020", "E021", "E022", "E036", "E039", *(f"E04{i}" for i in range(1, 10)))
"""What `check` finds; that a file cannot be read, or is no scene, is bad input here as everywhere."""


@click.group()
def scene() -> None:
    """Scenes."""


@scene.command(name="list")
@json_flag
def list_(as_json: bool) -> int:
    """The shipped scenes."""
    from llmbt.render import print_json
    from llmbt_ir.scene import load_scene, scene_names

    found = [load_scene(name) for name in scene_names()]
    if as_json:
        rows = [
            {
                "name": s.name,
                "library": s.library,
                "robot": s.robot.value,
                "objects": len(s.objects),
                "places": len(s.places),
                "description": s.description,
            }
            for s in found
        ]
        print_json({"scenes": rows}, 0)
        return 0
    for s in found:
        click.echo(f"{s.name}: {len(s.objects)} things, {len(s.places)} places, library {s.library}, robot {s.robot}")
        click.echo(f"    {s.description}")
    return 0


@scene.command()
@click.argument("name", metavar="SCENE")
@click.option("-o", "--out", type=click.Path(path_type=Path), default=None, metavar="FILE.png", help="Draw it.")
@click.option("--camera", default=None, metavar="ID", help="From one of its cameras; default: the first.")
@click.option("--size", default="960x640", show_default=True, metavar="WxH", help="Of the picture.")
@json_flag
def show(name: str, out: Path | None, camera: str | None, size: str, as_json: bool) -> int:
    """What stands where in SCENE at the start; with -o also a picture, by the software renderer of the physics."""
    from llmbt.render import print_json
    from llmbt_ir.scene import load_scene, to_semantic_map

    found = load_scene(name)
    if out is not None:
        _draw(found, out, camera, size)
    seen = to_semantic_map(found)
    if as_json:
        objects = [{"id": o.id, "name": o.name, "place": o.place, "xyz_m": list(o.pose.xyz_m)} for o in seen.objects]
        places = [{"id": p.id, "type": p.type, "parent": p.parent} for p in seen.places]
        cameras = [c.id for c in found.cameras]
        picture = str(out) if out is not None else None
        print_json({"name": found.name, "objects": objects, "places": places, "cameras": cameras, "file": picture}, 0)
        return 0
    if out is not None:
        click.echo(f"{out}: {found.name}")
        return 0
    click.echo(f"{found.name}: {found.description}")
    for p in seen.places:
        on = ", ".join(f"{o.id} ({o.colour} {o.shape})" for o in seen.objects if o.place == p.id)
        click.echo(f"  {p.id} ({p.type}{', in ' + p.parent if p.parent else ''}){': ' + on if on else ''}")
    nowhere = ", ".join(o.id for o in seen.objects if o.place is None)
    if nowhere:
        click.echo(f"  on no place: {nowhere}")
    return 0


def _draw(found: Scene, out: Path, camera: str | None, size: str) -> None:
    from llmbt_runtime.bullet.camera import render_png
    from llmbt_runtime.bullet.world import BulletWorld

    width, _, height = size.partition("x")
    if not (width.isdigit() and height.isdigit() and 16 <= int(width) <= 4096 and 16 <= int(height) <= 4096):
        raise click.UsageError(f"--size: `{size}` is not WIDTHxHEIGHT, from 16x16 to 4096x4096")
    by_id = {c.id: c for c in found.cameras}
    if camera is not None and camera not in by_id:
        raise click.UsageError(f"--camera: {found.name} has {', '.join(by_id) or 'none'}, no `{camera}`")
    world = BulletWorld(found)
    try:
        render_png(world, out, int(width), int(height), by_id.get(camera) if camera is not None else None)
    finally:
        world.close()


@scene.command()
@click.argument("name", metavar="SCENE")
@click.option("--strict", is_flag=True, help="Warnings count as faults.")
@json_flag
def check(name: str, strict: bool, as_json: bool) -> int:
    """Check SCENE, a shipped one's name or a file: ids used twice, bodies that overlap, places out of reach.

    Exit code 6 where there are errors; with --strict where there is anything; 1 where the file is no scene.
    """
    from llmbt.render import print_json, render

    found = tuple(_findings(name))
    faults = [d for d in found if strict or d.severity is Severity.ERROR]
    code = ExitCode.DIFFERENCES if faults else ExitCode.OK
    if as_json:
        print_json({"scene": name}, code, found)
        return int(code)
    for diagnostic in found:
        click.echo(render(diagnostic))
    click.echo(f"{name}: {len(found)} finding{'' if len(found) == 1 else 's'}")
    return int(code)


def _findings(name: str) -> Iterator[Diagnostic]:
    """What the file says that cannot be; where it is in order, what the robot cannot reach."""
    from llmbt_atl.library import load_library
    from llmbt_atl.state import domain_of
    from llmbt_ir.diagnostics import LlmbtError
    from llmbt_ir.scene import load_scene, to_semantic_map

    try:
        found = load_scene(name)
        library = load_library(found.library, beside=Path(found.source).parent)
        domain = domain_of(library, to_semantic_map(found))
    except LlmbtError as fault:
        if any(d.code not in FOUND for d in fault.diagnostics):
            raise
        yield from fault.diagnostics
        return
    from llmbt_ir.scene_hints import hints
    from llmbt_runtime.bullet.checking import findings
    from llmbt_runtime.disturbance import drives

    yield from hints(found, library.types, drives=drives(domain))
    yield from findings(found)


scene.add_command(capture)
scene.add_command(map_)
