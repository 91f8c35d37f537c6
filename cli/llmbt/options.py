"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

__all__ = ["execution_options", "force", "json_flag", "out_folder", "quiet", "scene_option"]

json_flag = click.option("--json", "as_json", is_flag=True, help="One JSON document on stdout.")
quiet = click.option("-q", "--quiet", is_flag=True, envvar="LLMBT_QUIET", help="No progress on stderr.")
force = click.option("--force", is_flag=True, help="Replace what an earlier run left in DIR.")
scene_option = click.option("--scene", required=True, envvar="LLMBT_SCENE", help="A shipped scene's name, or a file.")
out_folder = click.option(
    "-o",
    "--out",
    "folder",
    required=True,
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="An empty folder.",
)


def execution_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """--world, --state, --seed, --disturb, --budget, --picture."""
    for option in (
        click.option("--picture", is_flag=True, help="Pictures of the scene: at the start, each update, the end."),
        click.option("--budget", type=click.IntRange(0), default=200_000, show_default=True, help="State expansions."),
        click.option(
            "--disturb",
            default="none",
            show_default=True,
            help="Names joined by commas, none, random[:N], or an .xml file.",
        ),
        click.option("--seed", type=int, default=0, show_default=True, envvar="LLMBT_SEED", help="Of all chance."),
        click.option(
            "--state",
            type=click.Path(path_type=Path),
            default=None,
            help="With --world symbolic: start from the state in a version's record (tree.vNNN.json).",
        ),
        click.option("--world", type=click.Choice(["bullet", "symbolic"]), default="bullet", show_default=True),
    ):
        command = option(command)
    return command
