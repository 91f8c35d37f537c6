"""Loading and checking action template libraries."""

from __future__ import annotations

import importlib.resources
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from llmbt_atl.template import ANY, ConditionType, Param, Pattern, Role, Template, Variable
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Severity, Span, nearest
from llmbt_ir.xml import Element, line_of, parse_xml, read_bytes

__all__ = ["Library", "check_library", "library_names", "load_library", "parse_library"]


@dataclass(frozen=True)
class Library:
    """Types, conditions, state variables and templates of one kind of task. Names are unique within each table."""

    name: str
    types: Mapping[str, str | None]
    conditions: Mapping[str, ConditionType]
    variables: tuple[Variable, ...]
    templates: Mapping[str, Template]
    constants: Mapping[str, str] = field(default_factory=dict)
    source: str = ""

    def is_a(self, type_: str, wanted: str) -> bool:
        """Whether a type is `wanted` or below it."""
        here: str | None = type_
        while here is not None:
            if here == wanted:
                return True
            here = self.types.get(here)
        return False

    def achievers(self, condition: str, *, negated: bool = False) -> tuple[Template, ...]:
        """The templates whose Post has a condition of this name, in the file's order."""
        return tuple(
            t
            for t in self.templates.values()
            if any(p.name == condition and p.negated == negated for p in t.post)
            or (negated and any(p.name == condition for p in t.deletes))
        )

    @cached_property
    def verbs(self) -> Mapping[str, Template]:
        """Each verb of a step and its template."""
        return {verb: t for t in self.templates.values() for verb in (t.name, *t.verbs)}

    def parameters(self, name: str) -> tuple[str, ...]:
        """The parameter names of a condition or template; KeyError where it is neither."""
        found = self.conditions.get(name) or self.templates[name]
        return tuple(p.name for p in found.params)


def library_names() -> tuple[str, ...]:
    """The libraries that are shipped."""
    folder = importlib.resources.files("llmbt_atl") / "data"
    return tuple(sorted(p.name[:-4] for p in folder.iterdir() if p.name.endswith(".xml")))


def load_library(name_or_path: str, *, beside: Path | None = None) -> Library:
    """A shipped library by its name, any other by its path, also relative to `beside`. E001-E006, E030-E038."""
    if name_or_path in library_names():
        resource = importlib.resources.files("llmbt_atl") / "data" / f"{name_or_path}.xml"
        return parse_library(resource.read_bytes(), f"{name_or_path}.xml")
    path = Path(name_or_path)
    if beside is not None and not path.is_absolute() and (beside / path).is_file():
        path = beside / path
    if not path.exists() and path.suffix != ".xml":
        close = nearest(name_or_path, library_names())
        raise LlmbtError(
            Diagnostic(
                "E030",
                f"unknown library `{name_or_path}`",
                help=f"shipped: {', '.join(library_names())}; or give the path of an .xml file",
                candidates=close,
            )
        )
    return parse_library(read_bytes(path, "library"), str(path))


def parse_library(data: bytes, source: str) -> Library:
    """Read a library and check that every name it uses is declared, with all its arguments.

    Errors: E031 a name declared twice, E032 an unknown type, E033 an unknown condition, E034 wrong arguments,
    E035 an unbound parameter, E038 a type below itself.
    """
    root = parse_xml(data, source, schema="llmbt_atl:library")
    return _Reader(root, source).read()


