"""What a tree is shown of a world, and how that differs from what is expected, at the cost of what changed.

The tree's conditions see the start-conditions of the running action as they were when it started (`rollout.perceived`,
which this keeps up to date). What is expected is a state of the certificate.
"""

from __future__ import annotations

from llmbt_atl.state import GroundAction
from llmbt_ir.condition import Condition, Facts
from llmbt_runtime.facts import NO_CHANGE, FactBase
from llmbt_runtime.world import World

__all__ = ["View"]


class View:
    """Reads a world's changes, which nobody else may do meanwhile.

    `shown` is what the tree's conditions see, as of the last `look`; its own changes are for the ticker to take.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        world.changes()
        self._observed = set(world.observe())
        self.shown = FactBase(self._observed)
        self._kept: Facts = frozenset()
        self._dropped: Facts = frozenset()
        self._expected: Facts | None = None
        self._since: dict[Condition, bool] = {}
        self._off: set[Condition] = set()

    # -- what is shown ------------------------------------------------------------------------------------------------

    def look(self) -> FactBase:
        """Take in what changed in the world since the last look."""
        change = self._world.changes()
        if change is not NO_CHANGE:
            self._observed -= change.removed
            self._observed |= change.added
            for fact in (*change.removed, *change.added):
                self._show(fact)
        return self.shown

    @property
    def facts(self) -> Facts:
        """All that is shown, at the cost of a copy where something has changed."""
        return self.shown.facts

    def runs(self, action: GroundAction | None) -> None:
        """From now on this action runs, or none does."""
        touched = self._kept | self._dropped
        start = action.start if action is not None else ()
        self._kept = frozenset(c for c in start if not c.negated)
        self._dropped = frozenset(c.fact for c in start if c.negated)
        for fact in touched | self._kept | self._dropped:
            self._show(fact)

    def _show(self, fact: Condition) -> None:
        holds = (fact in self._observed or fact in self._kept) and fact not in self._dropped
        (self.shown.add if holds else self.shown.remove)(fact)
        self._compare(fact)

    # -- what is expected ---------------------------------------------------------------------------------------------

    @property
    def expects(self) -> bool:
        """Whether anything has been expected yet."""
        return self._expected is not None

    @property
    def began(self) -> Facts:
        """What is shown, and is not expected; nothing where nothing is."""
        return frozenset(f for f in self._off if f in self.shown)

    @property
    def ended(self) -> Facts:
        """What is expected, and is not shown."""
        return frozenset(f for f in self._off if f not in self.shown)

    def accept(self) -> None:
        """What is shown now is what is expected."""
        self._expected = self.facts
        self._since, self._off = {}, set()

    def expect(self, action: GroundAction) -> None:
        """What is expected is the state after this action. Precondition: something is expected."""
        for facts, holds in ((action.deletes, False), (action.adds, True)):
            for fact in facts:
                self._since[fact] = holds
        for fact in action.deletes | action.adds:
            self._compare(fact)

    def as_expected(self, running: GroundAction | None) -> bool:
        """Whether what is shown is what is expected, less what the running action is about to end."""
        if not self._off:
            return True
        return running is not None and self._off <= running.deletes and not any(f in self.shown for f in self._off)

    def _compare(self, fact: Condition) -> None:
        if self._expected is None:
            return
        expected = self._since.get(fact, fact in self._expected)
        (self._off.discard if expected == (fact in self.shown) else self._off.add)(fact)
