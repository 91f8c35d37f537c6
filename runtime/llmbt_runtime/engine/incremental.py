"""The engine whose tick costs what changed.

Its run state is the path from the root to what runs: since no node runs two children at once, whatever is not on the
path is idle, and what an idle branch would come to is known (`Values`). A tick goes on where the path ends; only where
a child before the path has come to stop its reactive parent does it begin there, the topmost first.
"""

from __future__ import annotations

from llmbt_runtime.engine.engine import Leaves
from llmbt_runtime.engine.program import REACTIVE, Op, Program
from llmbt_runtime.engine.values import NEEDS, NO_COMPOSITE, STATUS, Values, replay
from llmbt_runtime.facts import Change
from llmbt_runtime.tick import NodeStatus

__all__ = ["IncrementalEngine"]

SUCCESS, FAILURE, RUNNING = NodeStatus.SUCCESS, NodeStatus.FAILURE, NodeStatus.RUNNING
NEVER = float("inf")
OFF_PATH = -1
RAN_OUT = -2


class _Frame:
    """A node on the path. `at`: the rank of a composite's running child, the attempts or cycles done of a Retry or
    Repeat. `begun`: the tick in which a Retry or Repeat last ticked its child anew. `due`: when a timer runs out.
    `expired`: it has."""

    __slots__ = ("at", "begun", "due", "expired", "node")

    def __init__(self, node: int) -> None:
        self.node = node
        self.at = 0
        self.begun = 0
        self.due = NEVER
        self.expired = False


