"""Runs in a process of its own: ticks cases in the real BehaviorTree.CPP and tells what it did.

Standard input: JSON {"unit_ms", "once", "cases": [{"xml", "facts": [[names]], "answers": {leaf: [statuses]}}]}. All
cases are ticked side by side, tick k at k times the unit, since BehaviorTree.CPP's timers go by the wall clock.
Standard output: {"late_ms": by how much the last of them was ticked too late, "told": for each case, for each tick
[status, [[verb, leaf, status]]] and at the end ["", what halting the tree brought about], or {"error"}}.
"""

from __future__ import annotations

import json
import re
import sys
import time
from typing import Any

import behaviortreepy as bt

STATUS = {s.name: s for s in (bt.NodeStatus.SUCCESS, bt.NodeStatus.FAILURE, bt.NodeStatus.RUNNING)}
LEAF = re.compile(r'<(?:(?:Action|Condition) ID="(\w+)"|([Pa]\d+)) name=')


class Running:
    """One case with its tree. Leaves are told apart by their instance name."""

    def __init__(self, case: dict[str, Any]) -> None:
        self.facts, self.answers = case["facts"], case["answers"]
        self.holds: set[str] = set()
        self.asked = dict.fromkeys(self.answers, 0)
        self.events: list[list[str]] = []
        self.told: list[Any] = []
        self.factory = bt.BehaviorTreeFactory()
        for tag in sorted({a or b for a, b in LEAF.findall(case["xml"])}):
            if tag[0] == "P":
                self.factory.register_simple_condition(tag, lambda node, tag=tag: self.condition(node, tag))
            else:
                self.factory.register_simple_stateful_action(
                    tag,
                    lambda node: self.action("start", node),
                    lambda node: self.action("run", node),
                    lambda node: self.events.append(["halt", node.name(), ""]),
                )
        self.tree = self.factory.create_tree_from_text(case["xml"])

    def condition(self, node: Any, tag: str) -> Any:
        status = "SUCCESS" if tag in self.holds else "FAILURE"
        self.events.append(["tick", node.name(), status])
        return STATUS[status]

    def action(self, verb: str, node: Any) -> Any:
        name = node.name()
        row = self.answers[name]
        status = row[self.asked[name] % len(row)]
        self.asked[name] += 1
        self.events.append([verb, name, status])
        return STATUS[status]

    def tick(self, k: int, *, once: bool) -> None:
        self.holds = set(self.facts[k])
        status = self.tree.tick_once() if once else self.tree.tick_exactly_once()
        self.tell(status.name)

    def halt(self) -> None:
        self.tree.halt_tree()
        self.tell("")

    def tell(self, status: str) -> None:
        self.told.append([status, self.events[:]])
        self.events.clear()


def main() -> None:
    given = json.load(sys.stdin)
    unit_s = given["unit_ms"] / 1000
    running: list[Any] = []
    for case in given["cases"]:
        try:
            running.append(Running(case))
        except Exception as fault:
            running.append({"error": str(fault)})
    trees = [r for r in running if isinstance(r, Running)]
    start, late = time.monotonic(), 0.0
    for k in range(max((len(r.facts) for r in trees), default=0)):
        time.sleep(max(0.0, start + k * unit_s - time.monotonic()))
        for r in trees:
            if k < len(r.facts):
                r.tick(k, once=given["once"])
        late = max(late, time.monotonic() - start - k * unit_s)
    for r in trees:
        r.halt()
    told = [r.told if isinstance(r, Running) else r for r in running]
    print("\n" + json.dumps({"late_ms": 1000 * late, "told": told}))


if __name__ == "__main__":
    main()
