"""Runs in a process of its own: ticks trees in the real BehaviorTree.CPP and tells what it did.

Standard input: JSON [{"xml": ..., "conditions": [names], "actions": [names], "ticks": [{"holds": [ids], "reports":
{id: status}}]}]. Standard output: for each case {"error": ...} or {"ticks": [{"status": ..., "events": [...]}]}, where
an event is [verb, id, status] with the verb tick, start, run or halt.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import behaviortreepy as bt

STATUS = {s.name: s for s in (bt.NodeStatus.SUCCESS, bt.NodeStatus.FAILURE, bt.NodeStatus.RUNNING)}


def run(case: dict[str, Any]) -> dict[str, Any]:
    """One case. Leaves are told apart by their instance name, which is the node's id."""
    events: list[list[str]] = []
    now: dict[str, Any] = {"holds": [], "reports": {}}

    def condition(node: Any) -> Any:
        status = "SUCCESS" if node.name() in now["holds"] else "FAILURE"
        events.append(["tick", node.name(), status])
        return STATUS[status]

    def action(verb: str, node: Any) -> Any:
        status = now["reports"].get(node.name(), "RUNNING")
        events.append([verb, node.name(), status])
        return STATUS[status]

    factory = bt.BehaviorTreeFactory()
    for name in case["conditions"]:
        factory.register_simple_condition(name, condition)
    for name in case["actions"]:
        factory.register_simple_stateful_action(
            name,
            lambda node: action("start", node),
            lambda node: action("run", node),
            lambda node: events.append(["halt", node.name(), ""]),
        )
    try:
        tree = factory.create_tree_from_text(case["xml"])
    except Exception as fault:
        return {"error": str(fault)}
    told = []
    for tick in case["ticks"]:
        now.update(tick)
        status = tree.tick_exactly_once()
        told.append({"status": status.name, "events": list(events)})
        events.clear()
    tree.halt_tree()
    return {"ticks": told}


if __name__ == "__main__":
    print("\n" + json.dumps([run(case) for case in json.load(sys.stdin)]))
