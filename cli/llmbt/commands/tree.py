"""`llmbt tree`: look at trees, lint them, compare two by meaning, read why a tree grew, export."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from llmbt.options import json_flag

if TYPE_CHECKING:
    from llmbt.history import Stage
    from llmbt.picture import Picture
    from llmbt_ir.condition import Facts
    from llmbt_ir.diff import Diff, Table
    from llmbt_ir.tree_xml import TreeFile

__all__ = ["tree"]

FILE = click.Path(path_type=Path)
FORMATS = ("svg", "dot", "mermaid", "btlog", "btcpp")
colour_option = click.option(
    "--colour",
    "--color",
    "colour",
    type=click.Choice(["auto", "always", "never"]),
    default="auto",
    show_default=True,
    help="auto: where stdout is a terminal and NO_COLOR is not set.",
)


@click.group()
def tree() -> None:
    """Look at trees: show, check, diff, log, why, export."""


# -- show ----------------------------------------------------------------------------------------------------------


@tree.command()
@click.argument("file", type=FILE)
@click.option("--state", type=FILE, default=None, help="A record (tree.vNNN.json) whose state to tick the tree in.")
@click.option("--plain", is_flag=True, help="No statuses, though a record stands beside FILE.")
@click.option("--ids", is_flag=True, help="Each node's id after it.")
@colour_option
@json_flag
def show(file: Path, state: Path | None, plain: bool, ids: bool, colour: str, as_json: bool) -> int:
    """Draw FILE on the terminal: ? a Fallback, -> a Sequence, (condition), [action].

    FILE is a tree, any BehaviorTree.CPP 4 file, or a run's folder (its newest version). Where a version's record
    stands beside it, the tree is ticked in the state that it holds: ✓ success, ✗ failure, … running.
    """
    from llmbt.draw import picture_drawing, wants_colour
    from llmbt.render import print_json

    path, facts = _with_state(file, state, plain)
    ours, picture = _picture(path, facts)
    if as_json:
        print_json(_shown(ours, picture), 0)
    else:
        click.echo(picture_drawing(picture, colour=wants_colour(colour), ids=ids), color=True)
    return 0


def _shown(ours: TreeFile | None, picture: Picture) -> dict[str, Any]:
    boxes = picture.preorder()
    kinds = {n.id: n.kind.value for n in ours.tree.nodes.values()} if ours else {}
    nodes = [
        {
            "id": b.id,
            "kind": kinds.get(b.id, b.shape.value),
            "label": b.text,
            "children": list(b.children),
            **({"status": b.status} if b.status else {}),
        }
        for b in boxes
    ]
    return {
        "version": ours.provenance.version if ours else "",
        "root": picture.tops[0] if picture.tops else "",
        "nodes": nodes,
    }


def _with_state(file: Path, state: Path | None, plain: bool) -> tuple[Path, Facts]:
    """The tree file and the state to tick it in: of `--state`, or of the record beside it; empty where unknown."""
    import json

    from llmbt.history import read_run, state_of
    from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
    from llmbt_ir.xml import read_bytes

    if file.is_dir():
        file = read_run(file).stages[-1].version.path
    beside = file.with_suffix(".json")
    if plain or (state is None and not beside.is_file()):
        return file, frozenset()
    try:
        found = state_of(json.loads(read_bytes(state or beside, "record")))
    except (ValueError, AttributeError):
        found = frozenset()
    if state is not None and not found:
        hint = "give the tree.vNNN.json of a version that was made during a run"
        raise LlmbtError(Diagnostic("E063", "no state is recorded here", Span(str(state)), help=hint))
    return file, found


def _picture(path: Path, facts: Facts) -> tuple[TreeFile | None, Picture]:
    """A tree of ours with statuses, or any other BehaviorTree.CPP file without."""
    from llmbt.picture import picture_of_document, picture_of_tree
    from llmbt_ir.btcpp.document import parse_document
    from llmbt_ir.diagnostics import LlmbtError
    from llmbt_ir.tree_xml import parse_tree
    from llmbt_ir.xml import read_bytes
    from llmbt_runtime.tick import tick

    data = read_bytes(path, "tree")
    try:
        ours = parse_tree(data, str(path))
    except LlmbtError as fault:
        document = parse_document(data, str(path))
        if document[document.root].tag != "root" or not document.trees:
            raise fault from None
        return None, picture_of_document(document)
    statuses = {id_: status.value for id_, status in tick(ours.tree, facts).trace} if facts else {}
    return ours, picture_of_tree(ours.tree, statuses)


# -- check ---------------------------------------------------------------------------------------------------------


@tree.command()
@click.argument("files", type=FILE, nargs=-1, required=True)
@click.option("--strict", is_flag=True, help="Warnings count too.")
@click.option("--sarif", "as_sarif", is_flag=True, help="SARIF 2.1.0 on stdout.")
@click.option("--library", default=None, help="What the actions bring about: a shipped library's name, or a file.")
@colour_option
@json_flag
def check(
    files: tuple[Path, ...], strict: bool, as_sarif: bool, library: str | None, colour: str, as_json: bool
) -> int:
    """Lint BehaviorTree.CPP 4 FILES: T1xx what version 4.10 refuses, T2xx what does not do what it seems to say.

    Exit code 6 where there are errors; with --strict where there is anything; 1 where a file cannot be read, which is
    told among the findings of the others.
    """
    import json

    from llmbt import __version__
    from llmbt.draw import wants_colour
    from llmbt.exports.sarif import sarif
    from llmbt.render import print_json, render
    from llmbt_ir.btcpp.check import RULES, check_document
    from llmbt_ir.btcpp.document import read_document
    from llmbt_ir.btcpp.includes import with_includes
    from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Severity

    effects = _effects(library) if library else None
    found: list[Diagnostic] = []
    unreadable = False
    for file in files:
        try:
            document, faults = with_includes(read_document(file), file)
        except LlmbtError as fault:
            found += fault.diagnostics
            unreadable = True
        else:
            found += [*faults, *check_document(document, effects=effects)]
    errors = sum(d.severity is Severity.ERROR for d in found)
    code = ExitCode.DIFFERENCES if errors or (strict and found) else ExitCode.OK
    code = ExitCode.BAD_INPUT if unreadable else code
    if as_sarif:
        click.echo(json.dumps(sarif(found, RULES, __version__), indent=1, ensure_ascii=False))
    elif as_json:
        print_json({"errors": errors, "warnings": len(found) - errors}, code, found)
    else:
        painted = wants_colour(colour)
        for diagnostic in found:
            click.echo(render(diagnostic, colour=painted) + "\n", color=True)
        click.echo(
            f"{_plural(errors, 'error')}, {_plural(len(found) - errors, 'warning')} in {_plural(len(files), 'file')}"
        )
    return int(code)


def _plural(n: int, what: str) -> str:
    return f"{n} {what}{'' if n == 1 else 's'}"


def _effects(name: str) -> Mapping[str, Any]:
    """What each action of a library adds and deletes, by ports."""
    from llmbt_atl.library import load_library
    from llmbt_ir.btcpp.check import Effect

    library = load_library(name)
    ports = {c.name: tuple(p.name for p in c.params) for c in library.conditions.values()}
    return {
        t.name: tuple(Effect(p.name, tuple(zip(ports[p.name], p.args, strict=True)), p.negated) for p in t.post)
        for t in library.templates.values()
    }


# -- diff ----------------------------------------------------------------------------------------------------------


@tree.command()
@click.argument("first", type=FILE)
@click.argument("second", type=FILE)
@colour_option
@json_flag
def diff(first: Path, second: Path, colour: str, as_json: bool) -> int:
    """Compare two trees by meaning: + added, - removed, > moved, ~ changed. Exit code 6 where they differ.

    Layout, attribute order, comments and where a deep tree is split are no difference. /dev/null is the empty tree.
    """
    from llmbt.draw import diff_drawing, wants_colour
    from llmbt.render import print_json
    from llmbt_ir.diagnostics import ExitCode
    from llmbt_ir.diff import diff_tables

    a, b, label = _tables(first, second)
    edit = diff_tables(a, b)
    code = ExitCode.DIFFERENCES if edit else ExitCode.OK
    if as_json:
        print_json({"same": not edit, **edit_document(edit, label)}, code)
    elif edit:
        click.echo(diff_drawing(a, b, edit, label, colour=wants_colour(colour)), color=True)
        click.echo(_summary(edit))
    return int(code)


def _summary(edit: Diff[Any]) -> str:
    counts = (("added", edit.added), ("removed", edit.removed), ("moved", edit.moved), ("changed", edit.changed))
    return ", ".join(f"{len(rows)} {word}" for word, rows in counts if rows)


def edit_document(edit: Diff[Any], label: Callable[[Any], str]) -> dict[str, Any]:
    """A diff as data."""

    def spot(at: Any) -> dict[str, Any]:
        return {"parent": at.parent, "after": at.after}

    return {
        "added": [{"id": e.id, "node": label(e.content), "at": spot(e.at)} for e in edit.added],
        "removed": [{"id": e.id, "node": label(e.content), "at": spot(e.at)} for e in edit.removed],
        "moved": [{"id": e.id, "node": label(e.content), "from": spot(e.before), "to": spot(e.at)} for e in edit.moved],
        "changed": [{"id": e.id, "from": label(e.before), "to": label(e.content)} for e in edit.changed],
    }


EMPTY = b'<root BTCPP_format="4"/>'


def _tables(first: Path, second: Path) -> tuple[Table[Any], Table[Any], Callable[[Any], str]]:
    """Both files as tables, and how a node is shown: as our trees where both are and carry ids, otherwise as files of
    BehaviorTree.CPP whose nodes are matched."""
    from llmbt.picture import box_of
    from llmbt_ir.btcpp.document import parse_document
    from llmbt_ir.btcpp.match import has_ids, matched_tables
    from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
    from llmbt_ir.diff import table_of
    from llmbt_ir.tree_xml import parse_tree
    from llmbt_ir.xml import read_bytes

    data = [b"" if str(p) == "/dev/null" else read_bytes(p, "tree") for p in (first, second)]
    documents = []
    for path, raw in zip((first, second), data, strict=True):
        document = parse_document(raw or EMPTY, str(path))
        if document[document.root].tag != "root":
            hint = 'its outermost element is <root BTCPP_format="4">'
            raise LlmbtError(Diagnostic("E050", "not a BehaviorTree.CPP 4 file", Span(str(path), 1), help=hint))
        documents.append(document)
    if all(d.trees and has_ids(d) for d in documents):
        try:
            a, b = (table_of(parse_tree(raw, str(p)).tree) for p, raw in zip((first, second), data, strict=True))
        except LlmbtError:
            pass
        else:
            return a, b, lambda node: box_of(node).mark()
    one, two = matched_tables(*documents)
    return one, two, lambda content: content.label()


# -- log and why ---------------------------------------------------------------------------------------------------


@tree.command()
@click.argument("run", type=FILE)
@click.argument("version", required=False)
@click.option("--patch", is_flag=True, help="With each version's difference to the one before.")
@colour_option
@json_flag
def log(run: Path, version: str | None, patch: bool, colour: str, as_json: bool) -> int:
    """Tell how the tree of RUN grew: each version, when and why it was made, why it will work, what happened then."""
    from llmbt.draw import paint, safe, wants_colour
    from llmbt.history import read_run
    from llmbt.render import print_json
    from llmbt.story import log_document, log_lines

    found = read_run(run)
    stages = (found.stage(version),) if version else found.stages
    before: dict[str, Stage] = {s.name: p for p, s in zip(found.stages, found.stages[1:], strict=False)}
    if as_json:
        print_json(log_document(found, stages, partial(_patch_json, before) if patch else None), 0)
        return 0
    painted = wants_colour(colour)

    def touch(text: str, code: str) -> str:
        return paint(safe(text), code, painted)

    for line in log_lines(found, stages, touch, partial(_patch_text, before, painted) if patch else None):
        click.echo(line, color=True)
    return 0


def _patch_text(before: Mapping[str, Stage], colour: bool, stage: Stage) -> str:
    from llmbt.draw import diff_drawing
    from llmbt.picture import box_of
    from llmbt_ir.diff import diff_tables, table_of

    a, b = table_of(before[stage.name].tree), table_of(stage.tree)
    return diff_drawing(a, b, diff_tables(a, b), lambda node: box_of(node).mark(), colour=colour)


def _patch_json(before: Mapping[str, Stage], stage: Stage) -> dict[str, Any]:
    from llmbt.picture import box_of
    from llmbt_ir.diff import diff as compare

    return edit_document(compare(before[stage.name].tree, stage.tree), lambda node: box_of(node).mark())


@tree.command()
@click.argument("run", type=FILE)
@click.argument("node")
@colour_option
@json_flag
def why(run: Path, node: str, colour: str, as_json: bool) -> int:
    """Tell where NODE of RUN comes from, through the edits that led to it, back to the words of the request.

    NODE is an id (or the beginning of one), or a label as `pick(object_1, workbench)`.
    """
    from llmbt.draw import paint, safe, wants_colour
    from llmbt.history import origin, read_run
    from llmbt.render import print_json
    from llmbt.whence import why_document, why_lines

    found = read_run(run)
    chains = origin(found, node)
    if as_json:
        print_json(why_document(found, chains), 0)
        return 0
    painted = wants_colour(colour)
    for k, chain in enumerate(chains[:5]):
        if k:
            click.echo()
        for line in why_lines(found, chain, lambda text, code: paint(safe(text), code, painted)):
            click.echo(line, color=True)
    if len(chains) > 5:
        click.echo(f"\nand {len(chains) - 5} more nodes of that label; give an id (llmbt tree show --ids)")
    return 0


# -- export --------------------------------------------------------------------------------------------------------


@tree.command()
@click.argument("file", type=FILE)
@click.option("--format", "form", type=click.Choice(FORMATS), default=None, help="[default: what -o ends in]")
@click.option("--btcpp", "form", flag_value="btcpp", help="The same as --format btcpp.")
@click.option("-o", "--out", type=FILE, default=None, help="A file, or a folder for btcpp. [default: stdout]")
@click.option("--state", type=FILE, default=None, help="A record (tree.vNNN.json) whose state to tick the tree in.")
@click.option("--plain", is_flag=True, help="No statuses, though a record stands beside FILE.")
@click.option("--direction", type=click.Choice(["auto", "down", "right"]), default="auto", help="Of an SVG.")
@click.option("--force", is_flag=True, help="btcpp: replace files of these names in the folder.")
def export(
    file: Path, form: str | None, out: Path | None, state: Path | None, plain: bool, direction: str, force: bool
) -> int:
    """Write FILE (a tree, or a run's folder: its newest version) in a form that other programs read.

    svg, dot, mermaid: pictures and graphs. btlog: what BehaviorTree.CPP's logger would have recorded while this
    version ran. btcpp: the tree with C++ and Python stubs of its leaves, to run it in a process of your own.
    """
    from llmbt_ir.versions import write_atomic

    form = form or (out.suffix[1:] if out is not None else None)
    if form not in FORMATS:
        raise click.UsageError(f"give --format, or -o FILE that ends in one of .{', .'.join(FORMATS[:-1])}")
    if form == "btcpp":
        return _export_plugin(file, out, force)
    data = _exported(file, form, state, plain, direction)
    if out is None or str(out) == "-":
        sys.stdout.buffer.write(data)
    else:
        write_atomic(out, data)
    return 0


def _exported(file: Path, form: str, state: Path | None, plain: bool, direction: str) -> bytes:
    from llmbt.exports.graphs import dot, mermaid
    from llmbt.exports.svg import svg

    if form == "btlog":
        return _recording(file)
    path, facts = _with_state(file, state, plain)
    picture = _picture(path, facts)[1]
    if form == "svg":
        return svg(picture, title=path.name, direction=direction).encode()
    return (dot(picture) if form == "dot" else mermaid(picture)).encode()


def _recording(file: Path) -> bytes:
    from llmbt.exports.btlog import btlog
    from llmbt.history import read_run
    from llmbt.replay import domain_of_run, moments
    from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span

    run = read_run(file if file.is_dir() else file.parent)
    stage = next((s for s in run.stages if s.version.path == file), None) if not file.is_dir() else run.stages[-1]
    if stage is None or not any(s.events for s in run.stages):
        hint = "give a tree.vNNN.xml in the folder of a run that has ended, or that folder"
        raise LlmbtError(Diagnostic("E085", "no story of a run stands beside this tree", Span(str(file)), help=hint))
    return btlog(stage.file, moments(stage, domain_of_run(run)))


def _export_plugin(file: Path, out: Path | None, force: bool) -> int:
    from llmbt.exports.plugin import plugin_files
    from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span
    from llmbt_ir.tree_xml import parse_tree
    from llmbt_ir.versions import write_atomic
    from llmbt_ir.xml import read_bytes

    if out is None:
        raise click.UsageError("--format btcpp writes a folder: give it with -o DIR")
    path = _with_state(file, None, True)[0]
    data = read_bytes(path, "tree")
    found = plugin_files(data, parse_tree(data, str(path)).signatures)
    taken = sorted(name for name in found if (out / name).exists())
    if out.exists() and not out.is_dir():
        raise LlmbtError(Diagnostic("E010", f"`{out}` is a file", Span(str(out))), exit_code=ExitCode.USAGE)
    if taken and not force:
        hint = "give another folder, or --force to write over them"
        title = f"`{out}` has {', '.join(taken)} already"
        raise LlmbtError(Diagnostic("E010", title, Span(str(out)), help=hint), exit_code=ExitCode.USAGE)
    for name, content in found.items():
        write_atomic(out / name, content)
    click.echo(f"{len(found)} files in {out}; see its README.md")
    return 0
