"""A version of a run ticked again: the statuses of its nodes at each moment at which something began or ended.

The facts are those that the version's record holds, and then what the templates say of each action that succeeded, and
what was observed to be otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from llmbt.history import Event, Run, Stage
from llmbt_atl.library import load_library
from llmbt_atl.state import Domain, GroundAction, apply, domain_of
from llmbt_ir.condition import Facts, parse_condition
from llmbt_ir.scene import load_scene
from llmbt_ir.semantic_map import read_map
from llmbt_ir.tree import Tree
from llmbt_runtime.tick import NodeStatus, tick
from llmbt_runtime.update.rollout import perceived

__all__ = ["Moment", "domain_of_run", "moments", "statuses_at"]


@dataclass(frozen=True, slots=True)
class Moment:
    """A tick: when, what the conditions see, and the action that ended just before it with its result, if one did.

    `running` is the action node that runs from here on, None where none does.
    """

    time_s: float
    facts: Facts
    running: str | None = None
    ended: tuple[str, NodeStatus] | None = None


def domain_of_run(run: Run) -> Domain | None:
    """The run's library over its map; None where the folder does not tell which that is."""
    scene, map_file = run.result.get("scene"), run.folder / "map.xml"
    if not scene or not map_file.is_file():
        return None
    found = load_scene(str(scene))
    return domain_of(load_library(found.library, beside=Path(found.source).parent), read_map(map_file))


def moments(stage: Stage, domain: Domain | None) -> Iterator[Moment]:
    """The ticks of one version at which something began or ended, in order."""
    facts, tree = stage.state, stage.tree
    there = domain.for_state(facts) if domain else None
    running: str | None = None
    if facts:
        yield Moment(float(stage.record.get("sim_time_s", 0.0)), facts)
    for event in stage.events:
        if event.kind == "started" and event.details.get("node") in tree.nodes:
            running = str(event.details["node"])
            yield Moment(event.time_s, perceived(facts, _action(tree, running, there)), running)
        elif event.kind == "ended" and running is not None:
            action = _action(tree, running, there)
            result = str(event.details.get("result"))
            if result == "SUCCESS" and action is not None:
                facts = apply(action, facts)
            ended = NodeStatus(result) if result in ("SUCCESS", "FAILURE") else None
            yield Moment(event.time_s, facts, None, (running, ended) if ended else None)
            running = None
        elif event.kind == "deviation":
            facts = (facts - _facts(event, "ended")) | _facts(event, "began")
            seen = perceived(facts, _action(tree, running, there)) if running else facts
            yield Moment(event.time_s, seen, running)
        elif event.kind == "outcome":
            yield Moment(event.time_s, facts)


def _facts(event: Event, key: str) -> Facts:
    """What an event says began or ended."""
    return frozenset(c for t in event.details.get(key, ()) if (c := parse_condition(str(t))) is not None)


def _action(tree: Tree, node: str, domain: Domain | None) -> GroundAction | None:
    call = tree[node].action
    return domain.action(call) if domain is not None and call is not None else None


def statuses_at(tree: Tree, moment: Moment) -> Mapping[str, str]:
    """The status of every ticked node, by id."""
    record = tick(tree, moment.facts)
    if moment.running is not None and record.action != moment.running:
        return {moment.running: "RUNNING"} | dict.fromkeys(tree.ancestors(moment.running), "RUNNING")
    return {id_: status.value for id_, status in record.trace}
