"""BT Expansion (Cai, Li, Huang and Yang, "BT expansion: a sound and complete algorithm for behavior planning of
intelligent robots with behavior trees", AAAI 2021), redone whenever its tree fails.

Backwards from the goal: a set of literals is expanded by every action that brings one of them about and undoes none;
what must hold before is a new set, unless a known one is part of it. The tree is Fallback(G, Sequence(C_1, a_1), ...)
in the order found, until a set holds at present. Given here on top: sets that can never hold together, by the
invariants of the templates, are not looked at.
"""

from __future__ import annotations

from collections import defaultdict, deque
from dataclasses import dataclass, field
from itertools import product

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import Condition, Facts, Goals, all_hold
from llmbt_ir.tree import Kind, Node, Tree, node_id
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.tick import TickRecord

__all__ = ["ExpansionPolicy"]

Row = tuple[tuple[Condition, ...], GroundAction]


class _Sets:
    """Sets of literals, asked whether one of them is part of another: each is kept under its rarest literal."""

    def __init__(self) -> None:
        self._under: defaultdict[Condition, list[frozenset[Condition]]] = defaultdict(list)

    def add(self, conditions: frozenset[Condition]) -> None:
        rarest = min(conditions, key=lambda c: (len(self._under[c]), c))
        self._under[rarest].append(conditions)

    def covers(self, conditions: frozenset[Condition]) -> bool:
        return any(k <= conditions for c in conditions for k in self._under.get(c, ()))


@dataclass
class ExpansionPolicy:
    """Of several alternatives of the goals the first is pursued. `budget` counts sets that are expanded, over the whole
    run; a tree of more than `nodes` nodes is given up while it is made."""

    goals: Goals
    budget: int
    nodes: int
    planner_calls: int = 0
    expansions: int = 0
    mutexes: dict[tuple[Condition, Condition], bool] = field(default_factory=dict)

    def objects(self, _facts: Facts, _running: GroundAction | None) -> bool:
        """A tree is changed only where it fails."""
        return False

    def revise(self, _tree: Tree, domain: Domain, facts: Facts, _record: TickRecord) -> Tree | Ended:
        """A new tree from the present state."""
        self.planner_calls += 1
        goal = tuple(dict.fromkeys(self.goals[0]))
        rows: list[Row] = []
        nodes = len(goal) + 2
        known = _Sets()
        known.add(frozenset(goal))
        queue = deque([goal])
        while queue:
            wanted = queue.popleft()
            if self.expansions >= self.budget:
                return Ended(Outcome.BUDGET, f"no tree within {self.budget} expansions")
            self.expansions += 1
            for action in self._actions(wanted, domain):
                kept = tuple(c for c in wanted if not action.achieves(c))
                before = tuple(dict.fromkeys((*kept, *action.pre)))
                together = frozenset(before)
                if self._exclude(kept, action.pre, domain) or known.covers(together):
                    continue
                known.add(together)
                rows.append((before, action))
                nodes += len(before) + 2
                if nodes > self.nodes:
                    return Ended(Outcome.BUDGET, f"a tree of more than {self.nodes} nodes")
                if all_hold(before, facts):
                    return _written(goal, rows)
                queue.append(before)
        return Ended(Outcome.UNSOLVABLE, "everything is expanded", goal)

    @staticmethod
    def _actions(wanted: tuple[Condition, ...], domain: Domain) -> tuple[GroundAction, ...]:
        found = dict.fromkeys(a for c in wanted for a in domain.achievers(c))
        return tuple(a for a in found if not any(a.falsifies(c) for c in wanted))

    def _exclude(self, kept: tuple[Condition, ...], pre: tuple[Condition, ...], domain: Domain) -> bool:
        """Whether one of each can never hold together."""
        for pair in product(kept, pre):
            if pair not in self.mutexes:
                self.mutexes[pair] = domain.mutex(*pair)
            if self.mutexes[pair]:
                return True
        return False

    def ended(self, _action: GroundAction, _success: bool) -> None:
        """Nothing is remembered."""


def _written(goal: tuple[Condition, ...], rows: list[Row]) -> Tree:
    leaves = [Node(f"g{i}", Kind.CONDITION, condition=c) for i, c in enumerate(goal, 1)]
    top = Node("root", Kind.SEQUENCE, tuple(n.id for n in leaves))
    nodes, branches = [top, *leaves], [top.id]
    for number, (conditions, action) in enumerate(rows):
        chain = ("expansion", str(number), str(action))
        held = [Node(node_id("root", *chain, str(c)), Kind.CONDITION, condition=c) for c in conditions]
        act = Node(node_id("root", *chain, "!"), Kind.ACTION, action=action.call)
        row = Node(node_id("root", *chain), Kind.SEQUENCE, (*(n.id for n in held), act.id))
        nodes += [row, *held, act]
        branches.append(row.id)
    root = Node(node_id("root", "expansion", "?"), Kind.FALLBACK, tuple(branches))
    return Tree(root.id, {n.id: n for n in (root, *nodes)})
