"""Schedules of disturbances that a person writes (`--disturb FILE`; docs/world.md explains the attributes)."""

from __future__ import annotations

from collections.abc import Container
from pathlib import Path

from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span, nearest
from llmbt_ir.xml import Element, line_of, parse_xml, read_bytes
from llmbt_runtime.disturbance import NAMES, DisturbanceSpec, When

__all__ = ["parse_schedule", "read_schedule"]


def read_schedule(
    path: Path, known: Container[str] | None = None, actions: Container[str] | None = None
) -> tuple[DisturbanceSpec, ...]:
    """Read a schedule; errors as `parse_schedule`, and E001, E002 where it cannot be read."""
    return parse_schedule(read_bytes(path, "disturbances"), str(path), known, actions)


def parse_schedule(
    data: bytes,
    source: str = "disturbances.xml",
    known: Container[str] | None = None,
    actions: Container[str] | None = None,
) -> tuple[DisturbanceSpec, ...]:
    """The disturbances of a schedule, in its order.

    `known` are the ids that a target may be, `actions` the templates that one may come after. Errors, with the line:
    E003-E006 as XML, E061 an unknown disturbance, E066 an unknown target or action.
    """
    root = parse_xml(data, source, schema="llmbt_runtime:disturbances")
    faults: list[Diagnostic] = []
    found = []
    for node in root.iterfind("Disturbance"):
        name, span = node.get("name"), Span(source, line_of(node))
        if name is None:
            faults.append(Diagnostic("E006", "<Disturbance> lacks the attribute `name`", span))
            continue
        if name not in NAMES:
            close = nearest(name, NAMES)
            hint = f"did you mean {', '.join(close)}?" if close else f"known: {', '.join(NAMES)}"
            faults.append(Diagnostic("E061", f"unknown disturbance `{name}`", span, help=hint, candidates=close))
        for what, of in (("target", known), ("after", actions)):
            value = node.get(what)
            if value is not None and of is not None and value not in of:
                faults.append(Diagnostic("E066", f"`{name}`: there is no `{value}` to be {what}", span))
        found.append(DisturbanceSpec(name, node.get("target"), _when(node)))
    if faults:
        raise LlmbtError(*faults)
    return tuple(found)


def _when(node: Element) -> When | None:
    if not any(node.get(a) for a in ("time_s", "grasp", "transfer", "after")):
        return None
    return When(
        float(node.get("time_s", "0")),
        int(node.get("grasp", "0")),
        float(node.get("transfer", "0")),
        node.get("after", ""),
        int(node.get("count", "1")),
    )
