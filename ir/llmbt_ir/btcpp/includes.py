"""Files that include others, as BehaviorTree.CPP reads them: one document, in which each element knows its file.

A path is relative to the folder of the file that names it. Of trees of one ID that of the including file counts, and of
two included files that of the later one. A file that is included twice is read once.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

from llmbt_ir.btcpp.document import MAX_ELEMENTS, NO_PARENT, Document, Element, read_document
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Severity

__all__ = ["MAX_FILES", "with_includes"]

MAX_FILES = 1_000


@dataclass(frozen=True)
class _Part:
    """A file, where it is, and for each <include> that is followed the file it names."""

    document: Document
    path: Path
    includes: dict[int, Path]


def with_includes(first: Document, path: Path) -> tuple[Document, tuple[Diagnostic, ...]]:
    """A document with all that it includes, and what is wrong with its <include>s: T126 one that cannot be read, T127
    a circle, T215 one that is not followed. An <include> that was followed is taken out; others stay. `path` is where
    the document is from."""
    faults: list[Diagnostic] = []
    parts: dict[Path, _Part] = {}
    waiting = [(first, path.resolve())]
    elements = 0
    while waiting:
        document, at = waiting.pop()
        elements += len(document.elements)
        part = _Part(document, at, {})
        parts[at] = part
        for index in document.named(document.root, "include"):
            target = _target(document, at, index, faults)
            if target is None:
                continue
            known = target in parts or any(target == p for _, p in waiting)
            if not known and (len(parts) + len(waiting) >= MAX_FILES or elements > MAX_ELEMENTS):
                what = f"{MAX_FILES} files" if elements <= MAX_ELEMENTS else f"{MAX_ELEMENTS} elements"
                faults.append(_fault("T126", f"more than {what} are included", document, index))
                continue
            found = None if known else _read(document, index, target, faults)
            if known or found is not None:
                part.includes[index] = target
            if found is not None:
                waiting.append((found, target))
    order, circles = _ordered(parts, path.resolve())
    faults.extend(circles)
    return _joined([parts[p] for p in order]), tuple(faults)


def _fault(code: str, title: str, document: Document, index: int, hint: str = "") -> Diagnostic:
    severity = Severity.ERROR if code[1] == "1" else Severity.WARNING
    return Diagnostic(code, title, document.span(index), "", hint, severity)


def _target(document: Document, at: Path, index: int, faults: list[Diagnostic]) -> Path | None:
    """The file that an <include> names; None where it names none that can be followed."""
    element = document[index]
    if not element.get("path"):
        faults.append(_fault("T126", "<include> names no file", document, index, 'write path="..."'))
        return None
    if element.has("ros_pkg") and not Path(element.get("path")).is_absolute():
        title = f"<include> of the ROS package `{element.get('ros_pkg')}` is not followed"
        faults.append(_fault("T215", title, document, index, "what it may define is not called missing"))
        return None
    return (at.parent / element.get("path")).resolve()


def _read(document: Document, index: int, target: Path, faults: list[Diagnostic]) -> Document | None:
    """An included file, under the name that it would be given on the command line beside the one that names it."""
    named = document[index].get("path")
    try:
        found = read_document(target)
    except LlmbtError as fault:
        reason = fault.diagnostics[0]
        line = f", line {reason.span.line}" if reason.span is not None and reason.span.line else ""
        title = f"`{named}` cannot be included: {reason.title}{line}"
        faults.append(_fault("T126", title, document, index, reason.help))
        return None
    if found[found.root].tag != "root":
        title = f"`{named}` cannot be included: its outermost element is <{found[found.root].tag}>, not <root>"
        faults.append(_fault("T126", title, document, index))
        return None
    shown = os.path.normpath(Path(document.source).parent / named)
    return replace(found, source=shown)


def _ordered(parts: dict[Path, _Part], top: Path) -> tuple[list[Path], list[Diagnostic]]:
    """The files, each before those whose trees it overrides, and the circles: one fault for each <include> that closes
    one."""
    order: dict[Path, None] = {}
    faults: list[Diagnostic] = []
    on_path: list[Path] = []
    stack: list[tuple[Path, bool]] = [(top, False)]
    while stack:
        here, leaving = stack.pop()
        if leaving:
            on_path.pop()
            continue
        if here in order:
            continue
        order[here] = None
        on_path.append(here)
        stack.append((here, True))
        part = parts[here]
        for index, target in part.includes.items():
            if target in on_path:
                names = [p.name for p in on_path[on_path.index(target) :]]
                title = f"`{names[0]}` includes itself: {' -> '.join([*names, names[0]])}"
                hint = "BehaviorTree.CPP follows it until the stack is full"
                faults.append(_fault("T127", title, part.document, index, hint))
            else:
                stack.append((target, False))
    return list(order), faults


def _joined(parts: list[_Part]) -> Document:
    """One document: what stands below the roots of the others comes below the first one's."""
    first = parts[0].document
    elements: list[Element] = []
    below: list[int] = []
    outside: list[int] = []
    for number, part in enumerate(parts):
        document, base = part.document, len(elements)
        for element in document.elements:
            parent = element.parent
            if parent != NO_PARENT:
                parent = first.root if parent == document.root else parent + base
            kids = tuple(c + base for c in element.children)
            elements.append(replace(element, parent=parent, children=kids, file=number))
        kept = [c + base for c in document[document.root].children if c not in part.includes]
        below += kept
        outside += [o + base for o in document.outside]
        if number:  # the root of an included file is left over, with nothing in it
            elements[document.root + base] = Element("#included", file=number)
    elements[first.root] = replace(elements[first.root], children=tuple(below))
    texts = tuple((p.document.source, p.document.lines) for p in parts[1:])
    return replace(first, elements=tuple(elements), outside=tuple(outside), included=texts)
