"""Certificates: a tree rolled out symbolically from a state, by the exact effects of the templates."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from llmbt_atl.state import Domain, GroundAction, applicable, apply
from llmbt_ir.condition import ActionCall, Facts, Goals, satisfied
from llmbt_ir.tree import Tree
from llmbt_runtime.tick import NodeStatus, TickRecord, tick

__all__ = ["Certificate", "Stuck", "StuckKind", "perceived", "rollout"]


@dataclass(frozen=True, slots=True)
class Certificate:
    """Why a tree will work: from `states[0]` it runs `actions` one after another, and after the last the goals hold.

    `states[k]` is the predicted state before `actions[k]`, which node `nodes[k]` runs; no state occurs twice.
    """

    actions: tuple[GroundAction, ...]
    states: tuple[Facts, ...]
    nodes: tuple[str, ...]


class StuckKind(StrEnum):
    """How a rollout can end short of the goal."""

    FAILED = "a condition fails that no action in the tree brings about"
    LOOP = "the same state comes twice"
    EXCLUDED = "it needs an action that is excluded for now"
    INAPPLICABLE = "it runs an action whose precondition does not hold"
    UNSTABLE = "it halts an action that is under way"
    GOAL = "it returns success while a goal does not hold"


@dataclass(frozen=True, slots=True)
class Stuck:
    """Where a rollout ended: the state, the tick's record, and the actions that led there."""

    kind: StuckKind
    facts: Facts
    record: TickRecord
    actions: tuple[GroundAction, ...]


def perceived(observed: Facts, action: GroundAction | None) -> Facts:
    """What the conditions of a tree see while an action runs: its start-conditions as they were when it started.

    They are looked at when the action starts and not again until it ends or is halted.
    """
    if action is None:
        return observed
    kept = {c for c in action.start if not c.negated}
    dropped = {c.fact for c in action.start if c.negated}
    return (observed | kept) - dropped


def ending(action: GroundAction, facts: Facts) -> Facts:
    """What of a state may end at any moment while an action runs, so that neither it nor its negation can be relied
    on: what it deletes but for its own preconditions. What it adds is not yet there."""
    return (action.deletes & facts) - {c for c in action.pre if not c.negated}


def rollout(
    tree: Tree,
    domain: Domain,
    facts: Facts,
    goals: Goals,
    *,
    excluded: frozenset[ActionCall] = frozenset(),
    limit: int = 10_000,
) -> Certificate | Stuck:
    """Run a tree in the symbolic world from a state until it returns success with the goals holding.

    Every action is checked to be applicable, not excluded, and not halted by the tree while it is under way. Ends:
    a loop of the state is found at its first repeat, so the rollout ends for every tree.
    """
    state, seen = facts, {facts}
    actions: list[GroundAction] = []
    states, nodes = [facts], list[str]()
    while True:
        record = tick(tree, state)
        if record.status is NodeStatus.SUCCESS:
            if satisfied(goals, state):
                return Certificate(tuple(actions), tuple(states), tuple(nodes))
            return Stuck(StuckKind.GOAL, state, record, tuple(actions))
        if record.status is NodeStatus.FAILURE or record.action is None:
            return Stuck(StuckKind.FAILED, state, record, tuple(actions))
        call = tree[record.action].action
        assert call is not None
        action = domain.action(call)
        if action is None or not applicable(action, state):
            return Stuck(StuckKind.INAPPLICABLE, state, record, tuple(actions))
        if call in excluded:
            return Stuck(StuckKind.EXCLUDED, state, record, tuple(actions))
        unsure = ending(action, state)
        if unsure and tick(tree, state, ending=unsure).action != record.action:
            return Stuck(StuckKind.UNSTABLE, state, record, tuple(actions))
        state = apply(action, state)
        actions.append(action)
        states.append(state)
        nodes.append(record.action)
        if state in seen or len(actions) > limit:
            return Stuck(StuckKind.LOOP, state, record, tuple(actions))
        seen.add(state)
