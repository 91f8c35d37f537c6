"""Reading fixtures/requests."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from llmbt_ir.condition import Condition, parse_condition
from llmbt_ir.xml import parse_xml, read_bytes

__all__ = [
    "BLIND",
    "BLIND2",
    "BLIND3",
    "BLIND4",
    "BLIND5",
    "DEV",
    "DEV2",
    "DEV3",
    "FOLDER",
    "OTHERS",
    "Case",
    "Goals",
    "read_open",
]

FOLDER = Path(__file__).parents[2] / "fixtures" / "requests"
BLIND = FOLDER / "blind.jsonl"
BLIND2 = FOLDER / "blind2.jsonl"
BLIND3 = (FOLDER / "blind3a.jsonl", FOLDER / "blind3b.jsonl")
BLIND4 = (FOLDER / "blind4a.jsonl", FOLDER / "blind4b.jsonl")
BLIND5 = (FOLDER / "blind5a.jsonl", FOLDER / "blind5b.jsonl")
DEV = FOLDER / "dev.jsonl"
DEV2 = FOLDER / "dev2.jsonl"
DEV3 = FOLDER / "dev3.jsonl"
OTHERS = tuple(sorted((FOLDER / "scenes").glob("*.jsonl")))
"""Over scenes that others wrote, each beside its requests."""

Goals = frozenset[Condition]


@dataclass(frozen=True, slots=True)
class Case:
    """One request: its kind, the replies that a model is made to give, and what is right."""

    id: str
    scene: str
    kind: str
    text: str
    replies: tuple[str, ...]
    answers: tuple[str, ...]
    candidates: frozenset[str] | None
    goals: tuple[Goals, ...]
    why: str


def read_open() -> tuple[Case, ...]:
    """The requests that may be looked at. Every fault of the file is raised."""
    path = FOLDER / "open.xml"
    data = read_bytes(path, "requests")
    _check(data)
    root = parse_xml(data, str(path))
    found = tuple(_case(node) for node in root.iterfind("Request"))
    assert len({c.id for c in found}) == len(found), "an id is used twice"
    return found


def _check(data: bytes) -> None:
    from lxml import etree

    schema = etree.RelaxNG(etree.parse(str(FOLDER / "requests.rng")))
    schema.assertValid(etree.fromstring(data))


def _case(node: object) -> Case:
    from lxml.etree import _Element

    assert isinstance(node, _Element)
    candidates = node.findtext("Candidates")
    kind = str(node.get("kind"))
    goals = tuple(_goals(g.text or "") for g in node.iterfind("Goals"))
    assert goals or kind == "impossible", f"{node.get('id')}: what are the goals?"
    assert kind != "ambiguous" or node.find("Answer") is not None, f"{node.get('id')}: what is the answer?"
    return Case(
        str(node.get("id")),
        str(node.get("scene")),
        kind,
        " ".join((node.findtext("Text") or "").split()),
        tuple(_reply(r.text or "") for r in node.iterfind("Reply")),
        tuple(" ".join((a.text or "").split()) for a in node.iterfind("Answer")),
        frozenset(candidates.split()) if candidates is not None else None,
        goals,
        node.findtext("Why") or "",
    )


def _reply(text: str) -> str:
    """The lines of a reply, without the indentation that the file gives them."""
    return "\n".join(line.strip() for line in text.strip().splitlines()) + "\n"


def _goals(text: str) -> Goals:
    literals = [parse_condition(" ".join(part.split())) for part in text.split(";") if part.strip()]
    assert literals, "empty goals"
    assert None not in literals, text
    return frozenset(c for c in literals if c is not None)
