"""`llmbt cassette`: recordings of the language model."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from llmbt.options import force, json_flag, scene_option

__all__ = ["cassette"]

PATHS = click.argument("paths", nargs=-1, type=click.Path(path_type=Path), metavar="[FILE|DIR]...")


@click.group()
def cassette() -> None:
    """Recordings of the language model."""


@cassette.command(name="list")
@PATHS
@json_flag
def list_(paths: tuple[Path, ...], as_json: bool) -> int:
    """What there is: in the files and folders named, else in $LLMBT_CASSETTES and what is shipped."""
    from llmbt.recordings import described, found
    from llmbt.render import print_json

    rows = [described(path) for path in found(paths)]
    if as_json:
        print_json({"cassettes": rows}, 0)
        return 0
    for row in rows:
        if row["fault"]:
            click.echo(f"{row['cassette']}: {row['fault']}")
            continue
        tokens = f", {row['tokens_in']}+{row['tokens_out']} tokens" if row["tokens_in"] else ""
        cost = f", ${row['cost_usd']}" if row["cost_usd"] else ""
        turns = f"{row['turns']} turn{'s' * (row['turns'] != 1)}"
        source = f"{row['says']}, {row['date']}, template {row['template_version']}"
        click.echo(f"{row['cassette']}: {source}, {turns}{tokens}{cost}")
        click.echo(f"    {row['scene']}: {row['request']}")
    return 0


@cassette.command()
@PATHS
@json_flag
def verify(paths: tuple[Path, ...], as_json: bool) -> int:
    """Hold recordings against today's prompts and parser. Exit code 6 where one is stale or means something else."""
    from llmbt.recordings import found, verified
    from llmbt.render import print_json
    from llmbt_ir.diagnostics import ExitCode

    rows = []
    for path in found(paths):
        row = verified(path)
        rows.append(row)
        if not as_json and not row["good"]:
            click.echo(f"{row['cassette']}: {_finding(row)}")
    bad = sum(not row["good"] for row in rows)
    code = ExitCode.DIFFERENCES if bad else ExitCode.OK
    if as_json:
        print_json({"cassettes": rows}, code)
    else:
        names = ("identical", "harmless", "meaning-changing", "unknown")
        kinds = {k: sum(row["drift"] == k for row in rows) for k in names}
        told = ", ".join(f"{n} {k}" for k, n in kinds.items() if n)
        stale = sum(bool(row["stale"]) for row in rows)
        click.echo(f"{len(rows)} recordings: {told or 'none'}; {stale} stale")
    return int(code)


def _finding(row: dict[str, Any]) -> str:
    if row["fault"]:
        return f"cannot be verified: {row['fault']}"
    said = [f"stale from turn {row['turn']} (template {row['template_version']})"] if row["stale"] else []
    said.append(str(row["drift"]))
    if row["drift"] == "meaning-changing":
        said.append(f"was {row['before']}, now {row['now']}")
    return ", ".join(said)


@cassette.command()
@PATHS
@click.option("-o", "--out", "folder", required=True, type=click.Path(path_type=Path), metavar="DIR")
@click.option("--base-url", required=True, envvar="LLMBT_BASE_URL", help="An OpenAI-compatible endpoint.")
@click.option("--model", required=True, help="The model to record from.")
@click.option("--timeout", "timeout_s", type=click.FloatRange(0.1), default=60.0, show_default=True, help="s.")
@click.option("--retries", type=click.IntRange(0, 20), default=4, show_default=True, help="With back-off.")
@click.option("--price", default="", metavar="IN/OUT", help="Dollars for a million tokens, for the record.")
@json_flag
def rerecord(
    paths: tuple[Path, ...],
    folder: Path,
    base_url: str,
    model: str,
    timeout_s: float,
    retries: int,
    price: str,
    as_json: bool,
) -> int:
    """Ask a model for all of them anew, into DIR, and tell how its replies differ by the goals that result.

    Exit code 6 where one of them means something else.
    """
    from llmbt.recordings import found, recorded_anew
    from llmbt.render import print_json
    from llmbt_compiler.reasoning.chat import Settings
    from llmbt_ir.diagnostics import ExitCode

    settings = Settings(model, base_url, timeout_s=timeout_s, retries=retries, price=price)
    rows = []
    for path in found(paths):
        row = recorded_anew(path, folder, settings)
        rows.append(row)
        if not as_json:
            click.echo(f"{row['cassette']}: {row['fault'] or row['drift']}")
            if row["drift"] == "meaning-changing":
                click.echo(f"    was {row['before']}\n    now {row['now']}")
            sys.stdout.flush()
    bad = any(row["fault"] or row["drift"] == "meaning-changing" for row in rows)
    code = ExitCode.DIFFERENCES if bad else ExitCode.OK
    if as_json:
        print_json({"cassettes": rows}, code)
    return int(code)


@cassette.command()
@click.argument("request_text", metavar="REQUEST")
@scene_option
@click.option(
    "--reply",
    "replies",
    multiple=True,
    required=True,
    type=click.Path(path_type=Path),
    help="The written reply; may be repeated.",
)
@click.option("--answer", "answers", multiple=True, help="The user's answer between two replies.")
@click.option("-o", "--out", "path", required=True, type=click.Path(path_type=Path), metavar="CASSETTE")
@click.option("--map", "map_file", type=click.Path(path_type=Path), default=None, help="In place of the scene's map.")
@click.option("--reply-format", type=click.Choice(["steps", "json"]), default="steps", show_default=True)
@force
@json_flag
def author(
    request_text: str,
    scene: str,
    replies: tuple[Path, ...],
    answers: tuple[str, ...],
    path: Path,
    map_file: Path | None,
    reply_format: str,
    force: bool,
    as_json: bool,
) -> int:
    """Make a recording of REQUEST from a hand-written reply; it says `authored` wherever it is used.

    Further replies come after the answers to the questions of those before, and those beyond the answers are what the
    model says once it has been told what was wrong.
    """
    from llmbt.compilation import scene_map
    from llmbt.render import print_json
    from llmbt_atl.library import load_library
    from llmbt_compiler.reasoning.author import author as make
    from llmbt_compiler.reasoning.author import read_reply
    from llmbt_ir.scene import load_scene

    found = load_scene(scene)
    made = make(
        sys.stdin.read() if request_text == "-" else request_text,
        scene_map(scene, map_file),
        load_library(found.library, beside=Path(found.source).parent),
        [read_reply(r) for r in replies],
        path,
        answers=answers,
        scene=scene,
        overwrite=force,
        reply_format=reply_format,
    )
    outcome = made.cassette.provenance.outcome
    if as_json:
        document = {"cassette": str(made.path), "provenance": "authored", "changed": made.changed, "outcome": outcome}
        print_json(document, 0)
    else:
        click.echo(f"{made.path}: authored{'' if made.changed else ', unchanged'}; {outcome}")
    return 0
