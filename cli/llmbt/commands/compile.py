"""`llmbt compile`: a request and a scene to an initial tree."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from llmbt.options import force, json_flag, quiet, scene_option

if TYPE_CHECKING:
    from llmbt.compilation import Request
    from llmbt_compiler.asking import Asked

__all__ = ["compile_", "compile_options", "prepared", "talk_of"]

STAGE = click.Choice(["map", "prompt", "reason", "filter", "keywords", "parse", "build"])


def compile_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say where the reply comes from, and what happens where it is not clear."""
    path = click.Path(path_type=Path)
    for option in (
        click.option("--yes", "-y", is_flag=True, help="With --confirm: confirmed."),
        click.option("--confirm", is_flag=True, help="Say the goals back and ask whether they are what is wanted."),
        click.option("--partial", is_flag=True, help="Leave out steps below the tagger's confidence threshold."),
        click.option("--tagger", default="default", show_default=True, help="default, torch, or a folder."),
        click.option(
            "--corrections",
            type=click.IntRange(0, 10),
            default=2,
            show_default=True,
            help="How often a faulty reply goes back to the model.",
        ),
        click.option("--answer", "answers", multiple=True, help="Answer the question asked back; may be repeated."),
        click.option("--price", default="", metavar="IN/OUT", help="Dollars for a million tokens, for the record."),
        click.option("--retries", type=click.IntRange(0, 20), default=4, show_default=True, help="With back-off."),
        click.option("--timeout", "timeout_s", type=click.FloatRange(0.1), default=60.0, show_default=True, help="s."),
        click.option("--replace", is_flag=True, help="With --record: ask anew what the recording has already."),
        click.option("--model", default="", help="The model to record from."),
        click.option("--base-url", default="", envvar="LLMBT_BASE_URL", help="An OpenAI-compatible endpoint."),
        click.option("--record", is_flag=True, help="Ask a model (key from OPENAI_API_KEY) and record it."),
        click.option("--cassette", type=path, default=None, help="A recording, or a folder of them."),
        click.option(
            "--reply-format",
            type=click.Choice(["steps", "json"]),
            default="steps",
            show_default=True,
            help="What the model is asked for: steps in words, or goals as JSON.",
        ),
        click.option("--goals", type=path, default=None, help="Goals (JSON or PDDL) in place of a model's reply."),
        click.option("--recognise", is_flag=True, help="A semantic map recognised from the scene's cameras."),
        click.option("--map", "map_file", type=path, default=None, help="A semantic map in place of the scene's own."),
    ):
        command = option(command)
    return command


def prepared(text: str | None, scene: str, how: dict[str, Any]) -> Request:
    """The request (`-` is standard input) and what the options say about it."""
    from llmbt.compilation import Request

    if text is None and how["goals"] is None:
        raise click.UsageError("Missing argument 'REQUEST' (or --goals FILE).")
    told = sys.stdin.read() if text == "-" else text or ""
    names = {f.name for f in dataclasses.fields(Request)}
    return Request(told, scene, **{k: v for k, v in how.items() if k in names})


def talk_of(how: dict[str, Any], *, quiet: bool) -> dict[str, Any]:
    """Who is asked, and who confirms."""
    from llmbt.talk import confirmation, consultation

    def consult(asked: Asked) -> str | None:
        return consultation(quiet=quiet)(asked)

    return {"consult": consult, "confirm": confirmation(wanted=how["confirm"], yes=how["yes"], quiet=quiet)}


@click.command(name="compile")
@click.argument("request_text", metavar="REQUEST", required=False)
@scene_option
@click.option("-o", "--out", "folder", type=click.Path(path_type=Path), metavar="DIR", help="An empty folder.")
@compile_options
@click.option("--stop-after", type=STAGE, default=None, help="Stop after a stage and print what it made.")
@click.option("--start-from", type=STAGE, default=None, help="Read what the stage before it left in DIR.")
@force
@quiet
@json_flag
def compile_(
    request_text: str | None,
    scene: str,
    folder: Path | None,
    force: bool,
    quiet: bool,
    as_json: bool,
    **how: Any,
) -> int:
    """Compile REQUEST (- for standard input) into an initial behaviour tree of goal conditions."""
    import tempfile

    from llmbt.compilation import compile_into, continued, document_of
    from llmbt.folders import fresh_folder
    from llmbt.progress import Progress
    from llmbt.render import print_json

    stop_after, start_from = how["stop_after"], how["start_from"]
    if folder is None and not stop_after:
        raise click.UsageError("Missing option '-o' / '--out'.")
    if folder is None and start_from:
        raise click.UsageError("--start-from needs -o DIR, the folder of the earlier stages.")
    request = prepared(request_text, scene, how)
    with tempfile.TemporaryDirectory() as scratch:
        into = folder or Path(scratch)
        further = continued(request, folder) if folder is not None else None
        if folder is not None and not start_from and further is None:
            fresh_folder(folder, force=force)
        request = further or request
        done = compile_into(request, into, Progress(quiet=quiet or as_json), **talk_of(how, quiet=as_json))
        if as_json:
            print_json(dict(document_of(done, folder)), 0)
        elif stop_after and stop_after != "build":
            click.echo(_artifact(into, stop_after), nl=False)
        else:
            click.echo(f"{folder}/tree.v000.xml")
    return 0


def _artifact(folder: Path, stage: str) -> str:
    from llmbt_compiler.pipeline import STAGES

    name = next(s.artifact for s in STAGES if s.name == stage)
    return (folder / name).read_text(encoding="utf-8")
