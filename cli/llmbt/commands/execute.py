"""`llmbt execute`: a tree against a world."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from llmbt.options import execution_options, force, json_flag, out_folder, quiet, scene_option
from llmbt_ir.diagnostics import ExitCode

__all__ = ["execute", "summary"]


@click.command()
@click.argument("tree", type=click.Path(path_type=Path))
@scene_option
@out_folder
@execution_options
@click.option("--no-update", is_flag=True, help="Tick TREE as it stands: any node of docs/engine.md, nothing grows.")
@force
@quiet
@json_flag
def execute(
    tree: Path,
    scene: str,
    folder: Path,
    world: str,
    seed: int,
    disturb: str,
    budget: int,
    picture: bool,
    state: Path | None,
    no_update: bool,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Tick TREE against a world, and let it grow wherever a condition fails.

    Into the folder of its own compile, it goes on there; anywhere else the tree is copied as v000.
    """
    from llmbt.execution import Order, execute_tree
    from llmbt.folders import fresh_folder
    from llmbt.progress import Progress
    from llmbt_ir.scene import load_scene
    from llmbt_ir.xml import read_bytes

    data = read_bytes(tree, "tree")
    order = Order(load_scene(scene), world, seed, disturb, budget, picture, state, not no_update)
    if tree.resolve().parent != folder.resolve() or (folder / "result.json").exists():
        fresh_folder(folder, force=force)
    document = execute_tree(data, str(tree), folder, order, Progress(quiet=quiet or as_json))
    return summary(document, folder, as_json=as_json)


def summary(document: dict[str, Any], folder: Path, *, as_json: bool) -> int:
    """Print how it ended; the exit code."""
    from llmbt.recorded import exit_code_of
    from llmbt.render import print_json
    from llmbt_runtime.outcome import Outcome

    outcome = Outcome(document["outcome"])
    code = exit_code_of(outcome)
    if as_json:
        print_json(document, code)
        return int(code)
    print(f"{outcome.value}: {document['reason']}" if document.get("reason") else outcome.value)
    for goal in document["goals"]:
        mark = "holds" if goal["holds"] else "does NOT hold"
        name = ("not " if goal.get("negated") else "") + f"{goal['name']}({', '.join(goal['args'])})"
        print(f"  {name} {mark}")
    updates = f"{document['updates']} update{'' if document['updates'] == 1 else 's'}"
    print(
        f"{len(document['actions'])} actions, {updates}, {document['sim_time_s']:.1f} s simulated, "
        f"{document['wall_time_s']:.1f} s wall; versions and why in {folder}"
    )
    return int(code) if code is not ExitCode.OK else 0
