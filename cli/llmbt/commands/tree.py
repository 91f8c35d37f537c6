"""`llmbt tree`: look at trees."""

from __future__ import annotations

from pathlib import Path

import click

from llmbt.options import json_flag

__all__ = ["tree"]


@click.group()
def tree() -> None:
    """Look at trees."""


@tree.command()
@click.argument("file", type=click.Path(path_type=Path))
@json_flag
def show(file: Path, as_json: bool) -> int:
    """Draw FILE on the terminal: ? a Fallback, -> a Sequence, (condition), [action]."""
    from llmbt.draw import drawing
    from llmbt.render import print_json
    from llmbt_ir.tree_xml import read_tree

    found = read_tree(file)
    if as_json:
        nodes = [
            {"id": n.id, "kind": n.kind.value, "label": n.label(), "children": list(n.children)}
            for n in found.tree.preorder()
        ]
        print_json({"version": found.provenance.version, "root": found.tree.root, "nodes": nodes}, 0)
    else:
        click.echo(drawing(found.tree))
    return 0
