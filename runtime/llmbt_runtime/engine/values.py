"""What each branch would come to if it were ticked anew, kept up to date at the cost of what changed.

Of a branch in which nothing runs, a tick is a function of the facts: it succeeds, it fails, or it comes to something
that has to be ticked for real (an action, a Delay, a Retry or Repeat that goes round). That is its value. A fact that
changes touches the conditions that look at it, and above them only those nodes whose value changes with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from heapq import heappop, heappush

from llmbt_runtime.engine.program import FALLBACKS, SEQUENCES, Op, Program
from llmbt_runtime.facts import Change
from llmbt_runtime.tick import NodeStatus

__all__ = ["FAILS", "NEEDS", "STATUS", "SUCCEEDS", "Values", "replay"]

SUCCEEDS, FAILS, NEEDS = 0, 1, 2
"""Values. NEEDS: something has to be ticked for real."""
STATUS = (NodeStatus.SUCCESS, NodeStatus.FAILURE)
NO_COMPOSITE = -1


class Values:
    """The values of a program's nodes; at first in the state in which nothing holds.

    `value[n]` is a node's; `stops[n]` has, for a composite, a bit for each child at which it would not go on; `go_on`
    holds the value at which it does. `evaluations` counts the conditions that were evaluated.
    """

    def __init__(self, program: Program, changed: Callable[[int], None] = lambda _: None) -> None:
        """`changed` hears of each composite one of whose children, given to it, has come to stop it."""
        self.program = program
        self.evaluations = 0
        self._changed = changed
        self._parents, self._ranks, self._readers = program.parents, program.ranks, program.readers
        nodes = program.nodes
        self.go_on = [SUCCEEDS if n.op in SEQUENCES else FAILS if n.op in FALLBACKS else NO_COMPOSITE for n in nodes]
        self.value = [NEEDS] * len(nodes)
        self.stops = [0] * len(nodes)
        self._touched = [False] * len(nodes)
        for n in range(len(nodes) - 1, -1, -1):
            node = nodes[n]
            if node.condition is not None:
                self.evaluations += 1
                self.value[n] = SUCCEEDS if node.condition.negated else FAILS
            elif self.go_on[n] != NO_COMPOSITE:
                go_on = self.go_on[n]
                self.stops[n] = int("".join("01"[self.value[c] != go_on] for c in reversed(node.children)), 2)
                self.value[n] = self._composite(n)
            else:
                self.value[n] = self._single(n)

    def learn(self, change: Change) -> None:
        """Bring the values up to date: each node that is touched is looked at once, children first."""
        nodes = self.program.nodes
        touched: list[int] = []
        for facts, holds in ((change.removed, FAILS), (change.added, SUCCEEDS)):
            for fact in facts:
                for leaf in self._readers.get(fact, ()):
                    self.evaluations += 1
                    condition = nodes[leaf].condition
                    assert condition is not None
                    self._set(leaf, 1 - holds if condition.negated else holds, touched)
        while touched:
            n = -heappop(touched)
            self._touched[n] = False
            self._set(n, self._single(n) if self.go_on[n] == NO_COMPOSITE else self._composite(n), touched)

    def first_stop(self, n: int) -> int:
        """The rank of the first child at which a composite would not go on; -1 where it goes on to its end."""
        stops = self.stops[n]
        return (stops & -stops).bit_length() - 1

    def next_stop(self, n: int, rank: int) -> int:
        """The same among the children after `rank`."""
        stops = self.stops[n] >> (rank + 1)
        return rank + (stops & -stops).bit_length() if stops else -1

    def wanted(self) -> int | None:
        """In a tree of composites, conditions and actions in which nothing runs: the action that a tick would start."""
        n = 0
        if self.value[0] != NEEDS:
            return None
        while self.go_on[n] != NO_COMPOSITE:
            n = self.program.nodes[n].children[self.first_stop(n)]
        return n

    def _set(self, n: int, value: int, touched: list[int]) -> None:
        """Change a value, and note its parent as touched if that makes a difference."""
        if self.value[n] == value:
            return
        self.value[n] = value
        parent = self._parents[n]
        if parent < 0:
            return
        go_on = self.go_on[parent]
        if go_on != NO_COMPOSITE:
            bit = 1 << self._ranks[n]
            if value == go_on:
                self.stops[parent] &= ~bit
            else:
                self.stops[parent] |= bit
                self._changed(parent)
        if not self._touched[parent]:
            self._touched[parent] = True
            heappush(touched, -parent)

    def _composite(self, n: int) -> int:
        rank = self.first_stop(n)
        return self.go_on[n] if rank < 0 else self.value[self.program.nodes[n].children[rank]]

    def _single(self, n: int) -> int:
        """The value of a decorator, or of a leaf that looks at no fact."""
        node = self.program.nodes[n]
        below = self.value[node.children[0]] if node.children else NEEDS
        match node.op:
            case Op.ALWAYS_SUCCESS:
                return SUCCEEDS
            case Op.ALWAYS_FAILURE:
                return FAILS
            case Op.INVERTER:
                return below if below == NEEDS else 1 - below
            case Op.FORCE_SUCCESS:
                return below if below == NEEDS else SUCCEEDS
            case Op.FORCE_FAILURE:
                return below if below == NEEDS else FAILS
            case Op.TIMEOUT:
                return below
            case Op.RETRY | Op.REPEAT:
                again = FAILS if node.op is Op.RETRY else SUCCEEDS
                if node.amount == 0 or node.amount < -1:
                    return again
                return NEEDS if below == again and node.amount != 1 else below
            case _:
                return NEEDS


def replay(values: Values, top: int) -> Iterator[tuple[int, NodeStatus]]:
    """The condition leaves that a tick of an idle branch would come to, in order, with what they return.

    Precondition: its value is not NEEDS.
    """
    nodes = values.program.nodes
    stack = [top]
    while stack:
        n = stack.pop()
        node = nodes[n]
        if node.condition is not None:
            yield n, STATUS[values.value[n]]
        elif values.go_on[n] != NO_COMPOSITE:
            stop = values.first_stop(n)
            stack.extend(reversed(node.children if stop < 0 else node.children[: stop + 1]))
        elif node.op not in (Op.RETRY, Op.REPEAT) or node.amount > 0 or node.amount == -1:
            stack.extend(node.children)
