"""`llmbt report`: a run, or an experiment, as a page to read."""

from __future__ import annotations

from pathlib import Path

import click

from llmbt.options import json_flag

__all__ = ["report"]

FOLDER = click.Path(path_type=Path)


@click.command()
@click.argument("folders", type=FOLDER, nargs=-1, required=True, metavar="DIR...")
@click.option("-o", "--out", type=FOLDER, default=None, metavar="FILE", help="The page, in place of DIR/report.html.")
@click.option(
    "--results",
    type=FOLDER,
    default=None,
    metavar="FILE.md",
    help="The tables of several experiments as one document, with date, versions, seeds and machine.",
)
@json_flag
def report(folders: tuple[Path, ...], out: Path | None, results: Path | None, as_json: bool) -> int:
    """One HTML page of the run in DIR, which needs no other file and no network; of an experiment its tables, figures
    and pages anew, from what its ledger holds so far."""
    from llmbt.experiment.ledger import PLAN
    from llmbt.experiment.results import INDEX, write_results
    from llmbt.experiment.run_page import run_page
    from llmbt.render import print_json
    from llmbt_ir.versions import write_atomic

    if results is not None:
        from llmbt.experiment.results_document import results_document

        write_atomic(results, results_document(folders).encode())
        made = [results]
    else:
        if out is not None and len(folders) > 1:
            raise click.UsageError("--out is for one DIR")
        made = []
        for folder in folders:
            if (folder / PLAN).exists():
                write_results(folder)
                made.append(folder / INDEX)
                continue
            page = out or folder / "report.html"
            write_atomic(page, run_page(folder))
            made.append(page)
    if as_json:
        print_json({"written": [str(p) for p in made]}, 0)
    else:
        click.echo("\n".join(map(str, made)))
    return 0
