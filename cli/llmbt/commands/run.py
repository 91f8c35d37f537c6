"""`llmbt run`: compile and execute."""

from __future__ import annotations

from pathlib import Path

import click

from llmbt.commands.compile import compile_options, read_request
from llmbt.commands.execute import summary
from llmbt.options import execution_options, force, json_flag, out_folder, quiet, scene_option

__all__ = ["run"]


@click.command()
@click.argument("request_text", metavar="REQUEST")
@scene_option
@out_folder
@compile_options
@execution_options
@force
@quiet
@json_flag
def run(
    request_text: str,
    scene: str,
    folder: Path,
    map_file: Path | None,
    recognise: bool,
    cassette: Path | None,
    record: bool,
    base_url: str,
    model: str,
    replace: bool,
    answers: tuple[str, ...],
    tagger: str,
    partial: bool,
    world: str,
    seed: int,
    disturb: str,
    budget: int,
    picture: bool,
    state: Path | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Compile REQUEST (- for standard input), execute its tree, and leave every version of it in DIR."""
    from llmbt.compilation import Request, compile_into
    from llmbt.execution import Order, execute_tree, is_schedule
    from llmbt.folders import fresh_folder
    from llmbt.progress import Progress
    from llmbt_ir.scene import load_scene
    from llmbt_runtime.chance import chance
    from llmbt_runtime.disturbance import draw
    from llmbt_runtime.schedule import read_schedule

    text = read_request(request_text)
    request = Request(
        text,
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
        recognise=recognise,
    )
    order = Order(load_scene(scene), world, seed, disturb, budget, picture, state)
    if is_schedule(disturb):
        read_schedule(Path(disturb))
    else:
        draw(disturb, chance(seed, "disturb"))
    fresh_folder(folder, force=force)
    progress = Progress(quiet=quiet or as_json)
    compiled = compile_into(request, folder, progress)
    tree = folder / "tree.v000.xml"
    source = compiled.reply.provenance if compiled.reply else None
    extra = {
        "request": text,
        "reply": source.provenance if source else "",
        "reply_source": source.words() if source else "",
    }
    document = execute_tree(tree.read_bytes(), str(tree), folder, order, progress, extra=extra)
    code = summary(document, folder, as_json=as_json)
    if not as_json and source is not None:
        click.echo(f"the model's reply: {source.words()}")
    return code
