"""Reading and writing XML safely: every complaint has a file and a line; hostile documents are refused.

Before lxml is asked to build anything, size, nesting depth and DOCTYPE are checked on an event stream, so that
external entities, entity bombs and very deep documents end as diagnostics.
"""

from __future__ import annotations

import difflib
import importlib.resources
import re
import sys
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias
from xml.parsers import expat

from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span

if TYPE_CHECKING:  # imported where a document is built: what only writes does without it
    from lxml import etree

__all__ = ["MAX_BYTES", "MAX_DEPTH", "line_of", "parse_xml", "read_bytes", "schema_of"]

MAX_BYTES = 64 * 1024 * 1024
MAX_DEPTH = 2_000
"""libxml2 stops at 2,048 levels of its own accord."""
MAX_ATTRIBUTES = 200
"""Of one element: libxml2 takes a minute over 100,000."""
Element: TypeAlias = "etree._Element"


def read_bytes(path: Path, what: str) -> bytes:
    """The bytes of a file, or of standard input for `-`; a missing, unreadable or oversized one is a diagnostic (E001,
    E002)."""
    try:
        if path.is_dir():
            raise IsADirectoryError(f"{path} is a folder")
        with nullcontext(sys.stdin.buffer) if str(path) == "-" else path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)  # a device has no size and no end
    except OSError as fault:
        close = difflib.get_close_matches(path.name, _siblings(path), n=3)
        raise LlmbtError(
            Diagnostic(
                "E001",
                f"cannot read {what} `{path}`: {fault.strerror or fault}",
                Span(str(path)),
                help=f"did you mean {', '.join(close)}?" if close else "give the path of an existing file",
                candidates=tuple(close),
            )
        ) from None
    if len(data) > MAX_BYTES:
        raise LlmbtError(Diagnostic("E002", f"{what} is larger than {MAX_BYTES // 2**20} MiB", Span(str(path))))
    return data


def _siblings(path: Path) -> list[str]:
    try:
        return sorted(p.name for p in path.parent.iterdir())
    except OSError:
        return []


def line_of(element: Element) -> int:
    """The line on which an element begins, from 1; 0 where it is not known."""
    line = element.sourceline
    return line if isinstance(line, int) else 0


def _refuse(source: str, code: str, title: str, line: int = 0, hint: str = "", text: str = "") -> LlmbtError:
    return LlmbtError(Diagnostic(code, title, Span(source, line, text=text), help=hint))


def _scan(data: bytes, source: str, max_depth: int) -> None:
    """Well-formed, no DOCTYPE, no processing instruction bombs, at most `max_depth` levels, no element of too many
    attributes."""
    parser = expat.ParserCreate()
    depth = 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if len(attributes) > MAX_ATTRIBUTES:
            raise _refuse(
                source,
                "E004",
                f"<{name[:40]}> has more than {MAX_ATTRIBUTES} attributes",
                parser.CurrentLineNumber,
            )
        if depth > max_depth:
            raise _refuse(
                source,
                "E004",
                f"the XML is nested more than {max_depth} levels deep",
                parser.CurrentLineNumber,
                "split the tree into <SubTree>s",
            )

    def end(_name: str) -> None:
        nonlocal depth
        depth -= 1

    def doctype(*_: Any) -> None:
        raise _refuse(
            source,
            "E005",
            "a DOCTYPE is not allowed: entities are never expanded",
            parser.CurrentLineNumber,
            "remove the <!DOCTYPE ...> declaration",
        )

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except (expat.ExpatError, ValueError, LookupError) as fault:
        line = getattr(fault, "lineno", 0)
        lines = data.decode("utf-8", "replace").splitlines()
        text = lines[line - 1][:200] if 0 < line <= len(lines) else ""
        reason = expat.errors.messages.get(getattr(fault, "code", -1), str(fault))
        raise _refuse(source, "E003", f"not well-formed XML: {reason}", line, "", text) from None


def parse_xml(data: bytes, source: str, *, schema: str | None = None, max_depth: int = MAX_DEPTH) -> Element:
    """The root element of a document, checked before it is built, and against a schema where one is named.

    Errors: E003 not well-formed, E004 too deep or too wide, E005 DOCTYPE, E006 not as the schema wants it.
    """
    from lxml import etree

    _scan(data, source, max_depth)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, huge_tree=True, remove_comments=True, remove_pis=True
    )
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as fault:
        raise _refuse(source, "E003", f"not well-formed XML: {fault.msg}", fault.lineno or 0) from None
    if schema is not None:
        _validate(root, data, source, schema)
    return root


@cache
def schema_of(name: str) -> etree.RelaxNG:
    """The RelaxNG schema `name`.rng, wherever one of our packages ships it: `package:name` or one of ours."""
    from lxml import etree

    package, _, stem = name.rpartition(":")
    folder = importlib.resources.files(package or "llmbt_ir") / "schemas"
    return etree.RelaxNG(etree.fromstring((folder / f"{stem}.rng").read_bytes()))


def _validate(root: Element, data: bytes, source: str, schema: str) -> None:
    relaxng = schema_of(schema)
    if relaxng.validate(root):
        return
    lines = data.decode("utf-8", "replace").splitlines()
    found: list[Diagnostic] = []
    seen: set[int] = set()
    for entry in relaxng.error_log:
        if entry.line in seen or len(found) == 5:
            continue
        seen.add(entry.line)
        text = lines[entry.line - 1].rstrip()[:200] if 0 < entry.line <= len(lines) else ""
        found.append(
            Diagnostic("E006", _bad_value(root, entry) or _plain(entry.message), Span(source, entry.line, text=text))
        )
    raise LlmbtError(*found)


def _bad_value(root: Element, entry: Any) -> str | None:
    """Which value is not a number, where an attribute of numbers (a name that ends in a unit) has one."""
    said = re.fullmatch(r"Invalid attribute (\S+_(?:m|rad|kg|deg)) for element (\S+)", entry.message)
    nodes = [] if said is None else [n for n in root.iter(said[2]) if line_of(n) == entry.line]
    if said is None or len(nodes) != 1:
        return None
    odd = [v for v in (nodes[0].get(said[1]) or "").split() if not re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)", v)]
    return f"`{odd[0]}` in `{said[1]}` of <{said[2]}> is no plain decimal number, as 0.4" if odd else None


def _plain(message: str) -> str:
    message = re.sub(r"^Element (\S+) failed to validate content$", r"<\1> has something it may not have", message)
    message = re.sub(r"^Did not expect element (\S+) there$", r"<\1> may not stand here", message)
    return re.sub(
        r"^Invalid attribute (\S+) for element (\S+)$",
        r"<\2> has no attribute `\1`, or not with this value",
        message,
    )
