"""`llmbt atl`: action template libraries."""

from __future__ import annotations

import click

from llmbt.options import json_flag
from llmbt_ir.diagnostics import ExitCode, Severity

__all__ = ["atl"]


@click.group()
def atl() -> None:
    """Action template libraries."""


@atl.command()
@click.argument("library")
@click.option("--strict", is_flag=True, help="Warnings count as faults.")
@json_flag
def check(library: str, strict: bool, as_json: bool) -> int:
    """Check LIBRARY, a shipped one's name or a file: unknown names, unbound parameters, dead effects and templates."""
    from llmbt.render import print_json, render
    from llmbt_atl.library import check_library, load_library

    found = tuple(check_library(load_library(library)))
    faults = [d for d in found if strict or d.severity is Severity.ERROR]
    code = ExitCode.DIFFERENCES if faults else ExitCode.OK
    if as_json:
        print_json({"library": library}, code, found)
        return int(code)
    for diagnostic in found:
        click.echo(render(diagnostic))
    click.echo(f"{library}: {len(found)} finding{'' if len(found) == 1 else 's'}")
    return int(code)
