"""`llmbt scene capture` and `llmbt scene map`: from cameras to point clouds, and from those to a semantic map."""

from __future__ import annotations

from pathlib import Path

import click

from llmbt.options import force, json_flag, out_folder, quiet

__all__ = ["capture", "map_"]

seed_option = click.option("--seed", type=int, default=0, show_default=True, envvar="LLMBT_SEED", help="Of the noise.")
noise_option = click.option(
    "--noise-mm",
    type=click.FloatRange(0, 50),
    default=1.5,
    show_default=True,
    help="Standard deviation of the depths' error.",
)


@click.command()
@click.argument("scene")
@out_folder
@noise_option
@seed_option
@click.option("--format", "suffix", type=click.Choice(["ply", "pcd"]), default="ply", show_default=True)
@force
@json_flag
def capture(scene: str, folder: Path, noise_mm: float, seed: int, suffix: str, force: bool, as_json: bool) -> int:
    """Write a point cloud from each camera of SCENE into DIR, in metres and in the world frame.

    `capture.json` beside them says where the robot's links were, so that its own points can be told from the things.
    """
    from llmbt.folders import fresh_folder
    from llmbt.render import print_json
    from llmbt.vision import capture_start
    from llmbt_compiler.recognition.files import CAPTURE, write_capture
    from llmbt_ir.scene import load_scene

    loaded = load_scene(scene)
    fresh_folder(folder, force=force)
    clouds, whole = capture_start(loaded, noise_m=noise_mm / 1000, seed=seed)
    files = write_capture(folder, clouds, whole, f".{suffix}")
    if as_json:
        rows = [{"file": str(f), "points": len(c)} for f, c in zip(files, clouds.values(), strict=True)]
        print_json({"scene": loaded.name, "clouds": rows, "capture": str(folder / CAPTURE)}, 0)
        return 0
    for file, cloud in zip(files, clouds.values(), strict=True):
        click.echo(f"{file}: {len(cloud)} points")
    click.echo(f"{folder / CAPTURE}: where the robot was")
    return 0


@click.command(name="map")
@click.argument("scene")
@click.argument("clouds", nargs=-1, type=click.Path(path_type=Path), metavar="[CLOUD]...")
@click.option("-o", "--out", type=click.Path(path_type=Path), default=None, metavar="FILE.xml", help="Default: stdout.")
@click.option(
    "--previous",
    type=click.Path(path_type=Path),
    default=None,
    metavar="MAP.xml",
    help="The map before this one: things keep their ids.",
)
@noise_option
@seed_option
@quiet
@json_flag
def map_(
    scene: str,
    clouds: tuple[Path, ...],
    out: Path | None,
    previous: Path | None,
    noise_mm: float,
    seed: int,
    quiet: bool,
    as_json: bool,
) -> int:
    """Recognise the things of SCENE in point clouds, and write the semantic map.

    CLOUD is a folder that `llmbt scene capture` has written, or a .ply or .pcd file of your own, in metres and in the
    scene's world frame; several count as one. Without any, the scene's cameras are looked through (--noise-mm, --seed).
    """
    from llmbt.progress import Progress
    from llmbt.render import print_json, report
    from llmbt.vision import capture_start
    from llmbt_compiler.recognition.doubts import doubts
    from llmbt_compiler.recognition.files import read_capture
    from llmbt_compiler.recognition.recognise import recognise
    from llmbt_ir.diagnostics import ExitCode
    from llmbt_ir.scene import load_scene
    from llmbt_ir.semantic_map import read_map, write_map
    from llmbt_ir.versions import write_atomic

    loaded = load_scene(scene)
    before = read_map(previous) if previous is not None else None
    seen = read_capture(clouds) if clouds else capture_start(loaded, noise_m=noise_mm / 1000, seed=seed)[1]
    doubtful = doubts(seen, loaded) if clouds else ()
    if doubtful and not as_json:
        report(doubtful, ExitCode.OK, as_json=False)
    progress = Progress(quiet=quiet or as_json)
    found = recognise(seen, loaded, before, observe=lambda stage, s: progress.stage(stage, f"{s * 1e3:.0f} ms"))
    xml = write_map(found)
    if out is not None:
        write_atomic(out, xml)
    if as_json:
        things = [
            {
                "id": o.id,
                "name": o.name,
                "colour": o.colour,
                "shape": o.shape,
                "size_m": list(o.size_m),
                "xyz_m": [round(v, 4) for v in o.pose.xyz_m],
                "quat_xyzw": [round(v, 4) for v in o.pose.quat_xyzw],
                "place": o.place,
                "held": o.held,
            }
            for o in found.objects
        ]
        print_json({"scene": loaded.name, "objects": things, "file": str(out) if out else None}, 0, doubtful)
    elif out is None:
        click.echo(xml.decode(), nl=False)
    else:
        click.echo(f"{out}: {len(found.objects)} objects")
    return 0
