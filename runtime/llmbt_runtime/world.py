"""What a tree needs of a world, be it physics or facts.

A world goes on in ticks of 0.1 s. It runs one action at a time; between ticks it is looked at through conditions.
While an action is in a contact phase (fingers closing until the thing is lifted, opening until it is let go) `observe`
gives the facts about the hand and what it handles as they were before it, so that no tick sees a moment between.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.facts import Change

__all__ = ["TICK_S", "ActionReport", "Disturbed", "Status", "World", "WorldLostError"]

TICK_S = 0.1
Vec3 = tuple[float, float, float]


class Status(StrEnum):
    """Of an action, and of a node of a tree."""

    IDLE = "IDLE"
    RUNNING = "RUNNING"
    SUCCESS = "SUCCESS"
    FAILURE = "FAILURE"


@dataclass(frozen=True, slots=True)
class ActionReport:
    """How the running action stands. `reason` is a code, as `dropped_on_the_way`; `blocker` the body in the way.

    An action that was halted ends with IDLE and the reason `halted`. `denies`: a fact that the failure speaks against;
    the world leaves it out of what it tells, for as long as nothing changes about it.
    """

    status: Status
    reason: str = ""
    blocker: str | None = None
    denies: Condition | None = None


@dataclass(frozen=True, slots=True)
class Disturbed:
    """A disturbance that has happened. Times are simulated.

    `broke`: the facts that held by the truth before it and no more after it. `recovered_at_s`: when they held again,
    or the goal about the target did; None while neither.
    """

    name: str
    target: str
    fired_at_s: float
    broke: tuple[Condition, ...]
    recovered_at_s: float | None = None


class WorldLostError(RuntimeError):
    """The world cannot go on: its server is gone, the robot does not answer."""


class World(Protocol):
    """Something that a tree can be executed in."""

    @property
    def time_s(self) -> float:
        """Simulated time since the world was made."""

    def observe(self) -> Facts:
        """The facts that the tree's conditions see; what is missing does not hold."""

    def changes(self) -> Change:
        """The difference between what `observe` gives now and what it gave when this was last asked (by whom ever; at
        first all that holds), at the cost of what changed where the world can."""

    def truth(self) -> Facts:
        """The facts as they are, whatever the running action withholds; for scoring."""

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves but the robot and what it holds: a thing that was dropped may still be rolling."""

    def start(self, action: ActionCall) -> None:
        """Begin an action. Precondition: none runs. ValueError for a name or argument that the world does not have."""

    def halt(self) -> bool:
        """Ask the running action to stop; True once none runs.

        In a contact phase it goes on to the end of the phase (at most some 3 s), then stops; what has nowhere else to
        be is set down first (some 10 s). Keep calling `advance`.
        """

    def advance(self) -> ActionReport:
        """Go on by one tick. The report of the running action; IDLE where none runs."""

    def settle(self, seconds: float) -> None:
        """Go on without an action."""

    def objects(self) -> dict[str, Vec3]:
        """Centre of every thing in play."""

    def places(self) -> dict[str, Vec3]:
        """Centre of every place's surface."""

    def disturbances(self) -> tuple[Disturbed, ...]:
        """What has disturbed the world so far, in order."""

    def close(self) -> None:
        """Give back what the world holds; no other call may follow."""
