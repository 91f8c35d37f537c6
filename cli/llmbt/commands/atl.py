"""`llmbt atl`: action template libraries."""

from __future__ import annotations

from pathlib import Path

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


@atl.command(name="list")
@json_flag
def list_(as_json: bool) -> int:
    """The shipped libraries."""
    from llmbt.render import print_json
    from llmbt_atl.library import library_names

    if as_json:
        print_json({"libraries": list(library_names())}, 0)
    else:
        click.echo("\n".join(library_names()))
    return 0


@atl.command()
@click.argument("library")
@json_flag
def show(library: str, as_json: bool) -> int:
    """What LIBRARY can do: each template with its conditions, and the verbs that mean it."""
    from llmbt.render import print_json
    from llmbt_atl.library import load_library

    found = load_library(library)
    if as_json:
        templates = [
            {
                "name": t.name,
                "params": [{"name": p.name, "type": p.type, "role": p.role.value} for p in t.params],
                **{part: [str(p) for p in getattr(t, part)] for part in ("start", "hold", "post", "deletes")},
                "verbs": list(t.verbs),
            }
            for t in found.templates.values()
        ]
        print_json({"library": found.name, "templates": templates}, 0)
        return 0
    for t in found.templates.values():
        params = ", ".join(f"{p.name}: {p.type}" + (f" ({p.role.value})" if p.role else "") for p in t.params)
        click.echo(f"{t.name}({params})")
        for part, patterns in (("starts when", t.start), ("holds", t.hold), ("then", t.post), ("ends", t.deletes)):
            if patterns:
                click.echo(f"    {part:<12}{', '.join(map(str, patterns))}")
        if t.verbs:
            click.echo(f"    {'verbs':<12}{' '.join(t.verbs)}")
    return 0


@atl.command(name="import-pddl")
@click.argument("domain", type=click.Path(path_type=Path), metavar="DOMAIN.pddl")
@click.option("-o", "--out", type=click.Path(path_type=Path), default=None, metavar="FILE.xml", help="Default: stdout.")
@json_flag
def import_pddl(domain: Path, out: Path | None, as_json: bool) -> int:
    """Make a library of a PDDL domain: STRIPS with typing, negative and disjunctive preconditions, equality."""
    from llmbt.render import print_json
    from llmbt_atl.pddl import import_domain, write_library
    from llmbt_ir.versions import write_atomic
    from llmbt_ir.xml import read_bytes

    library = import_domain(read_bytes(domain, "PDDL file").decode("utf-8", "replace"), str(domain))
    xml = write_library(library)
    if out is not None:
        write_atomic(out, xml)
    if as_json:
        found = {"library": library.name, "templates": list(library.templates), "file": str(out) if out else None}
        print_json({**found, "variables": [v.name for v in library.variables]}, 0)
    elif out is None:
        click.echo(xml.decode(), nl=False)
    else:
        click.echo(f"{out}: {len(library.templates)} templates, {len(library.variables)} state variables")
    return 0
