"""Requests as JSON lines, one object a line: what somebody writes who has seen the scenes and not the code.

Fields: `id`, `scene` (a shipped one, or a file beside this one), `kind` (complete, unclear, impossible), `request`,
`reply` (what the model says), `answer` and `reply_after_answer` (unclear ones), `candidates` (ids; an empty list is not
checked), `goals` (conditions as text, or as `["On", "object_1", "position_11"]`, all of them wanted; a list of lists of
texts, or `{"any": [...]}`, where several are equally right), `why`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any

from llmbt_ir.condition import parse_condition
from tests.requests.cases import Case, Goals

__all__ = ["read_blind"]

_KINDS = {"complete": "complete", "unclear": "ambiguous", "ambiguous": "ambiguous", "impossible": "impossible"}


def read_blind(path: Path) -> tuple[Case, ...]:
    """The requests of a file; ValueError, with the line's number and none of its words, for one that cannot be read."""
    found = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if line.strip():
            try:
                found.append(_case(json.loads(line), path.parent))
            except (ValueError, KeyError, TypeError, AttributeError) as fault:
                raise ValueError(f"line {number}: {type(fault).__name__}") from None
    return tuple(found)


def _case(row: Mapping[str, Any], beside: Path) -> Case:
    kind = _KINDS[row["kind"]]
    replies = (row["reply"], row.get("reply_after_answer"))
    answers = row.get("answer")
    return Case(
        str(row["id"]),
        str(beside / row["scene"]) if row["scene"].endswith(".xml") else row["scene"],
        kind,
        row["request"],
        tuple(r for r in replies if r),
        tuple(answers) if isinstance(answers, list) else ((answers,) if answers else ()),
        frozenset(row.get("candidates") or ()) or None,
        tuple(_alternatives(row.get("goals") or ())),
        str(row.get("why") or row.get("note") or ""),
    )


def _alternatives(goals: Any) -> Iterator[Goals]:
    """Every set of goals that is right: texts are all wanted, of a list or an `any` among them one member is."""
    if isinstance(goals, Mapping):
        for member in goals["any"]:
            yield from _alternatives(member)
    elif isinstance(goals, str):
        yield frozenset(_literal(part) for part in goals.split(";") if part.strip())
    elif _in_parts(goals):
        yield frozenset({_literal(f"{goals[0]}({', '.join(goals[1:])})")})
    elif goals and all(isinstance(g, list) and not _in_parts(g) for g in goals):
        for member in goals:
            yield from _alternatives(member)
    elif goals:
        parts = [tuple(_alternatives({"any": g} if isinstance(g, list) and not _in_parts(g) else g)) for g in goals]
        for chosen in product(*parts):
            yield frozenset[Any]().union(*chosen)


def _in_parts(goals: Any) -> bool:
    """Whether a list is one condition: its name and its arguments."""
    return isinstance(goals, list) and bool(goals) and all(isinstance(g, str) and "(" not in g for g in goals)


def _literal(text: str) -> Any:
    literal = parse_condition(" ".join(text.split()))
    if literal is None:
        raise ValueError("no condition")
    return literal
