"""What an execution leaves in its folder: the tree versions with why, the story, and `result.json`."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from llmbt_atl.library import Library
from llmbt_ir.condition import Condition
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree_xml import GoalRecord, Provenance, write_tree
from llmbt_ir.versions import VersionStore, sha256, version_name, write_atomic
from llmbt_runtime.executor import Change
from llmbt_runtime.outcome import Happening, Result
from llmbt_runtime.update.step import Step
from llmbt_runtime.world import World

__all__ = ["RunFolder", "result_document", "signatures_of", "write_result"]


def signatures_of(library: Library) -> Signatures:
    """The leaves of a library, for reading and writing trees."""
    return Signatures(
        {c.name: tuple(p.name for p in c.params) for c in library.conditions.values()},
        {t.name: tuple(p.name for p in t.params) for t in library.templates.values()},
    )


@dataclass
class RunFolder:
    """Writes the versions of one execution. `goals` are the provenance's goals, carried from version to version."""

    folder: Path
    signatures: Signatures
    goals: tuple[GoalRecord, ...]
    number: int
    parent_sha256: str
    parent_file: str

    def keep(self, change: Change) -> str:
        """Store a changed tree as the next version, whole on the disk before this returns; its name."""
        self.number += 1
        name = version_name(self.number)
        certificate = change.grown.certificate
        record = {
            "parent": self.parent_file,
            "parent_sha256": self.parent_sha256,
            "tick": change.tick,
            "sim_time_s": round(change.time_s, 3),
            "cause": change.cause,
            "observed": {"began": _texts(change.began), "ended": _texts(change.ended)},
            "failed_condition": _failed(change.grown.steps),
            "steps": [_step_record(s) for s in change.grown.steps],
            "planner": {"calls": change.planner_calls, "expansions": change.expansions},
            "nodes": len(change.grown.tree),
            "certificate": {
                "actions": [str(a) for a in certificate.actions],
                "state": _texts(change.facts),
            },
        }
        xml = write_tree(change.grown.tree, self.signatures, self._provenance(name, change))
        VersionStore(self.folder).append(xml, record, self.number)
        self.parent_sha256, self.parent_file = sha256(xml), f"tree.{name}.xml"
        return name

    def _provenance(self, name: str, change: Change) -> Provenance:
        entries: list[tuple[str, tuple[tuple[str, str], ...]]] = [
            (
                "Update",
                (("tick", str(change.tick)), ("sim_time_s", f"{change.time_s:.1f}"), ("cause", change.cause)),
            )
        ]
        for step in change.grown.steps:
            pairs = [("kind", step.kind), ("node", step.node)]
            pairs += [("condition", step.condition)] if step.condition else []
            pairs += [("action", step.action)] if step.action else []
            pairs += [("before", step.before)] if step.before else []
            pairs += [("alternatives", "; ".join(step.alternatives))] if step.alternatives else []
            entries.append(("Step", tuple(pairs)))
        actions = "; ".join(str(a) for a in change.grown.certificate.actions)
        entries.append(("Certificate", (("actions", actions),)))
        return Provenance(name, self.parent_sha256, self.goals, tuple(entries))

    def tell(self, happening: Happening) -> None:
        """Add a line of the story to `events.jsonl`, in one write."""
        line = {"kind": happening.kind, "sim_time_s": round(happening.time_s, 3), "text": happening.text}
        whole = json.dumps({**line, **happening.details}, ensure_ascii=False) + "\n"
        with (self.folder / "events.jsonl").open("ab", buffering=0) as out:
            out.write(whole.encode())


def _texts(facts: frozenset[Condition]) -> list[str]:
    return [str(f) for f in sorted(facts)]


def _failed(steps: tuple[Step, ...]) -> str:
    return next((s.condition for s in steps if s.condition), "")


def _step_record(step: Step) -> dict[str, Any]:
    record: dict[str, Any] = {
        "kind": step.kind,
        "node": step.node,
        "condition": step.condition,
        "action": step.action,
    }
    if step.before:
        record["before"] = step.before
    if step.alternatives:
        record["alternatives"] = list(step.alternatives)
        record["at_once"] = step.at_once
    record["reason"] = step.reason
    return record


def result_document(
    result: Result,
    world: World | None,
    *,
    versions: int,
    seed: int,
    wall_time_s: float,
    extra: Mapping[str, Any],
    names: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """`result.json`: only `wall_time_s` may differ between equal runs. `names` gives a template's name elsewhere."""
    objects = world.objects() if world else {}
    places = world.places() if world else {}
    document: dict[str, Any] = {
        "schema_version": 1,
        "outcome": result.outcome.value,
        "goals": [_goal(*entry) for entry in result.goals],
        "updates": result.updates,
        "versions": versions,
        "ticks": result.ticks,
        "planner_calls": result.planner_calls,
        "expansions": result.expansions,
        "sim_time_s": round(result.sim_time_s, 3),
        "wall_time_s": round(wall_time_s, 3),
        "seed": seed,
        "disturbances": [
            {
                "name": d.name,
                "target": d.target,
                "fired_at_s": round(d.fired_at_s, 3),
                "broke": [str(c) for c in d.broke],
                "recovered_at_s": None if d.recovered_at_s is None else round(d.recovered_at_s, 3),
            }
            for d in (world.disturbances() if world else ())
        ],
        "actions": [
            {
                "name": (names or {}).get(e.call.name, e.call.name),
                **({"template": e.call.name} if names else {}),
                "args": list(e.call.args),
                "result": e.result,
                "reason": e.reason,
                "started_s": round(e.started_s, 3),
                "ended_s": round(e.ended_s, 3),
            }
            for e in result.actions
        ],
        "objects": {k: {"xyz_m": [round(v, 5) for v in xyz]} for k, xyz in sorted(objects.items())},
        "places": {k: {"xyz_m": [round(v, 5) for v in xyz]} for k, xyz in sorted(places.items())},
    }
    if result.reason:
        document["reason"] = result.reason
    if result.unsolvable:
        document["unsolvable_goals"] = [str(c) for c in result.unsolvable]
    document.update(extra)
    return document


def _goal(goal: Condition, alternative: int, holds: bool) -> dict[str, Any]:
    record: dict[str, Any] = {"name": goal.name, "args": list(goal.args), "holds": holds}
    if goal.negated:
        record["negated"] = True
    if alternative > 1:
        record["alternative"] = alternative
    return record


def write_result(folder: Path, document: Mapping[str, Any]) -> None:
    """Write `result.json`, whole or not at all."""
    write_atomic(folder / "result.json", (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode())
