"""A plan as rows: the goal regressed through the plan (triangle tables, Fikes, Hart and Nilsson 1972; teleo-reactive
programs, Nilsson 1994), written with as few nodes as nesting what rows have in common allows.

A row is what must hold for the rest of the plan to work, and the plan's next action; of the rows that hold the one
nearest the goals acts. What a literal is needed for lies together, so it stands in consecutive rows: rows side by side
are put into a group, Sequence(what all of them need, Fallback(the rows without it)), and groups into groups, wherever
that saves nodes. It changes neither what the tree returns nor which action it ticks.
"""

from __future__ import annotations

from dataclasses import replace
from hashlib import blake2s

from llmbt_atl.state import GroundAction
from llmbt_ir.condition import Condition
from llmbt_ir.tree import Kind, Node, Tree, node_id

__all__ = ["chain_tree", "regress"]

CUTS = 16
"""Of the places at which a group can be divided, so many are tried."""


def regress(goals: tuple[Condition, ...], plan: tuple[GroundAction, ...]) -> tuple[tuple[Condition, ...], ...]:
    """The rows of a chain: R_n = G, R_(i-1) = (R_i - add(a_i)) + pre(a_i); rows[i] is what must hold before a_(i+1).

    Holds afterwards: from any state with rows[i], actions i+1 to n reach the goals.
    """
    rows = [tuple(dict.fromkeys(goals))]
    for action in reversed(plan):
        kept = [c for c in rows[0] if not action.achieves(c)]
        rows.insert(0, tuple(dict.fromkeys((*action.pre, *kept))))
    return tuple(rows)


def chain_tree(goals: tuple[Condition, ...], plan: tuple[GroundAction, ...], first: int = 1) -> Tree:
    """Fallback(Sequence(G), the rows from the last to the first, grouped).

    The goals are `g<first>` and on: the ids that they have in the initial tree. The ids of a row or group begin with
    that of the goal that is the next to be reached for good, or with `root` where it leads to several.
    """
    rows = regress(goals, plan)
    leaves = [Node(f"g{i}", Kind.CONDITION, condition=c) for i, c in enumerate(rows[-1], first)]
    top = Node("root", Kind.SEQUENCE, tuple(n.id for n in leaves))
    root = node_id("root", "chain", *(str(a) for a in plan), "?")
    nodes = _written(rows, plan, _towards(rows[-1], plan, first), Node(root, Kind.FALLBACK, (top.id,)))
    return Tree(root, {n.id: n for n in (top, *leaves, *nodes)})


def _towards(goals: tuple[Condition, ...], plan: tuple[GroundAction, ...], first: int) -> list[str]:
    """For each action the id of the goal that is the next to be reached for good."""
    reached: dict[int, str] = {}
    for i, goal in enumerate(goals, first):
        reached.setdefault(max((k for k, a in enumerate(plan) if a.achieves(goal)), default=-1), f"g{i}")
    found = ["root"]
    for k in range(len(plan) - 1, -1, -1):
        found.append(reached.get(k, found[-1]))
    return found[:0:-1]


def _written(
    rows: tuple[tuple[Condition, ...], ...], plan: tuple[GroundAction, ...], towards: list[str], root: Node
) -> list[Node]:
    """The root with all rows added to its children, and their nodes."""
    rest = [b""]
    for action in reversed(plan):
        rest.append(blake2s(rest[-1] + str(action).encode()).digest())
    rest.reverse()

    def id_(low: int, high: int, *what: str) -> str:
        goal = towards[low] if low <= high and towards[low] == towards[high] else "root"
        return node_id(goal, "chain", rest[low].hex(), str(high - low), *what)

    def leaves(low: int, high: int, literals: frozenset[Condition]) -> list[Node]:
        return [Node(id_(low, high, str(c)), Kind.CONDITION, condition=c) for c in rows[low] if c in literals]

    groups = _Groups([frozenset(r) for r in rows[:-1]])
    nodes: list[Node] = []
    nothing: frozenset[Condition] = frozenset()
    open_ = [(root, groups.parts(0, len(plan) - 1, 0), nothing)]
    while open_:
        fallback, parts, given = open_.pop()
        children = fallback.children
        for low, high, together in parts:
            if together:
                common = groups.common(low, high)
                front, inner = leaves(low, high, common - given), Node(id_(low, high, "?"), Kind.FALLBACK)
                group = Node(id_(low, high), Kind.SEQUENCE, (*(n.id for n in front), inner.id))
                nodes += [group, *front]
                children += (group.id,)
                open_.append((inner, groups.parts(low, high), common))
                continue
            for i in range(high, low - 1, -1):
                front = leaves(i, i, frozenset(rows[i]) - given)
                act = Node(id_(i, i, "!"), Kind.ACTION, action=plan[i].call)
                row = Node(id_(i, i), Kind.SEQUENCE, (*(n.id for n in front), act.id))
                nodes += [row, *front, act]
                children += (row.id,)
        nodes.append(replace(fallback, children=children))
    return nodes


_Part = tuple[int, int, bool]
"""Rows from one to another, and whether they are written as a group or each for itself."""


class _Groups:
    """Which rows to put into a group: the fewest nodes, by dynamic programming over stretches of rows."""

    def __init__(self, rows: list[frozenset[Condition]]) -> None:
        n = len(rows)
        self.shared: list[list[frozenset[Condition]]] = [[] for _ in rows]
        self.size = [[0] * n for _ in rows]
        self.cut = [[-1] * n for _ in rows]
        self.single = [0]
        for row in rows:
            self.single.append(self.single[-1] + 2 + len(row))
        for low in range(n - 1, -1, -1):
            shared = rows[low]
            for high in range(low, n):
                shared = shared & rows[high]
                self.shared[low].append(shared)
                self._divide(low, high)

    def common(self, low: int, high: int) -> frozenset[Condition]:
        """What all rows of a stretch need."""
        return self.shared[low][high - low]

    def _alone(self, low: int, high: int, given: int) -> int:
        return self.single[high + 1] - self.single[low] - (high - low + 1) * given

    def _form(self, low: int, high: int, given: int) -> tuple[int, bool]:
        """The nodes of a stretch as a part of one whose rows have `given` literals in common, and whether it stays
        together."""
        more = len(self.common(low, high)) - given
        together = self.size[low][high] + (2 + more if more else 0)
        return min((self._alone(low, high, given), False), (together, low < high))

    def _divide(self, low: int, high: int) -> None:
        given = len(self.common(low, high))
        best, at = self._alone(low, high, given), -1
        for k in range(low, high, max(1, (high - low) // CUTS)):
            size = self._form(low, k, given)[0] + self._form(k + 1, high, given)[0]
            if size < best:
                best, at = size, k
        self.size[low][high], self.cut[low][high] = best, at

    def parts(self, low: int, high: int, given: int | None = None) -> list[_Part]:
        """How a stretch is written, the rows nearest the goals first, behind what all its rows need (or behind that
        many literals)."""
        if given is None:
            given = len(self.common(low, high))
        elif not self._form(low, high, given)[1]:
            return [(low, high, False)]
        elif len(self.common(low, high)) > given:
            return [(low, high, True)]
        at = self.cut[low][high]
        if at < 0:
            return [(low, high, False)]
        return [*self.parts(at + 1, high, given), *self.parts(low, at, given)]
