"""What a tree is told while an action runs, so that no tick shows it a moment between two states. Pure.

1. In a contact phase the facts about the hand, the handled thing, and whether the places it leaves and reaches are
   free stay as they were when the phase began.
2. What an action is there to bring about and did not hold at its start is withheld until the action has ended.
3. A robot that goes from one docking pose of a place to another, to get at a thing, is at the place all the while.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.facts import Change, change_between

__all__ = ["Reporter", "post_of"]

_HAND = frozenset({"HandEmpty", "Holding", "Touching"})
_APPROACH = frozenset({"Clear", "Blocks"})
_CARRYING = frozenset({"move_aside", "clear_away", "clear_place", "clear_way", "recover"})
"""Actions that pick and place in one: that the thing is held meanwhile is theirs alone."""


def post_of(action: ActionCall) -> tuple[Condition, ...]:
    """What an action of a shipped library brings about. ValueError where it is none, or its arity is wrong."""
    match action.name, action.args:
        case "pick", (o, p):
            return (Condition("Holding", (o,)), Condition("Free", (p,)))
        case (("place" | "put_down"), (o, p)):
            return (Condition("On", (o, p)), Condition("HandEmpty"))
        case "move_aside", (o, p, region):
            where = Condition("On", (o, region)), Condition("Near", (region,))
            return (Condition("Free", (p,)), *where, Condition("HandEmpty"))
        case "clear_away", (b, o, p, region):
            return (
                Condition("Clear", (o,)),
                Condition("On", (b, region)),
                Condition("Free", (p,)),
                Condition("HandEmpty"),
            )
        case "clear_away", (_, o, _):
            return (Condition("Clear", (o,)), Condition("HandEmpty"))
        case "navigate", (p,):
            return (Condition("Near", (p,)),)
        case "clear_way", (_, p):
            return (Condition("Clear", (p,)), Condition("Near", (p,)), Condition("HandEmpty"))
        case "clear_place", (o, _, slot, region):
            return (Condition("Free", (slot,)), Condition("On", (o, region)), Condition("HandEmpty"))
        case "release", (_,):
            return (Condition("HandEmpty"),)
        case "look", (_, _):
            return ()
        case "recover", (o, region):
            return (Condition("On", (o, region)), Condition("Near", (region,)), Condition("HandEmpty"))
        case _:
            raise ValueError(f"no such action: {action}")


@dataclass
class Reporter:
    """Keeps what was true when the action, and when its contact phase, began."""

    containers: Callable[[str], Iterable[str]]
    _withheld: frozenset[Condition] = frozenset()
    _at_start: Facts = frozenset()
    _snapshot: Facts | None = None
    _handled: str = ""
    _places: frozenset[str] = frozenset()
    _near: str | None = None
    _committed: bool = False
    last: Facts = field(default=frozenset())
    _handed_over: Facts = frozenset()

    @property
    def in_contact(self) -> bool:
        """Whether a contact phase is on."""
        return self._snapshot is not None

    @property
    def may_halt(self) -> bool:
        """Whether the action may be halted now: not in a contact phase, nor before it has set down what it must."""
        return not (self.in_contact or self._committed)

    def commit(self) -> None:
        """From the contact phase that is on until `release`, the action may not be halted."""
        self._committed = self._committed or self.in_contact

    def release(self) -> None:
        """The action may be halted again."""
        self._committed = False

    def begin(self, action: ActionCall) -> None:
        """An action starts; what it will bring about and does not hold now is withheld until `end`."""
        wanted: set[Condition] = set()
        for c in post_of(action):
            if c.name == "On":
                wanted.update(Condition("On", (c.args[0], p)) for p in self.containers(c.args[1]))
            else:
                wanted.add(c)
        if action.name in _CARRYING:
            wanted.add(Condition("Holding", (action.args[0],)))
        self._withheld = frozenset(wanted - self.last)
        self._at_start = self.last

    def end(self) -> None:
        """The action has ended, or was halted."""
        self._withheld, self._at_start = frozenset(), frozenset()
        self._near = None
        self.release()
        self.leave_contact()

    def hold_near(self, place: str) -> None:
        """Until the action ends, the robot is told to be at a place."""
        self._near = place

    def enter_contact(self, handled: str, places: Iterable[str]) -> None:
        """A contact phase begins: a thing is about to be grasped or let go, from or onto places."""
        self._snapshot = self.last
        self._handled = handled
        on = {c.args[1] for c in self.last if c.name == "On" and c.args[0] == handled}
        self._places = frozenset(on.union(*(self.containers(p) for p in places)))

    def leave_contact(self) -> None:
        """The contact phase is over."""
        self._snapshot = None

    def report(self, facts: Facts) -> Facts:
        """What is told of the facts of this tick."""
        told = facts
        if self._snapshot is not None:
            told = self._frozen(told, self._snapshot)
        if self._near is not None:
            told = frozenset(c for c in told if c.name != "Near") | {Condition("Near", (self._near,))}
        if self._withheld:
            told = self._held_back(told)
        if told != self.last:
            self.last = told
        return self.last

    def changes(self) -> Change:
        """How `last` differs from what it was at the last call."""
        change, self._handed_over = change_between(self._handed_over, self.last), self.last
        return change

    def _frozen(self, facts: Facts, before: Facts) -> Facts:
        handled = self._handled
        near = {c.args[1] for c in facts | before if c.name == "Blocks" and c.args[0] == handled} | {handled}

        def stays(c: Condition) -> bool:
            if c.name in _HAND or handled in c.args:
                return True
            if c.name == "Free":
                return c.args[0] in self._places
            return c.name in _APPROACH and c.args[-1] in near

        return frozenset(c for c in facts if not stays(c)) | frozenset(c for c in before if stays(c))

    def _held_back(self, facts: Facts) -> Facts:
        withheld = facts & self._withheld
        if not withheld:
            return facts
        targets = {c.args[0] for c in withheld if c.name == "Clear"}
        kept = {c for c in self._at_start if c.name == "Blocks" and c.args[1] in targets}
        return (facts - withheld) | kept
