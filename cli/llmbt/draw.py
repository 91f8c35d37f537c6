"""Trees and their differences as Unicode text, with the paper's symbols. Nothing here recurses on depth."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from llmbt.picture import Picture, picture_of_tree
from llmbt_ir.diff import Diff, Spot, Table
from llmbt_ir.tree import Tree

__all__ = ["diff_drawing", "drawing", "paint", "picture_drawing", "wants_colour"]

C = TypeVar("C")
GREEN, RED, YELLOW, CYAN, FAINT = "32", "31", "33", "36", "2"
STATUS = {"SUCCESS": (GREEN, " ✓"), "FAILURE": (RED, " ✗"), "RUNNING": (YELLOW, " …"), "": (FAINT, "")}
INDENT = 120
"""Columns of indentation at most; what is nested deeper is drawn with its level in front."""


def wants_colour(choice: str = "auto") -> bool:
    """Whether to colour what goes to stdout: `always`, `never`, or as the terminal and NO_COLOR say."""
    return choice == "always" or (choice == "auto" and sys.stdout.isatty() and not os.environ.get("NO_COLOR"))


def paint(text: str, code: str, colour: bool) -> str:
    """Text in a colour, where colours are wanted."""
    return f"\x1b[{code}m{text}\x1b[0m" if colour and code else text


def drawing(tree: Tree, statuses: Mapping[str, str] | None = None, *, colour: bool = False) -> str:
    """One line a node, children below their parent; statuses by node id, as marks and colours."""
    return picture_drawing(picture_of_tree(tree, statuses), colour=colour)


def picture_drawing(picture: Picture, *, colour: bool = False, ids: bool = False) -> str:
    """One line a box, children below their parent."""
    known = any(b.status for b in picture.boxes.values())
    lines: list[str] = []
    for lead, id_ in _leads(picture.tops, lambda i: picture.boxes[i].children):
        box = picture.boxes[id_]
        code, mark = STATUS[box.status] if known else ("", "")
        name = paint(f"   {safe(box.id)}", FAINT, colour) if ids else ""
        lines.append(paint(lead, FAINT, colour) + paint(safe(box.mark()) + mark, code, colour) + name)
    return "\n".join(lines)


def safe(text: str) -> str:
    """Text that cannot steer a terminal."""
    return "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in text)


def _leads(tops: tuple[str, ...], children: Callable[[str], tuple[str, ...]]) -> Iterator[tuple[str, str]]:
    """What stands before each node's text, in pre-order."""
    stack = [("", "", top, 1) for top in reversed(tops)]
    while stack:
        lead, below, id_, level = stack.pop()
        deep = len(below) > INDENT
        yield (f"{level:>6} …{lead[-INDENT:]}" if deep else lead), id_
        below = below[-INDENT - 3 :] if deep else below
        kids = children(id_)
        last = len(kids) - 1
        for i in range(last, -1, -1):
            branch, bar = ("└─ ", "   ") if i == last else ("├─ ", "│  ")
            stack.append((below + branch, below + bar, kids[i], level + 1))


# -- differences ---------------------------------------------------------------------------------------------------


def diff_drawing(
    first: Table[C], second: Table[C], edit: Diff[C], label: Callable[[C], str], *, colour: bool = False
) -> str:
    """The second tree where it differs, with what is gone in its old place: + added, - removed, > moved, ~ changed.

    What is the same and holds no difference is counted, not drawn.
    """
    marks, notes = _marks(first, edit, label)
    children = _merged(first, second, edit)
    shown = _touched(second.root, children, marks)
    lines: list[str] = []

    def kids(id_: str) -> tuple[str, ...]:
        return _folded(id_, children, shown)

    for lead, id_ in _leads((second.root,), kids):
        if id_.startswith("\0"):
            lines.append(paint(f"  {lead}⋯ {id_.rpartition(chr(0))[2]} more, the same", FAINT, colour))
            continue
        mark, code = marks.get(id_, (" ", ""))
        where = second.entries if id_ in second.entries and mark != "-" else first.entries
        note = f"   {notes[id_]}" if id_ in notes else ""
        lines.append(paint(f"{mark} {lead}{safe(label(where[id_].content))}{safe(note)}", code, colour))
    return "\n".join(lines)


def _marks(
    first: Table[C], edit: Diff[C], label: Callable[[C], str]
) -> tuple[dict[str, tuple[str, str]], dict[str, str]]:
    marks: dict[str, tuple[str, str]] = {}
    notes: dict[str, str] = {}
    marks.update((a.id, ("+", GREEN)) for a in edit.added)
    marks.update((r.id, ("-", RED)) for r in edit.removed)
    for change in edit.changed:
        marks[change.id] = ("~", CYAN)
        notes[change.id] = f"was {label(change.before)}"
    for move in edit.moved:
        marks[move.id] = (">", YELLOW)
        notes[move.id] = f"{notes[move.id]}, {_from(move.before, first, label)}" if move.id in notes else ""
        notes[move.id] = notes[move.id] or _from(move.before, first, label)
    return marks, notes


def _from(spot: Spot, first: Table[C], label: Callable[[C], str]) -> str:
    if spot.after is not None:
        return f"was after {label(first.entries[spot.after].content)} ({spot.after})"
    return f"was the first below {spot.parent}" if spot.parent is not None else "was the root"


def _merged(first: Table[C], second: Table[C], edit: Diff[C]) -> dict[str, tuple[str, ...]]:
    """The children in the second tree, and among them the removed ones where they were."""
    gone = {e.id for e in edit.removed}
    rows = {i: e.children for i, e in second.entries.items()}
    rows |= {i: tuple(c for c in first.entries[i].children if c in gone) for i in gone}
    for parent in {e.at.parent for e in edit.removed} - gone - {None}:
        assert parent is not None
        there = set(rows[parent])
        anchor, behind = "", {"": list[str]()}
        for child in first.entries[parent].children:
            if child in there:
                anchor = child
                behind[anchor] = []
            elif child in gone:
                behind[anchor].append(child)
        rows[parent] = (*behind[""], *(c for kept in rows[parent] for c in (kept, *behind.get(kept, ()))))
    tops = tuple(e.id for e in edit.removed if e.at.parent is None and e.id != second.root)
    rows[second.root] = (*rows[second.root], *tops)
    return rows


def _touched(root: str, children: Mapping[str, tuple[str, ...]], marks: Mapping[str, object]) -> set[str]:
    """The marked nodes, all above them, and what those begin with where it is a leaf: it tells which branch it is."""
    order: list[str] = []
    stack = [root]
    while stack:
        here = stack.pop()
        order.append(here)
        stack.extend(children[here])
    found: set[str] = set()
    for id_ in reversed(order):
        if id_ in marks or any(c in found for c in children[id_]):
            found.add(id_)
    firsts = {children[i][0] for i in found if children[i]}
    return found | {i for i in firsts if not children[i]}


def _folded(id_: str, children: Mapping[str, tuple[str, ...]], shown: set[str]) -> tuple[str, ...]:
    """The children of a node to draw; runs of others as one entry that begins with a null character."""
    if id_.startswith("\0"):
        return ()
    row: list[str] = []
    run = 0
    for child in (*children[id_], ""):
        if child and child not in shown:
            run += 1
            continue
        if run:
            row.append(f"\0{child}\0{run}")
        run = 0
        if child:
            row.append(child)
    return tuple(row)
