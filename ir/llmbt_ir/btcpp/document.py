"""A BehaviorTree.CPP file as a flat table of elements: nothing is lost but the layout, and depth costs nothing.

Comments, processing instructions and texts are elements too, so that what is read can be written again. Lines and
columns count from 1.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NoReturn
from xml.parsers import expat

from llmbt_ir.btcpp.loose import escaped
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
from llmbt_ir.quoting import escape, quoteattr
from llmbt_ir.xml import read_bytes

__all__ = ["COMMENT", "INSTRUCTION", "TEXT", "Document", "Element", "parse_document", "read_document"]

COMMENT, INSTRUCTION, TEXT = "#comment", "#instruction", "#text"
MAX_ELEMENTS = 1_000_000
NO_PARENT = -1


@dataclass(frozen=True, slots=True)
class Element:
    """An element, or what stands between elements (`tag` begins with #, `text` is what it holds)."""

    tag: str
    attributes: tuple[tuple[str, str], ...] = ()
    parent: int = NO_PARENT
    children: tuple[int, ...] = ()
    text: str = ""
    line: int = field(default=0, compare=False)
    column: int = field(default=0, compare=False)
    file: int = field(default=0, compare=False)

    def get(self, name: str, default: str = "") -> str:
        """An attribute's value."""
        return next((v for k, v in self.attributes if k == name), default)

    def has(self, name: str) -> bool:
        """Whether it has an attribute."""
        return any(k == name for k, _ in self.attributes)


@dataclass(frozen=True)
class Document:
    """The elements of a file in the order in which they begin; `outside` are those that are not below the root; `loose`
    are lines that are no well-formed XML, and that BehaviorTree.CPP's parser reads all the same.

    `included` are the names and lines of further files, where it is made of several (`llmbt_ir.btcpp.includes`):
    elements know theirs, counted from 1; 0 is the file itself.
    """

    elements: tuple[Element, ...]
    root: int
    outside: tuple[int, ...] = ()
    source: str = field(default="", compare=False)
    lines: tuple[str, ...] = field(default=(), compare=False, repr=False)
    loose: tuple[int, ...] = field(default=(), compare=False)
    included: tuple[tuple[str, tuple[str, ...]], ...] = field(default=(), compare=False, repr=False)

    def __getitem__(self, index: int) -> Element:
        return self.elements[index]

    def kids(self, index: int) -> tuple[int, ...]:
        """The child elements; comments and texts left out."""
        return tuple(i for i in self.elements[index].children if self.elements[i].tag[0] != "#")

    def named(self, index: int, tag: str) -> tuple[int, ...]:
        """The child elements of a tag."""
        return tuple(i for i in self.elements[index].children if self.elements[i].tag == tag)

    def below(self, index: int) -> Iterator[int]:
        """An element and all elements in it, in order; comments and texts left out."""
        stack = [index]
        while stack:
            here = stack.pop()
            yield here
            stack.extend(reversed(self.kids(here)))

    @cached_property
    def trees(self) -> tuple[int, ...]:
        """The <BehaviorTree> elements."""
        return self.named(self.root, "BehaviorTree")

    @cached_property
    def by_id(self) -> dict[str, int]:
        """The <BehaviorTree> elements by their ID; of several the first."""
        found: dict[str, int] = {}
        for i in self.trees:
            found.setdefault(self[i].get("ID"), i)
        return found

    @property
    def main(self) -> str | None:
        """The ID of the tree to execute, where the file tells."""
        wanted = self[self.root].get("main_tree_to_execute")
        if wanted:
            return wanted
        return self[self.trees[0]].get("ID") if len(self.trees) == 1 else None

    def span(self, index: int, attribute: str = "") -> Span:
        """Where an element begins, or where an attribute of it stands if that can be told."""
        element = self[index]
        source, lines = ((self.source, self.lines), *self.included)[element.file]
        if not 0 < element.line <= len(lines):
            return Span(source, element.line)
        text = lines[element.line - 1]
        start = element.column
        end = start + 1 + len(element.tag)
        if attribute:
            found = re.search(rf"\s({re.escape(attribute)})\s*=\s*(?:\"[^\"]*\"|'[^']*')", text[start:])
            if found:
                start, end = start + found.start(1) + 1, start + found.end() + 1
        return Span(source, element.line, start, end, text) if len(text) <= 400 else Span(source, element.line)

    def place(self, index: int, seen_from: int) -> str:
        """Where an element begins, in words: with the file where that is not the one of another element."""
        element = self[index]
        if element.file == self[seen_from].file:
            return f"in line {element.line}"
        return f"in {((self.source, ()), *self.included)[element.file][0]}, line {element.line}"

    def write(self) -> bytes:
        """The file again, laid out with one element a line; texts and attribute orders are kept."""
        out = ['<?xml version="1.0" encoding="UTF-8"?>']
        for top in sorted((self.root, *self.outside)):
            out.extend(self._lines(top))
        return ("\n".join(out) + "\n").encode()

    def _lines(self, top: int) -> Iterator[str]:
        stack: list[tuple[int, int, bool]] = [(top, 0, False)]
        while stack:
            index, level, closing = stack.pop()
            element, indent = self[index], "  " * min(level, 40)
            if closing:
                yield f"{indent}</{element.tag}>"
            elif not element.children:
                yield indent + self._alone(element)
            elif any(self[c].tag == TEXT for c in element.children):
                yield indent + "".join(self._inline(index))
            else:
                yield f"{indent}<{element.tag}{_attributes(element)}>"
                stack.append((index, level, True))
                stack.extend((c, level + 1, False) for c in reversed(element.children))

    def _inline(self, top: int) -> Iterator[str]:
        """Mixed content, where a space more would be another text."""
        stack: list[tuple[int, bool]] = [(top, False)]
        while stack:
            index, closing = stack.pop()
            element = self[index]
            if closing:
                yield f"</{element.tag}>"
            elif element.children:
                yield f"<{element.tag}{_attributes(element)}>"
                stack.append((index, True))
                stack.extend((c, False) for c in reversed(element.children))
            else:
                yield self._alone(element)

    @staticmethod
    def _alone(element: Element) -> str:
        if element.tag == COMMENT:
            return f"<!--{element.text}-->"
        if element.tag == INSTRUCTION:
            return f"<?{element.text}?>"
        if element.tag == TEXT:
            return escape(element.text).replace("\r", "&#13;")
        return f"<{element.tag}{_attributes(element)}/>"


def _attributes(element: Element) -> str:
    return "".join(f" {k}={quoteattr(v)}" for k, v in element.attributes)


# -- reading -------------------------------------------------------------------------------------------------------


def read_document(path: Path) -> Document:
    """Read a file (see `parse_document`)."""
    return parse_document(read_bytes(path, "tree"), str(path))


def parse_document(data: bytes, source: str = "tree.xml") -> Document:
    """The elements of any XML document; `&` and `<` as such in values are understood, as BehaviorTree.CPP does, whose
    scripts are full of them. Errors: E003 not well-formed, E004 too large, E005 DOCTYPE."""
    try:
        return _Builder(data, source).build()
    except LlmbtError as fault:
        if fault.diagnostics[0].code != "E003":
            raise
        strict, loose = escaped(data)
        if not loose:
            raise
        try:
            return replace(_Builder(strict, source).build(), loose=loose)
        except LlmbtError:
            raise fault from None


class _Builder:
    def __init__(self, data: bytes, source: str) -> None:
        self.data, self.source = data, source
        self.found: list[tuple[str, tuple[tuple[str, str], ...], int, str, int, int]] = []
        self.children: list[list[int]] = []
        self.open: list[int] = []
        self.text: list[str] = []
        self.parser = expat.ParserCreate()

    def build(self) -> Document:
        p = self.parser
        p.ordered_attributes = True
        p.buffer_text = True
        p.StartElementHandler = self.start
        p.EndElementHandler = self.end
        p.CharacterDataHandler = self.text.append
        p.CommentHandler = lambda text: self.aside(COMMENT, text)
        p.ProcessingInstructionHandler = lambda target, text: self.aside(INSTRUCTION, f"{target} {text}".rstrip())
        p.StartDoctypeDeclHandler = self.doctype
        try:
            p.Parse(self.data, True)
        except (expat.ExpatError, ValueError, LookupError) as fault:
            reason = expat.errors.messages.get(getattr(fault, "code", -1), str(fault))
            self.refuse("E003", f"not well-formed XML: {reason}", getattr(fault, "lineno", 0))
        elements = tuple(
            Element(tag, attributes, parent, tuple(kids), text, line, column)
            for (tag, attributes, parent, text, line, column), kids in zip(self.found, self.children, strict=True)
        )
        tops = [i for i, e in enumerate(elements) if e.parent == NO_PARENT]
        root = next(i for i in tops if elements[i].tag[0] != "#")
        lines = tuple(self.data.decode("utf-8", "replace").splitlines())
        return Document(elements, root, tuple(i for i in tops if i != root), self.source, lines)

    def refuse(self, code: str, title: str, line: int, hint: str = "") -> NoReturn:
        raise LlmbtError(Diagnostic(code, title, Span(self.source, line), help=hint)) from None

    def add(self, tag: str, attributes: tuple[tuple[str, str], ...], text: str) -> int:
        index = len(self.found)
        if index >= MAX_ELEMENTS:
            self.refuse("E004", f"the file has more than {MAX_ELEMENTS} elements", self.parser.CurrentLineNumber)
        parent = self.open[-1] if self.open else NO_PARENT
        line, column = self.parser.CurrentLineNumber, self.parser.CurrentColumnNumber + 1
        self.found.append((tag, attributes, parent, text, line, column))
        self.children.append([])
        if parent != NO_PARENT:
            self.children[parent].append(index)
        return index

    def flush(self) -> None:
        text = "".join(self.text)
        self.text.clear()
        if text.strip():
            self.add(TEXT, (), text)

    def start(self, tag: str, flat: Any) -> None:
        self.flush()
        self.open.append(self.add(tag, tuple(zip(flat[::2], flat[1::2], strict=True)), ""))

    def end(self, _tag: str) -> None:
        self.flush()
        self.open.pop()

    def aside(self, tag: str, text: str) -> None:
        self.flush()
        self.add(tag, (), text)

    def doctype(self, *_: Any) -> None:
        self.refuse(
            "E005",
            "a DOCTYPE is not allowed: entities are never expanded",
            self.parser.CurrentLineNumber,
            "remove the <!DOCTYPE ...> declaration",
        )
