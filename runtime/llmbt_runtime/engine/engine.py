"""The interface that both engines have, and what they ask of the robot."""

from __future__ import annotations

from typing import Protocol

from llmbt_runtime.engine.program import Program
from llmbt_runtime.facts import NO_CHANGE, Change
from llmbt_runtime.tick import NodeStatus

__all__ = ["Engine", "Leaves", "OneBody", "tick_once"]

MAX_WAKES = 10_000


class Leaves(Protocol):
    """The actions of a tree, by the numbers of their nodes. Facts do not change while one of these is called."""

    def start(self, node: int) -> NodeStatus:
        """Begin an action. It may end at once."""

    def poll(self, node: int) -> NodeStatus:
        """What an action that was started, and was RUNNING then, says now."""

    def halt(self, node: int) -> None:
        """Stop an action that was RUNNING."""


class Engine(Protocol):
    """Ticks a program. The statuses, the calls to the leaves and their order are those of BehaviorTree.CPP."""

    program: Program
    trace: list[tuple[int, NodeStatus]] | None
    """Where it is a list, each tick adds the condition and action leaves that BehaviorTree.CPP would tick, in that
    order, with what they return. Costs what those leaves cost."""

    def tick(self, change: Change, now_ms: int) -> NodeStatus:
        """Tick the root exactly once. `change` is what changed since the last tick (at first all that holds), `now_ms`
        the simulated time, which never goes back. Timers that have run out are served before the root is ticked."""

    def take_wake(self) -> bool:
        """Whether a node has asked to be ticked again at once, since this was last asked."""

    def halt(self) -> None:
        """Halt what runs. The next tick starts from the beginning."""


def tick_once(engine: Engine, change: Change, now_ms: int, *, limit: int = MAX_WAKES) -> NodeStatus:
    """Tick as `Tree::tickOnce` does: again and again while the tree is RUNNING and a node asks for it.

    RuntimeError after `limit` ticks: a Retry without end of what fails at once would never come back.
    """
    status = engine.tick(change, now_ms)
    for _ in range(limit):
        if status is not NodeStatus.RUNNING or not engine.take_wake():
            return status
        status = engine.tick(NO_CHANGE, now_ms)
    raise RuntimeError(f"the tree asks to be ticked again more than {limit} times in one tick")


class OneBody:
    """Leaves of a robot with one body: what runs is halted before anything else is started.

    BehaviorTree.CPP starts the action of a branch that takes over before it halts the one that ran. Here the other
    order reaches the robot. An action that lost the body, and that the tree still holds to be running when it comes to
    it in the same tick, is started again.
    """

    def __init__(self, robot: Leaves) -> None:
        self.robot = robot
        self.active: int | None = None

    def start(self, node: int) -> NodeStatus:
        """Halt what runs, then start."""
        if self.active is not None:
            self.robot.halt(self.active)
        self.active = node
        return self._noted(self.robot.start(node))

    def poll(self, node: int) -> NodeStatus:
        """Ask the action that has the body; start one that has lost it."""
        return self._noted(self.robot.poll(node)) if node == self.active else self.start(node)

    def halt(self, node: int) -> None:
        """Halt an action, unless it has been halted for another."""
        if node == self.active:
            self.active = None
            self.robot.halt(node)

    def _noted(self, status: NodeStatus) -> NodeStatus:
        if status is not NodeStatus.RUNNING:
            self.active = None
        return status