class IncrementalEngine:
    """Ticks a program (see `Engine`)."""

    def __init__(self, program: Program, leaves: Leaves) -> None:
        self.program = program
        self.leaves = leaves
        self.trace: list[tuple[int, NodeStatus]] | None = None
        self.values = Values(program, self._stopped)
        self._path: list[_Frame] = []
        self._where = [OFF_PATH] * len(program)
        self._alerts: set[int] = set()
        """Among them all reactive nodes on the path, or aside, with a child before the running one that stops them."""
        self._aside: tuple[_Frame, int, list[_Frame]] | None = None
        """While another branch is ticked: the frame that has left its running child, which one, and the path there."""
        self._ended: dict[int, int] = {}
        """The nodes of the path that came to an end in this tick, with the rank of the child that was ticked last."""
        self._due = NEVER
        """No timer runs out before."""
        self._ticks = 0
        self._now = 0
        self._wake = False

    @property
    def evaluations(self) -> int:
        """How many conditions have been evaluated."""
        return self.values.evaluations

    def tick(self, change: Change, now_ms: int) -> NodeStatus:
        """See `Engine.tick`."""
        if change:
            self.values.learn(change)
        self._ended.clear()
        self._now = now_ms
        self._ticks += 1
        if now_ms >= self._due:
            self._expire()
        status = self._go_on(0) if self._path else self._anew(0)
        while status is not RUNNING and self._path:
            status = self._returned(status)
        if self._aside is not None:
            self._drop()
        return status

    def last_leaf(self) -> int:
        """The leaf that decided the last tick, or the Timeout that had run out, or the Retry or Repeat of no attempts.
        Precondition: that tick did not return RUNNING."""
        nodes, n = self.program.nodes, 0
        while nodes[n].children:
            rank = self._ended.get(n)
            if nodes[n].op in (Op.RETRY, Op.REPEAT) and (nodes[n].amount == 0 or nodes[n].amount < -1):
                break
            if rank is None:
                rank = self.values.first_stop(n) if self.values.go_on[n] != NO_COMPOSITE else 0
            elif rank == RAN_OUT:
                break
            n = nodes[n].children[rank]
        return n

    def take_wake(self) -> bool:
        """See `Engine.take_wake`."""
        wake, self._wake = self._wake, False
        return wake

    def halt(self) -> None:
        """See `Engine.halt`."""
        self._cut(0)

    # -- ticking ------------------------------------------------------------------------------------------------------

    def _go_on(self, start: int) -> NodeStatus:
        """Tick what runs from the frame `start` of the path on: from the topmost alert, or else where the path ends."""
        alert = self._alerted(start) if self._alerts else None
        if self.trace is not None:
            self._told_path(start, len(self._path) if alert is None else alert)
        if alert is not None:
            return self._preempt(alert)
        frame = self._path[-1]
        node = self.program.nodes[frame.node]
        if node.op is Op.ACTION:
            status = self.leaves.poll(frame.node)
            if self.trace is not None:
                self.trace.append((frame.node, status))
            if status is not RUNNING:
                self._pop()
            return status
        if node.op is Op.TIMEOUT:  # its child has been halted
            frame.at = RAN_OUT
            self._pop()
            return FAILURE
        if node.op is Op.DELAY and not frame.expired:
            return RUNNING
        frame.begun = self._ticks
        return self._anew(node.children[0])

    def _anew(self, n: int) -> NodeStatus:
        """Tick an idle node: its value, or else down to what has to be ticked, which is put on the path."""
        nodes, values = self.program.nodes, self.values
        while values.value[n] == NEEDS:
            frame = _Frame(n)
            self._where[n] = len(self._path)
            self._path.append(frame)
            node = nodes[n]
            if values.go_on[n] != NO_COMPOSITE:
                frame.at = values.first_stop(n)
                self._told_children(n, 0, frame.at)
                n = node.children[frame.at]
                continue
            if node.op is Op.ACTION:
                status = self.leaves.start(n)
                if self.trace is not None:
                    self.trace.append((n, status))
                if status is not RUNNING:
                    self._pop()
                return status
            if node.op is Op.DELAY or (node.op is Op.TIMEOUT and node.amount > 0):
                frame.due = self._now + node.amount
                self._due = min(self._due, frame.due)
                if node.op is Op.DELAY:
                    return RUNNING
            frame.begun = self._ticks
            n = node.children[0]
        if self.trace is not None:
            self.trace.extend(replay(values, n))
        return STATUS[values.value[n]]

    def _returned(self, status: NodeStatus) -> NodeStatus:
        """What the last node of the path makes of its child's end."""
        frame = self._path[-1]
        n = frame.node
        op = self.program.nodes[n].op
        if self.values.go_on[n] != NO_COMPOSITE:
            return self._next(frame, status)
        if op is Op.RETRY or op is Op.REPEAT:
            return self._again(frame, status)
        self._pop()
        if op is Op.INVERTER:
            return FAILURE if status is SUCCESS else SUCCESS
        if op is Op.FORCE_SUCCESS:
            return SUCCESS
        return FAILURE if op is Op.FORCE_FAILURE else status

    def _next(self, frame: _Frame, status: NodeStatus) -> NodeStatus:
        """A composite after a child: its end, or the next child at which it does not go on."""
        n, values = frame.node, self.values
        node = self.program.nodes[n]
        left = self._aside if self._aside is not None and self._aside[0] is frame else None
        if status is STATUS[values.go_on[n]]:
            rank = values.next_stop(n, frame.at)
            if left is not None and (rank < 0 or rank >= left[1]):
                return self._back(frame)
            if rank >= 0 and values.value[node.children[rank]] == NEEDS:
                self._told_children(n, frame.at + 1, rank)
                frame.at = rank
                if node.op in REACTIVE:
                    self._alerts.add(n)
                return self._anew(node.children[rank])
            self._told_children(n, frame.at + 1, len(node.children) if rank < 0 else rank + 1)
            frame.at = rank
            if rank >= 0:
                status = STATUS[values.value[node.children[rank]]]
        if left is not None:
            self._drop()
        self._pop()
        return status

    def _again(self, frame: _Frame, status: NodeStatus) -> NodeStatus:
        """A Retry or Repeat after an attempt (see `NaiveEngine._again`)."""
        node = self.program.nodes[frame.node]
        again = FAILURE if node.op is Op.RETRY else SUCCESS
        frame.at += 1
        if status is not again or frame.at == node.amount:
            self._pop()
            return status
        if frame.begun == self._ticks:
            self._wake = True
            return RUNNING
        frame.begun = self._ticks
        return self._anew(node.children[0])

    # -- another branch takes over ------------------------------------------------------------------------------------

    def _stopped(self, n: int) -> None:
        """A child of `n` has come to stop it."""
        if self._where[n] != OFF_PATH:
            self._alerts.add(n)

    def _alerted(self, start: int) -> int | None:
        """The topmost frame, from `start` on, that would stop before the child that runs."""
        best: int | None = None
        for n in tuple(self._alerts):
            at = self._where[n]
            if at == OFF_PATH or not self._stops_before(n, self._path[at].at):
                self._alerts.discard(n)
            elif at >= start and (best is None or at < best):
                best = at
        return best

    def _stops_before(self, n: int, rank: int) -> bool:
        return self.program.nodes[n].op in REACTIVE and bool(self.values.stops[n] & ((1 << rank) - 1))

    def _preempt(self, at: int) -> NodeStatus:
        """Tick the first child that stops a reactive node, which another child of it runs after."""
        frame = self._path[at]
        gone = self._path[at + 1 :]
        del self._path[at + 1 :]
        for below in gone:
            self._where[below.node] = OFF_PATH
        self._aside = (frame, frame.at, gone)
        node = self.program.nodes[frame.node]
        frame.at = self.values.first_stop(frame.node)
        self._told_children(frame.node, 0, frame.at)
        child = node.children[frame.at]
        if self.values.value[child] == NEEDS:
            return self._anew(child)
        status = self._anew(child)
        self._drop()
        self._pop()
        return status

    def _back(self, frame: _Frame) -> NodeStatus:
        """The branches that came first have ended at once, and the tick comes to the child that ran."""
        assert self._aside is not None
        _, rank, gone = self._aside
        self._aside = None
        self._told_children(frame.node, frame.at + 1, rank)
        frame.at = rank
        start = len(self._path)
        for below in gone:
            self._where[below.node] = len(self._path)
            self._path.append(below)
        return self._go_on(start)

    def _drop(self) -> None:
        """Halt what was left aside."""
        assert self._aside is not None
        _, _, gone = self._aside
        self._aside = None
        self._halt_last(gone)

    # -- the path -----------------------------------------------------------------------------------------------------

    def _pop(self) -> None:
        frame = self._path.pop()
        self._where[frame.node] = OFF_PATH
        self._ended[frame.node] = frame.at if self.values.go_on[frame.node] != NO_COMPOSITE or frame.at < -1 else 0

    def _cut(self, at: int) -> None:
        """Halt the path from a frame on."""
        gone = self._path[at:]
        del self._path[at:]
        for below in gone:
            self._where[below.node] = OFF_PATH
        self._halt_last(gone)

    def _halt_last(self, gone: list[_Frame]) -> None:
        if gone and self.program.nodes[gone[-1].node].op is Op.ACTION:
            self.leaves.halt(gone[-1].node)

    def _expire(self) -> None:
        """Serve the timers that have run out, the earliest first."""
        for frame in sorted((f for f in self._path if f.due <= self._now), key=lambda f: f.due):
            at = self._where[frame.node]
            if at == OFF_PATH:
                continue
            frame.due, frame.expired, self._wake = NEVER, True, True
            if self.program.nodes[frame.node].op is Op.TIMEOUT:
                self._cut(at + 1)
        self._due = min((f.due for f in self._path), default=NEVER)

    # -- telling ------------------------------------------------------------------------------------------------------

    def _told_children(self, n: int, first: int, end: int) -> None:
        """The children that were passed over, as BehaviorTree.CPP would tick them."""
        if self.trace is not None:
            for child in self.program.nodes[n].children[first:end]:
                self.trace.extend(replay(self.values, child))

    def _told_path(self, start: int, end: int) -> None:
        """What reactive nodes on the path tick before the child that runs."""
        for frame in self._path[start:end]:
            if self.program.nodes[frame.node].op in REACTIVE:
                self._told_children(frame.node, 0, frame.at)
