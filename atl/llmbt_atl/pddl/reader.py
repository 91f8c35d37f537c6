"""PDDL text as nested lists that know their lines.

Why not a parser from PyPI: a library keeps the order and the line of what it declares, and published domains are not
always tidy. `pddl` 0.5.1 keeps neither order nor lines, refuses keywords in capitals and an action without
:precondition, reads `:precondition ()` as false, accepts undeclared predicates, and takes 0.28 s to import.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span

__all__ = ["Group", "Item", "Source", "Word", "lists", "read", "title_of"]

_TOKEN = re.compile(r"[()]|[^\s();]+")
_NEVER = re.compile("[{}\x00-\x1f\x7f-\x9f\ufffe\uffff]")
"""What no XML can hold, and the braces of a library's parameters."""
MAX_NESTED = 200


@dataclass(frozen=True, slots=True)
class Word:
    """A name, keyword or variable as written; `key` is what it is compared by."""

    text: str
    line: int
    column: int

    @property
    def key(self) -> str:
        """PDDL does not tell capitals from small letters."""
        return self.text.lower()


@dataclass(frozen=True, slots=True)
class Group:
    """A list in parentheses."""

    items: tuple[Item, ...]
    line: int
    column: int

    @property
    def head(self) -> str:
        """The key of the first word, empty where the list does not begin with a word."""
        return self.items[0].key if self.items and isinstance(self.items[0], Word) else ""


Item = Word | Group


@dataclass(frozen=True, slots=True)
class Source:
    """A text and its name, for complaints."""

    name: str
    lines: tuple[str, ...]

    def fault(self, code: str, title: str, at: Item | None = None, hint: str = "") -> LlmbtError:
        """The error for a place."""
        if at is None:
            return LlmbtError(Diagnostic(code, title, Span(self.name), help=hint))
        length = len(at.text) if isinstance(at, Word) else 1
        text = self.lines[at.line - 1][:200] if 0 < at.line <= len(self.lines) else ""
        return LlmbtError(
            Diagnostic(code, title, Span(self.name, at.line, at.column, at.column + length, text), help=hint)
        )


def _tokens(source: Source) -> Iterator[Word]:
    for number, line in enumerate(source.lines, start=1):
        for found in _TOKEN.finditer(line.split(";", 1)[0]):
            yield Word(found.group(), number, found.start() + 1)


def lists(text: str, name: str) -> tuple[Source, Group]:
    """The one list in parentheses that a text is. E090 where it is not one."""
    source = Source(name, tuple(text.splitlines()))
    open_: list[tuple[Word, list[Item]]] = []
    found: Group | None = None
    for token in _tokens(source):
        odd = _NEVER.search(token.text)
        if odd is not None:
            raise source.fault("E090", f"a name cannot hold {odd.group()!r}", token)
        if found is not None:
            raise source.fault("E090", "there is text after the end of the definition", token, "remove it")
        if token.text == "(":
            if len(open_) == MAX_NESTED:
                raise source.fault("E090", f"lists are nested more than {MAX_NESTED} deep", token)
            open_.append((token, []))
        elif not open_:
            raise source.fault("E090", f"expected `(` and not `{token.text}`", token)
        elif token.text == ")":
            start, items = open_.pop()
            group = Group(tuple(items), start.line, start.column)
            if open_:
                open_[-1][1].append(group)
            else:
                found = group
        else:
            open_[-1][1].append(token)
    if open_:
        raise source.fault("E090", "this list is not closed", open_[-1][0], "add `)`")
    if found is None:
        raise source.fault("E090", "there is no definition", None, "it begins with `(`")
    return source, found


def read(text: str, name: str, kind: str) -> tuple[Source, Group]:
    """The one `(define (<kind> ...) ...)` of a text. E090 where it is not one."""
    source, found = lists(text, name)
    second = found.items[1] if len(found.items) > 1 else None
    if found.head != "define" or not isinstance(second, Group) or second.head != kind:
        raise source.fault("E090", f"this does not define a {kind}", found, f"begin with (define ({kind} <name>) ...")
    return source, found


def title_of(definition: Group) -> str:
    """The name in `(define (domain <name>) ...)`."""
    title = definition.items[1]
    second = title.items[1] if isinstance(title, Group) and len(title.items) > 1 else None
    return second.text if isinstance(second, Word) else "unnamed"