class _Reader:
    def __init__(self, root: Element, source: str) -> None:
        self.root, self.source = root, source
        self.faults: list[Diagnostic] = []
        self.types: dict[str, str | None] = {}
        self.conditions: dict[str, ConditionType] = {}

    def fault(self, code: str, title: str, node: Element, hint: str = "") -> None:
        self.faults.append(Diagnostic(code, title, Span(self.source, line_of(node)), help=hint))

    def read(self) -> Library:
        for n in self.root.iterfind("types/type"):
            self.declare(self.types, "type", n, n.get("parent"))
        for n in self.root.iterfind("types/type"):
            if n.get("parent") is not None:
                self.type_of(n, "parent")
                self.circle(n)
        for n in self.root.iterfind("conditions/condition"):
            self.declare(
                self.conditions,
                "condition",
                n,
                ConditionType(str(n.get("name")), self.params(n), _flag(n, "goal"), n.get("words", ""), _line(n)),
            )
        constants = {str(n.get("name")): self.type_of(n) for n in self.root.iterfind("constants/constant")}
        variables = tuple(self.variable(n) for n in self.root.iterfind("variables/variable"))
        templates: dict[str, Template] = {}
        for n in self.root.iterfind("templates/template"):
            self.declare(templates, "template", n, self.template(n, constants))
        for name, template in templates.items():
            if name in self.conditions:
                self.faults.append(
                    Diagnostic(
                        "E031",
                        f"`{name}` is a condition and a template",
                        Span(self.source, template.line),
                    )
                )
        if self.faults:
            raise LlmbtError(*self.faults)
        return Library(
            str(self.root.get("name")),
            self.types,
            self.conditions,
            variables,
            templates,
            constants,
            self.source,
        )

    def declare(self, table: dict[str, Any], what: str, node: Element, value: Any) -> None:
        name = str(node.get("name"))
        if name in table:
            self.fault("E031", f"{what} `{name}` is declared twice", node)
        table[name] = value

    def circle(self, node: Element) -> None:
        name = str(node.get("name"))
        seen, here = {name}, self.types.get(name)
        while here is not None and here not in seen:
            seen.add(here)
            here = self.types.get(here)
        if here is not None:
            self.fault("E038", f"type `{name}` is below itself", node, "remove one of the parents")
            self.types[name] = None

    def type_of(self, node: Element, attribute: str = "type") -> str:
        type_ = str(node.get(attribute))
        if type_ not in self.types:
            close = nearest(type_, self.types)
            self.fault("E032", f"unknown type `{type_}`", node, f"did you mean {', '.join(close)}?" if close else "")
        return type_

    def params(self, node: Element) -> tuple[Param, ...]:
        return tuple(self.param(p) for p in node.iterfind("param"))

    def param(self, node: Element) -> Param:
        role = Role(node.get("role", ""))
        upward, innermost = _flag(node, "upward"), _flag(node, "innermost")
        return Param(str(node.get("name")), self.type_of(node), role, upward, innermost)

    def pattern(
        self, node: Element, bound: set[str], constants: Mapping[str, str], free: bool = False
    ) -> Pattern | None:
        negated = node.tag == "Inverter"
        if negated:
            node = node[0]
        name = str(node.tag)
        declared = self.conditions.get(name)
        if declared is None:
            close = nearest(name, self.conditions)
            self.fault(
                "E033",
                f"unknown condition `{name}`",
                node,
                f"did you mean {', '.join(close)}?" if close else "declare it under <conditions>",
            )
            return None
        wanted = [p.name for p in declared.params]
        if sorted(map(str, node.attrib)) != sorted(wanted):
            self.fault("E034", f"`{name}` takes {', '.join(wanted) or 'no arguments'}", node)
            return None
        args = tuple(str(node.get(w)) for w in wanted)
        for arg in args:
            if arg.startswith("{") and arg.endswith("}"):
                if arg[1:-1] not in bound:
                    close = nearest(arg[1:-1], bound)
                    self.fault(
                        "E035",
                        f"unbound parameter `{arg}`",
                        node,
                        f"did you mean {{{close[0]}}}?" if close else f"declare <param name={arg[1:-1]!r} .../>",
                    )
                    return None
            elif arg == ANY:
                if not free:
                    self.fault("E035", "`*` stands only in a state variable", node)
                    return None
            elif arg not in constants:
                self.fault(
                    "E035",
                    f"`{arg}` is neither a {{parameter}} nor a declared constant",
                    node,
                    f"write {{{arg}}}?",
                )
                return None
        return Pattern(name, args, negated, _line(node))

    def patterns(self, node: Element | None, bound: set[str], constants: Mapping[str, str]) -> tuple[Pattern, ...]:
        found = (self.pattern(n, bound, constants) for n in (node if node is not None else ()))
        return tuple(p for p in found if p is not None)

    def variable(self, node: Element) -> Variable:
        params = self.params(node)
        bound = {p.name for p in params}
        values = []
        for n in node:
            value = self.pattern(n, bound, {}, free=True) if n.tag != "param" else None
            if value is None:
                continue
            missing = [f"{{{name}}}" for name in (p.name for p in params) if name not in value.params()]
            if missing:
                hint = "otherwise nobody can tell which variable it is a value of"
                self.fault("E035", f"`{value.name}` has to mention {', '.join(missing)}", n, hint)
                continue
            values.append(value)
        return Variable(str(node.get("name")), params, tuple(values), _line(node))

    def template(self, node: Element, constants: Mapping[str, str]) -> Template:
        params = self.params(node)
        bound = {p.name for p in params}
        for n in node.iterfind("unequal"):
            for side in ("first", "second"):
                if n.get(side) not in bound:
                    self.fault("E035", f"unbound parameter `{n.get(side)}`", n)
        post = self.patterns(node.find("post"), bound, constants)
        for n in node.iterfind("delete/Inverter"):
            self.fault("E034", "<delete> lists what ends", n, f"write <{n[0].tag}> under <post> if it begins")
        return Template(
            str(node.get("name")),
            params,
            self.patterns(node.find("start"), bound, constants),
            self.patterns(node.find("hold"), bound, constants),
            tuple(p for p in post if not p.negated),
            self.patterns(node.find("delete"), bound, constants)
            + tuple(Pattern(p.name, p.args, False, p.line) for p in post if p.negated),
            tuple((str(n.get("first")), str(n.get("second"))) for n in node.iterfind("unequal")),
            tuple((node.get("verbs") or "").split()),
            node.get("words", ""),
            _line(node),
            _flag(node, "senses"),
        )


