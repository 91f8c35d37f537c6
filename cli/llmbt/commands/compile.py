"""`llmbt compile`: a request and a scene to an initial tree."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from llmbt.options import force, json_flag, quiet, scene_option

__all__ = ["compile_", "compile_options", "read_request"]

STAGE = click.Choice(["map", "prompt", "reason", "filter", "keywords", "parse", "build"])


def compile_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say where the reply comes from."""
    path = click.Path(path_type=Path)
    for option in (
        click.option("--partial", is_flag=True, help="Leave out steps below the tagger's confidence threshold."),
        click.option(
            "--tagger", default="default", show_default=True, help="default, torch (the reference), or a folder."
        ),
        click.option("--answer", "answers", multiple=True, help="Answer the question asked back; may be repeated."),
        click.option("--replace", is_flag=True, help="With --record: ask anew what the recording has already."),
        click.option("--model", default="", help="The model to record from."),
        click.option("--base-url", default="", envvar="LLMBT_BASE_URL", help="An OpenAI-compatible endpoint."),
        click.option("--record", is_flag=True, help="Ask a model (key from OPENAI_API_KEY) and record it."),
        click.option("--cassette", type=path, default=None, help="A recording, or a folder of them."),
        click.option("--map", "map_file", type=path, default=None, help="A semantic map in place of the scene's own."),
    ):
        command = option(command)
    return command


def read_request(text: str) -> str:
    """The request; `-` is standard input."""
    return sys.stdin.read() if text == "-" else text


@click.command(name="compile")
@click.argument("request_text", metavar="REQUEST")
@scene_option
@click.option("-o", "--out", "folder", type=click.Path(path_type=Path), metavar="DIR", help="An empty folder.")
@compile_options
@click.option("--stop-after", type=STAGE, default=None, help="Stop after a stage and print what it made.")
@click.option("--start-from", type=STAGE, default=None, help="Read what the stage before it left in DIR.")
@force
@quiet
@json_flag
def compile_(
    request_text: str,
    scene: str,
    folder: Path | None,
    map_file: Path | None,
    cassette: Path | None,
    record: bool,
    base_url: str,
    model: str,
    replace: bool,
    answers: tuple[str, ...],
    tagger: str,
    partial: bool,
    stop_after: str | None,
    start_from: str | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Compile REQUEST (- for standard input) into an initial behaviour tree of goal conditions."""
    import tempfile

    from llmbt.compilation import Request, compile_into, document_of
    from llmbt.folders import fresh_folder
    from llmbt.progress import Progress
    from llmbt.render import print_json

    if folder is None and not stop_after:
        raise click.UsageError("Missing option '-o' / '--out'.")
    if folder is None and start_from:
        raise click.UsageError("--start-from needs -o DIR, the folder of the earlier stages.")
    request = Request(
        read_request(request_text),
        scene,
        map_file,
        cassette,
        record,
        replace,
        base_url,
        model,
        answers,
        tagger,
        partial,
        stop_after,
        start_from,
    )
    with tempfile.TemporaryDirectory() as scratch:
        into = folder or Path(scratch)
        if folder is not None and not start_from and not (answers and _asked(folder)):
            fresh_folder(folder, force=force)
        compiled = compile_into(request, into, Progress(quiet=quiet or as_json))
        if as_json:
            print_json(dict(document_of(compiled, folder)), 0)
        elif stop_after and stop_after != "build":
            click.echo(_artifact(into, stop_after), nl=False)
        else:
            click.echo(f"{folder}/tree.v000.xml")
    return 0


def _asked(folder: Path) -> bool:
    """Whether a compilation in the folder ended with a question and no tree."""
    return (folder / "steps.json").is_file() and not any(folder.glob("tree.v*.xml"))


def _artifact(folder: Path, stage: str) -> str:
    from llmbt_compiler.pipeline import STAGES

    name = next(s.artifact for s in STAGES if s.name == stage)
    return (folder / name).read_text(encoding="utf-8")
