"""Where a node is from, in words and as data: back to the words that asked for it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from llmbt.history import Link, Run
from llmbt.story import BOLD, FAINT, Paint, alternatives, row
from llmbt_ir.condition import parse_condition

__all__ = ["link_lines", "why_document", "why_lines"]


def why_lines(run: Run, chain: Sequence[Link], paint: Paint) -> Iterator[str]:
    """A node's chain, from itself back to the words that asked for it."""
    for k, link in enumerate(chain):
        lead = "because of  " if k else ""
        yield f"{lead}{paint(link.label, BOLD)}   {paint(link.node, FAINT)}"
        yield from link_lines(run, link)
    yield from _words(run, chain[-1])


def link_lines(run: Run, link: Link) -> Iterator[str]:
    """What one link says of its node."""
    yield row("it is", link.role)
    if link.version:
        record = run.stage(link.version).record
        if record.get("parent") is None:
            yield row("since", f"{link.version}, the tree that was {'compiled' if run.request else 'given'}")
        else:
            cause = record.get("cause")
            yield row("since", f"{link.version}, tick {record.get('tick')}, {record.get('sim_time_s')} s: {cause}")
    if link.step:
        yield row(str(link.step.get("kind")), str(link.step.get("reason") or ""))
        others = alternatives(link.step, 4)
        if others:
            yield row("rather than", others)
    for version, step in link.moves:
        record = run.stage(version).record
        yield row("moved", f"{version}, tick {record.get('tick')}, {record.get('sim_time_s')} s: {step.get('reason')}")


def _asked(run: Run, link: Link) -> dict[str, Any]:
    """The words of request and reply that a goal comes from; empty where the folder does not tell."""
    record = next((g for g in run.stages[0].file.provenance.goals if str(g.condition) == link.label), None)
    if record is None:
        return {}
    found: dict[str, Any] = {"goal": record.node, "words": record.words, "request": run.request}
    goal = next((g for g in run.goals if _is(g, link.label)), None)
    if goal is not None:
        step = next((s for s in run.steps if s.get("number") == goal.get("step")), {})
        found |= {"words": goal.get("words"), "step": goal.get("step"), "step_text": step.get("text")}
        text, span = str(run.reply.get("text", "")), goal.get("reply")
        if span and text:
            start = span[0]
            found["reply_span"] = list(span)
            found["reply_line"] = text.count("\n", 0, start) + 1
            found["reply_column"] = start - (text.rfind("\n", 0, start) + 1) + 1
            found["reply_text"] = text[span[0] : span[1]]
            found["reply_line_text"] = text.splitlines()[found["reply_line"] - 1]
    return {k: v for k, v in found.items() if v not in (None, "")}


def _is(goal: Mapping[str, Any], label: str) -> bool:
    condition = parse_condition(label)
    if condition is None:
        return False
    same = goal.get("name") == condition.name and tuple(goal.get("args", ())) == condition.args
    return same and bool(goal.get("negated")) == condition.negated


def _words(run: Run, link: Link) -> Iterator[str]:
    asked = _asked(run, link)
    if not asked.keys() - {"goal"}:
        return
    yield "asked for by"
    if "reply_line" in asked:
        yield row("reply", f"line {asked['reply_line']}: {asked['reply_line_text']}")
        said = min(len(asked["reply_text"]), len(asked["reply_line_text"]) - asked["reply_column"] + 1)
        lead = len(f"line {asked['reply_line']}: ") + asked["reply_column"] - 1
        yield row("", " " * lead + "^" * max(1, said))
    elif asked.get("words"):
        yield row("words", str(asked["words"]))
    if asked.get("request"):
        yield row("request", str(asked["request"]))


def why_document(run: Run, chains: Sequence[Sequence[Link]]) -> dict[str, Any]:
    """The chains as data."""
    return {
        "chains": [
            {
                "links": [
                    {
                        "node": link.node,
                        "label": link.label,
                        "role": link.role,
                        "version": link.version,
                        "step": dict(link.step) if link.step else None,
                        "moves": [{"version": version, "step": dict(step)} for version, step in link.moves],
                    }
                    for link in chain
                ],
                "asked_for_by": _asked(run, chain[-1]),
            }
            for chain in chains
        ]
    }