def _line(node: Element) -> int:
    return line_of(node)


def _flag(node: Element, name: str) -> bool:
    """An xsd:boolean, as the schema has it."""
    return str(node.get(name, "")).strip() in ("true", "1")


def check_library(library: Library) -> Iterator[Diagnostic]:
    """What loads but cannot be meant: W036 a Post that no Pre needs and no goal may name, W037 a template that can
    never apply (its Pre contradicts itself, or needs what nothing brings about and no world reports)."""
    needed = {(p.name, p.negated) for t in library.templates.values() for p in t.pre}
    goals = {c.name for c in library.conditions.values() if c.goal}
    for t in library.templates.values():
        for p in t.post:
            if (p.name, False) not in needed and p.name not in goals:
                yield Diagnostic(
                    "W036",
                    f"`{t.name}` brings about `{p.name}`, which no template needs and no goal may name",
                    Span(library.source, p.line),
                    help='mark the condition goal="true", or remove the effect',
                    severity=Severity.WARNING,
                )
        clash = _contradiction(library, t)
        if clash is not None:
            yield Diagnostic(
                "W037",
                f"`{t.name}` can never apply: {clash}",
                Span(library.source, t.line),
                help="of the values of one state variable at most one holds at a time",
                severity=Severity.WARNING,
            )


def _contradiction(library: Library, template: Template) -> str | None:
    """Two preconditions that cannot hold together for any binding."""
    pre = template.pre
    for i, a in enumerate(pre):
        for b in pre[i + 1 :]:
            if a.name == b.name and a.args == b.args and a.negated != b.negated:
                return f"it needs {a.name} and not {a.name}"
            if a.negated or b.negated:
                continue
            for v in library.variables:
                keys_a, keys_b = _keys(v, a), _keys(v, b)
                if keys_a is None or not _always(library, v, keys_a, template):
                    continue
                if keys_a == keys_b and (a.name, a.args) != (b.name, b.args):
                    upward = [q.upward for q in library.conditions[a.name].params]
                    if a.name == b.name and all(x == y or up for x, y, up in zip(a.args, b.args, upward, strict=True)):
                        continue
                    return f"{a.name} and {b.name} are values of the state variable `{v.name}`"
    return None


def _always(library: Library, variable: Variable, keys: tuple[tuple[str, str], ...], template: Template) -> bool:
    """Whether every binding of a template's parameters is of the types that a variable has."""
    types = {f"{{{p.name}}}": p.type for p in template.params} | dict(library.constants)
    wanted = {p.name: p.type for p in variable.params}
    return all(library.is_a(types[arg], wanted[name]) for name, arg in keys if name in wanted)


def _keys(variable: Variable, pattern: Pattern) -> tuple[tuple[str, str], ...] | None:
    """The binding of a variable's parameters under which a pattern is one of its values."""
    for value in variable.values:
        if value.name == pattern.name:
            pairs = {v[1:-1]: a for v, a in zip(value.args, pattern.args, strict=True) if v.startswith("{")}
            return tuple(sorted(pairs.items()))
    return None
