"""`llmbt run`: compile and execute."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from llmbt.commands.compile import compile_options, prepared, talk_of
from llmbt.commands.execute import summary
from llmbt.options import execution_options, force, json_flag, out_folder, quiet, scene_option

__all__ = ["run"]


@click.command()
@click.argument("request_text", metavar="REQUEST", required=False)
@scene_option
@out_folder
@compile_options
@execution_options
@force
@quiet
@json_flag
def run(
    request_text: str | None,
    scene: str,
    folder: Path,
    world: str,
    seed: int,
    disturb: str,
    budget: int,
    picture: bool,
    state: Path | None,
    force: bool,
    quiet: bool,
    as_json: bool,
    **how: Any,
) -> int:
    """Compile REQUEST (- for standard input), execute its tree, and leave every version of it in DIR."""
    from llmbt.compilation import compile_into, continued
    from llmbt.execution import Order, execute_tree, is_schedule
    from llmbt.folders import fresh_folder
    from llmbt.progress import Progress
    from llmbt_ir.scene import load_scene
    from llmbt_runtime.chance import chance
    from llmbt_runtime.disturbance import draw
    from llmbt_runtime.schedule import read_schedule

    request = prepared(request_text, scene, how)
    order = Order(load_scene(scene), world, seed, disturb, budget, picture, state)
    if is_schedule(disturb):
        read_schedule(Path(disturb))
    else:
        draw(disturb, chance(seed, "disturb"))
    further = continued(request, folder)
    if further is None:
        fresh_folder(folder, force=force)
    progress = Progress(quiet=quiet or as_json)
    done = compile_into(further or request, folder, progress, **talk_of(how, quiet=as_json))
    tree = folder / "tree.v000.xml"
    source = done.compiled.reply.provenance if done.compiled.reply else None
    extra = {
        "request": request.text,
        "reply": source.provenance if source else "",
        "reply_source": source.words() if source else "",
    }
    document = execute_tree(tree.read_bytes(), str(tree), folder, order, progress, extra=extra)
    code = summary(document, folder, as_json=as_json)
    if not as_json and source is not None:
        click.echo(f"the model's reply: {source.words()}")
    return code
