"""`llmbt cassette`: recordings of the language model."""

from __future__ import annotations

from pathlib import Path

import click

from llmbt.options import force, json_flag, scene_option

__all__ = ["cassette"]


@click.group()
def cassette() -> None:
    """Recordings of the language model."""


@cassette.command()
@click.argument("request_text", metavar="REQUEST")
@scene_option
@click.option(
    "--reply",
    "replies",
    multiple=True,
    required=True,
    type=click.Path(path_type=Path),
    help="The written reply.",
)
@click.option("--answer", "answers", multiple=True, help="The user's answer between two replies.")
@click.option("-o", "--out", "path", required=True, type=click.Path(path_type=Path), metavar="CASSETTE")
@click.option("--map", "map_file", type=click.Path(path_type=Path), default=None, help="In place of the scene's map.")
@force
@json_flag
def author(
    request_text: str,
    scene: str,
    replies: tuple[Path, ...],
    answers: tuple[str, ...],
    path: Path,
    map_file: Path | None,
    force: bool,
    as_json: bool,
) -> int:
    """Make a recording of REQUEST from a hand-written reply; it says `authored` wherever it is used."""
    from llmbt.commands.compile import read_request
    from llmbt.compilation import scene_map
    from llmbt.render import print_json
    from llmbt_atl.library import load_library
    from llmbt_compiler.reasoning.author import author as make
    from llmbt_compiler.reasoning.author import read_reply
    from llmbt_ir.scene import load_scene

    found = load_scene(scene)
    made = make(
        read_request(request_text),
        scene_map(scene, map_file),
        load_library(found.library, beside=Path(found.source).parent),
        [read_reply(r) for r in replies],
        path,
        answers=answers,
        scene=found.name,
        overwrite=force,
    )
    if as_json:
        print_json({"cassette": str(made.path), "provenance": "authored", "changed": made.changed}, 0)
    else:
        click.echo(f"{made.path}: authored{'' if made.changed else ', unchanged'}")
    return 0
