"""Ticks a tree against a world as it stands: it is never changed, and nothing is proved of it.

One tick is 0.1 s of simulated time, and the root is ticked exactly once in it, so that a Retry without end cannot hang
the robot. It ends when the root does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from llmbt_atl.state import Domain
from llmbt_ir.condition import Goals, holds, satisfied
from llmbt_runtime.engine.engine import OneBody
from llmbt_runtime.engine.incremental import IncrementalEngine
from llmbt_runtime.engine.program import Op, Program
from llmbt_runtime.outcome import Executed, Happening, Outcome, Result
from llmbt_runtime.tick import NodeStatus
from llmbt_runtime.view import View
from llmbt_runtime.world import ActionReport, Status, World, WorldLostError

__all__ = ["drive"]

SETTLE_S = 0.5
ENDED = {Status.SUCCESS: NodeStatus.SUCCESS, Status.FAILURE: NodeStatus.FAILURE}


def drive(
    world: World,
    domain: Domain,
    program: Program,
    goals: Goals,
    *,
    tell: Callable[[Happening], None] = lambda _: None,
    max_ticks: int = 20_000,
) -> Result:
    """Tick until the root succeeds or fails. `goals` may be empty; those given have to hold by the truth then."""
    return _Drive(world, domain, program, goals, tell, max_ticks).run()


@dataclass
class _Drive:
    """The mutable state of one execution; the leaves of the engine."""

    world: World
    domain: Domain
    program: Program
    goals: Goals
    tell: Callable[[Happening], None]
    max_ticks: int
    ticks: int = 0
    executed: list[Executed] = field(default_factory=list)
    running: tuple[int, float] | None = None
    ended: NodeStatus | None = None
    last: NodeStatus = NodeStatus.RUNNING
    told_disturbances: int = 0
    view: View = field(init=False)

    def __post_init__(self) -> None:
        self.view = View(self.world)

    def run(self) -> Result:
        """Tick until the end."""
        engine = IncrementalEngine(self.program, OneBody(self))
        try:
            while self.ticks < self.max_ticks:
                change = self.view.look().take()
                status = engine.tick(change, round(1000 * self.world.time_s))
                if status is not NodeStatus.RUNNING:
                    return self.at_end(status, engine.last_leaf())
                self.advance()
            engine.halt()
        except KeyboardInterrupt:
            engine.halt()
            return self.end(Outcome.INTERRUPTED, "interrupted by the user")
        except WorldLostError as lost:
            return self.end(Outcome.WORLD_LOST, str(lost))
        return self.end(Outcome.BUDGET, f"no end after {self.ticks} ticks")

    def advance(self) -> None:
        """One tick of the world; the end of an action is noted, to be told when it is polled."""
        report = self.world.advance()
        self.ticks += 1
        log = self.world.disturbances()
        for d in log[self.told_disturbances :]:
            broke = ", ".join(str(c) for c in d.broke)
            self.say("disturbance", f"{d.name} of {d.target}" + (f": ended {broke}" if broke else ""), d.fired_at_s)
        self.told_disturbances = len(log)
        self.note(report)

    # -- leaves ---------------------------------------------------------------------------------------------------

    def start(self, node: int) -> NodeStatus:
        """See `Leaves`. What the domain does not have fails at once."""
        call = self.program.nodes[node].action
        assert call is not None
        self.ended = None
        if self.domain.action(call) is None:  # it may be about a thing that has turned up
            self.domain = self.domain.for_state(self.world.observe())
        self.running = node, self.world.time_s
        self.view.runs(self.domain.action(call))
        self.say("started", str(call), action=str(call), node=self.program.nodes[node].id)
        if self.domain.action(call) is None:
            self.finish("FAILURE", "the scene has no such action")
            self.last = NodeStatus.FAILURE
            return self.last
        self.world.start(call)
        return NodeStatus.RUNNING

    def poll(self, _node: int) -> NodeStatus:
        """See `Leaves`."""
        self.last, self.ended = self.ended or NodeStatus.RUNNING, None
        return self.last

    def halt(self, _node: int) -> None:
        """See `Leaves`: waits until the robot has come out of its contact phase."""
        while self.running is not None and not self.world.halt():
            self.advance()
        if self.running is not None:
            self.finish("HALTED", "the tree halted it")
        self.ended = None

    def note(self, report: ActionReport) -> None:
        if self.running is not None and report.status in ENDED:
            self.ended = ENDED[report.status]
            self.finish(report.status.value, report.reason)

    def finish(self, result: str, reason: str) -> None:
        """Note how the running action ended."""
        assert self.running is not None
        (node, since), self.running = self.running, None
        self.view.runs(None)
        call = self.program.nodes[node].action
        assert call is not None
        self.executed.append(Executed(call, result, reason, since, self.world.time_s))
        text = f"{call}: {result}" + (f" ({reason})" if reason else "")
        self.say("ended", text, result=result, reason=reason)

    # -- the end --------------------------------------------------------------------------------------------------

    def at_end(self, status: NodeStatus, leaf: int) -> Result:
        """The root has ended; this leaf decided it."""
        self.world.settle(SETTLE_S)
        if status is NodeStatus.FAILURE:
            return self.end(Outcome.TREE_FAILED, "the tree returned FAILURE" + self.because(leaf))
        truth = self.world.truth()
        if self.goals and not satisfied(self.goals, truth):
            missing = next(g for g in self.goals[0] if not holds(g, truth))
            return self.end(Outcome.TREE_FAILED, f"the tree returned SUCCESS, and {missing} does not hold")
        return self.end(Outcome.SUCCESS, "")

    def because(self, number: int) -> str:
        leaf = self.program.nodes[number]
        if leaf.condition is not None:
            what = f"{leaf.condition} {'held' if holds(leaf.condition, self.view.shown) else 'did not hold'}"
        elif leaf.action is not None:
            what = f"{leaf.action} {'failed' if self.last is NodeStatus.FAILURE else 'succeeded'}"
        else:
            ends = {Op.TIMEOUT: "ran out", Op.RETRY: "makes no attempt", Op.REPEAT: "makes no attempt"}
            what = f"{leaf.op} {ends.get(leaf.op, 'was reached')}"
        return f": {what}" + (f" (line {leaf.line})" if leaf.line else "")

    def end(self, outcome: Outcome, reason: str) -> Result:
        truth = self.world.truth()
        self.say("outcome", outcome.value + (f": {reason}" if reason else ""), outcome=outcome.value)
        goals = tuple((g, k, holds(g, truth)) for k, row in enumerate(self.goals, 1) for g in row)
        actions = tuple(self.executed)
        return Result(outcome, reason, goals, actions, 0, self.ticks, 0, 0, self.world.time_s)

    def say(self, kind: str, text: str, at_s: float | None = None, **details: object) -> None:
        self.tell(Happening(kind, self.world.time_s if at_s is None else at_s, text, details))
