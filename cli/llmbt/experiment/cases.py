"""Experiments and their cases, as people write them: experiments/NAME.xml, and one file a case.

A case says what is wanted, when it is reached by the truth, and in which words it may be asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from llmbt_atl.library import Library, load_library
from llmbt_atl.state import Domain, domain_of
from llmbt_ir.condition import Condition, Goals
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span, nearest
from llmbt_ir.scene import Scene, load_scene, to_semantic_map
from llmbt_ir.shipped import shipped
from llmbt_ir.xml import Element, line_of, parse_xml, read_bytes

__all__ = ["Case", "Experiment", "Reported", "Request", "Share", "cassette_of", "experiment_names", "load_experiment"]
__all__ += ["read_case", "read_experiment"]

Share = tuple[int, int]
"""So many of so many."""


@dataclass(frozen=True, slots=True)
class Request:
    """One way to ask for a case. `why` says what is unclear or wrong with it on purpose; empty where it is clear.

    `reply` is what a model is made to say where none is recorded; None: only a recording can answer.
    """

    id: str
    register: str
    text: str
    reply: str | None
    why: str = ""
    line: int = 0

    @property
    def clear(self) -> bool:
        """Whether it says all that is needed, and nothing that cannot be."""
        return not self.why


@dataclass(frozen=True, slots=True)
class Case:
    """What is wanted in a scene. `success` is judged by the truth: alternatives, each a conjunction."""

    name: str
    experiment: str
    scene: Scene
    library: Library
    date: str
    description: str
    success: Goals
    requests: tuple[Request, ...]
    source: str

    def domain(self) -> Domain:
        """The library over the things of the scene."""
        return domain_of(self.library, to_semantic_map(self.scene))


@dataclass(frozen=True, slots=True)
class Reported:
    """Somebody else's figures for an experiment: of each case overall, reasoning, parser, update; never tested
    against."""

    by: str
    rows: tuple[tuple[Share, Share, Share, Share], ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Experiment:
    """An experiment: cases in order. `notes` are to be read with its rates."""

    name: str
    title: str
    cases: tuple[Case, ...]
    reported: Reported | None
    source: str
    notes: tuple[str, ...] = ()


def experiment_names() -> tuple[str, ...]:
    """The shipped experiments."""
    return tuple(sorted(p.stem for p in shipped("experiments").glob("*.xml")))


def load_experiment(name_or_path: str) -> Experiment:
    """A shipped experiment by its name, any other by its path. Errors as `read_experiment`, E403 for an unknown one."""
    if name_or_path in experiment_names():
        return read_experiment(shipped("experiments") / f"{name_or_path}.xml")
    path = Path(name_or_path)
    if not path.exists() and path.suffix != ".xml":
        close = nearest(name_or_path, experiment_names())
        known = ", ".join(experiment_names())
        raise LlmbtError(
            Diagnostic(
                "E403",
                f"unknown experiment `{name_or_path}`",
                help=(f"did you mean {close[0]}? " if close else "") + f"shipped: {known}; or give the path of an .xml",
                candidates=close,
            )
        )
    return read_experiment(path)


def read_experiment(path: Path) -> Experiment:
    """Read an experiment and its cases. Errors with lines: E001-E006, those of `read_case`, and E401 where a case is
    there twice or belongs to another experiment."""
    root = parse_xml(read_bytes(path, "experiment"), str(path), schema=f"{__package__}:experiment")
    name = root.get("name", "")
    cases: list[Case] = []
    for node in root.iterfind("Cases/Case"):
        case = read_case(path.parent / node.get("file", ""))
        if case.experiment != name or any(c.name == case.name for c in cases):
            what = "is there twice" if case.experiment == name else f"belongs to experiment `{case.experiment}`"
            raise LlmbtError(Diagnostic("E401", f"the case `{case.name}` {what}", Span(str(path), line_of(node))))
        cases.append(case)
    notes = tuple(_words(n) for n in root.iterfind("Note"))
    return Experiment(name, root.get("title", ""), tuple(cases), _reported(root), str(path), notes)


def _reported(root: Element) -> Reported | None:
    node = root.find("Reported")
    if node is None:
        return None
    rows = [
        (_share(r, "overall"), _share(r, "reasoning"), _share(r, "parser"), _share(r, "update"))
        for r in node.iterfind("Row")
    ]
    return Reported(node.get("by", ""), tuple(rows), tuple(_words(n) for n in node.iterfind("Note")))


def _share(node: Element, name: str) -> Share:
    good, _, all_ = node.get(name, "").partition("/")
    return int(good), int(all_)


def _words(node: Element | None) -> str:
    return " ".join(((node.text if node is not None else "") or "").split())


def read_case(path: Path) -> Case:
    """Read a case. Errors with lines: E001-E006; E040 and the scene's own; E401 a request's id twice, or one without
    words; E402 a success condition that the scene or its library does not have."""
    root = parse_xml(read_bytes(path, "case"), str(path), schema=f"{__package__}:case")
    named = root.get("scene", "")
    beside = path.parent / named
    scene = load_scene(str(beside) if beside.suffix == ".xml" and beside.exists() else named)
    library = load_library(scene.library, beside=Path(scene.source).parent)
    domain = domain_of(library, to_semantic_map(scene))
    success = tuple(
        tuple(_condition(node, domain, str(path)) for node in alternative)
        for alternative in root.iterfind("Success/All")
    )
    return Case(
        root.get("name", ""),
        root.get("experiment", ""),
        scene,
        library,
        root.get("date", ""),
        _words(root.find("Description")),
        success,
        tuple(_requests(root, str(path))),
        str(path),
    )


def _requests(root: Element, source: str) -> Iterator[Request]:
    seen: set[str] = set()
    for node in root.iterfind("Requests/Request"):
        id_, text = node.get("id", ""), _words(node.find("Text"))
        if id_ in seen or not text:
            what = f"request {id_} is there twice" if id_ in seen else f"request {id_} says nothing"
            raise LlmbtError(Diagnostic("E401", what, Span(source, line_of(node))))
        seen.add(id_)
        reply = node.find("Reply")
        said = None if reply is None else reply.text or ""
        yield Request(id_, node.get("register", ""), text, said, _why(node), line_of(node))


def _why(node: Element) -> str:
    return "" if node.get("kind") == "clear" else " ".join(node.get("why", "").split()) or "unclear"


def _condition(node: Element, domain: Domain, source: str) -> Condition:
    """A condition as it stands in a tree: attributes by the names of its parameters."""

    def fault(title: str, word: str, known: tuple[str, ...]) -> LlmbtError:
        close = nearest(word, known)
        hint = f"did you mean {', '.join(close)}?" if close else f"known: {', '.join(known)}"
        return LlmbtError(Diagnostic("E402", title, Span(source, line_of(node)), help=hint, candidates=close))

    library = domain.library
    declared = library.conditions.get(str(node.tag))
    if declared is None:
        known = tuple(library.conditions)
        raise fault(f"library `{library.name}` has no condition `{node.tag}`", str(node.tag), known)
    names = tuple(p.name for p in declared.params)
    if set(node.attrib) != set(names):
        raise fault(f"`{node.tag}` takes {', '.join(names) or 'nothing'}", " ".join(map(str, node.attrib)), names)
    for param in declared.params:
        thing = node.get(param.name, "")
        if not domain.fits(thing, param.type):
            raise fault(f"the scene has no {param.type} `{thing}`", thing, domain.by_type.get(param.type, ()))
    return Condition(declared.name, tuple(node.get(n, "") for n in names))


def cassette_of(case: Case, request: Request) -> Path:
    """Where the recording of a request is: beside the shipped ones for a shipped case, else beside the case's file."""
    mine = Path(case.source)
    home = shipped("experiments")
    top = shipped("llm_cassettes") if home in mine.parents else mine.parent / "llm_cassettes"
    return top / case.experiment / case.name / f"{request.id}.yaml"
