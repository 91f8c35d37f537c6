"""A library as XML that loads back as the same library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from llmbt_atl.library import Library
from llmbt_atl.template import Param, Pattern, Template
from llmbt_ir.quoting import quoteattr

__all__ = ["write_library"]


def write_library(library: Library) -> bytes:
    """The canonical XML of a library: the same library gives the same bytes."""
    return ("\n".join(_library(library)) + "\n").encode()


_ENTITIES = (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ('"', "&quot;"), ("\n", "&#10;"), ("\t", "&#9;"))


def _tag(name: str, attributes: Iterable[tuple[str, str]], *, close: bool = True) -> str:
    return f"<{name}{''.join(f' {k}={quoteattr(v)}' for k, v in attributes)}{'/' if close else ''}>"


def _library(library: Library) -> Iterator[str]:
    yield '<?xml version="1.0" encoding="UTF-8"?>'
    yield _tag("library", [("name", library.name)], close=False)
    yield "  <types>"
    for name, parent in library.types.items():
        yield "    " + _tag("type", [("name", name), *([] if parent is None else [("parent", parent)])])
    yield "  </types>"
    yield "  <conditions>"
    for c in library.conditions.values():
        attributes = [("name", c.name)]
        if c.goal:
            attributes.append(("goal", "true"))
        if c.words:
            attributes.append(("words", c.words))
        yield from _block("condition", attributes, list(_params(c.params)), 4)
    yield "  </conditions>"
    if library.constants:
        yield "  <constants>"
        for name, type_ in library.constants.items():
            yield "    " + _tag("constant", [("name", name), ("type", type_)])
        yield "  </constants>"
    if library.variables:
        yield "  <variables>"
        for v in library.variables:
            values = [_pattern(library, p) for p in v.values]
            yield from _block("variable", [("name", v.name)], [*_params(v.params), *values], 4)
        yield "  </variables>"
    yield "  <templates>"
    for t in library.templates.values():
        attributes = [("name", t.name)]
        if t.words:
            attributes.append(("words", t.words))
        if t.verbs:
            attributes.append(("verbs", " ".join(t.verbs)))
        if t.senses:
            attributes.append(("senses", "true"))
        yield from _block("template", attributes, list(_template(library, t)), 4)
    yield "  </templates>"
    yield "</library>"


def _block(name: str, attributes: list[tuple[str, str]], lines: list[str], indent: int) -> Iterator[str]:
    space = " " * indent
    if not lines:
        yield space + _tag(name, attributes)
        return
    yield space + _tag(name, attributes, close=False)
    for line in lines:
        yield f"{space}  {line}"
    yield f"{space}</{name}>"


def _params(params: Iterable[Param]) -> Iterator[str]:
    for p in params:
        attributes = [("name", p.name), ("type", p.type)]
        if p.role:
            attributes.append(("role", p.role.value))
        if p.upward:
            attributes.append(("upward", "true"))
        if p.innermost:
            attributes.append(("innermost", "true"))
        yield _tag("param", attributes)


def _pattern(library: Library, pattern: Pattern) -> str:
    names = (p.name for p in library.conditions[pattern.name].params)
    leaf = _tag(pattern.name, zip(names, pattern.args, strict=True))
    return f"<Inverter>{leaf}</Inverter>" if pattern.negated else leaf


def _template(library: Library, template: Template) -> Iterator[str]:
    yield from _params(template.params)
    for first, second in template.unequal:
        yield _tag("unequal", [("first", first), ("second", second)])
    for part, patterns in (
        ("start", template.start),
        ("hold", template.hold),
        ("post", template.post),
        ("delete", template.deletes),
    ):
        inside = "".join(_pattern(library, p) for p in patterns)
        if inside or part == "post":
            yield f"<{part}>{inside}</{part}>" if inside else f"<{part}/>"
