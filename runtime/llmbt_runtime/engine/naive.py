"""The naive engine: node by node what BehaviorTree.CPP's nodes do, every tick from the root. The oracle of the other.

A node's tick is a generator that yields the child to be ticked and is sent its status, so that the text reads as
recursion and depth costs no stack.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any

from llmbt_ir.condition import Condition
from llmbt_runtime.engine.engine import Leaves
from llmbt_runtime.engine.program import FALLBACKS, SEQUENCES, Op, Program
from llmbt_runtime.facts import Change
from llmbt_runtime.tick import NodeStatus

__all__ = ["NaiveEngine"]

SUCCESS, FAILURE, RUNNING = NodeStatus.SUCCESS, NodeStatus.FAILURE, NodeStatus.RUNNING
Ticking = Generator[int, NodeStatus, NodeStatus]
"""Yields the child to be ticked, is sent None first and then its status, returns its own."""


class NaiveEngine:
    """Ticks a program (see `Engine`). `status` is None where BehaviorTree.CPP says IDLE."""

    def __init__(self, program: Program, leaves: Leaves) -> None:
        self.program = program
        self.leaves = leaves
        self.trace: list[tuple[int, NodeStatus]] | None = None
        self.evaluations = 0
        self._facts: set[Condition] = set()
        self._now = 0
        self._wake = False
        self._status: list[NodeStatus | None] = [None] * len(program)
        self._count = [0] * len(program)
        """The current child of a Sequence or Fallback; the attempts or cycles done of a Retry or Repeat."""
        self._deadline: list[int | None] = [None] * len(program)
        """When the timer of a Timeout or Delay runs out; None where none runs."""
        self._expired = [False] * len(program)
        self._timed = tuple(i for i, n in enumerate(program.nodes) if n.op in (Op.TIMEOUT, Op.DELAY))
        tick_of: dict[Op, Callable[[int], Ticking]] = {
            Op.SEQUENCE: self._remembering,
            Op.FALLBACK: self._remembering,
            Op.REACTIVE_SEQUENCE: self._reactive,
            Op.REACTIVE_FALLBACK: self._reactive,
            Op.INVERTER: self._changed,
            Op.FORCE_SUCCESS: self._changed,
            Op.FORCE_FAILURE: self._changed,
            Op.RETRY: self._again,
            Op.REPEAT: self._again,
            Op.TIMEOUT: self._timeout,
            Op.DELAY: self._delay,
        }
        self._tick_of = tick_of

    def tick(self, change: Change, now_ms: int) -> NodeStatus:
        """See `Engine.tick`."""
        self._facts -= change.removed
        self._facts |= change.added
        self._now = now_ms
        self._expire()
        status = self._ticked(0)
        if status is not RUNNING:
            self._status[0] = None
        return status

    def take_wake(self) -> bool:
        """See `Engine.take_wake`."""
        wake, self._wake = self._wake, False
        return wake

    def halt(self) -> None:
        """See `Engine.halt`."""
        self._reset(0)

    # -- ticking ------------------------------------------------------------------------------------------------------

    def _ticked(self, top: int) -> NodeStatus:
        """Tick a node and whatever it comes to, on a stack of its own."""
        stack: list[tuple[int, Ticking]] = []
        here = top
        while True:
            op = self.program.nodes[here].op
            answer: Any = None  # what a generator is sent first
            if op in self._tick_of:
                stack.append((here, self._tick_of[op](here)))
            else:
                answer = self._status[here] = self._leaf(here, op)
            while stack:
                try:
                    here = stack[-1][1].send(answer)
                except StopIteration as end:
                    answer = self._status[stack.pop()[0]] = end.value
                else:
                    break
            else:
                status: NodeStatus = answer
                return status

    def _leaf(self, n: int, op: Op) -> NodeStatus:
        node = self.program.nodes[n]
        if op is Op.ALWAYS_SUCCESS:
            return SUCCESS
        if op is Op.ALWAYS_FAILURE:
            return FAILURE
        if node.condition is not None:
            self.evaluations += 1
            status = SUCCESS if (node.condition.fact in self._facts) != node.condition.negated else FAILURE
        else:
            status = self.leaves.poll(n) if self._status[n] is RUNNING else self.leaves.start(n)
        if self.trace is not None:
            self.trace.append((n, status))
        return status

    # -- composites ---------------------------------------------------------------------------------------------------

    def _remembering(self, n: int) -> Ticking:
        """Sequence and Fallback: go on where it stopped."""
        node = self.program.nodes[n]
        go_on = SUCCESS if node.op in SEQUENCES else FAILURE
        self._status[n] = RUNNING
        while self._count[n] < len(node.children):
            status = yield node.children[self._count[n]]
            if status is RUNNING:
                return RUNNING
            if status is not go_on:
                self._reset_children(n)
                self._count[n] = 0
                return status
            self._count[n] += 1
        self._reset_children(n)
        self._count[n] = 0
        return go_on

    def _reactive(self, n: int) -> Ticking:
        """ReactiveSequence and ReactiveFallback: always from the first child; what ran elsewhere is halted."""
        node = self.program.nodes[n]
        go_on = FAILURE if node.op in FALLBACKS else SUCCESS
        self._status[n] = RUNNING
        for child in node.children:
            status = yield child
            if status is RUNNING:
                for other in node.children:
                    if other != child:
                        self._reset(other)
                return RUNNING
            if status is not go_on:
                self._reset_children(n)
                return status
        self._reset_children(n)
        return go_on

    # -- decorators ---------------------------------------------------------------------------------------------------

    def _changed(self, n: int) -> Ticking:
        """Inverter, ForceSuccess, ForceFailure."""
        node = self.program.nodes[n]
        self._status[n] = RUNNING
        status = yield node.children[0]
        if status is RUNNING:
            return RUNNING
        self._reset_children(n)
        if node.op is Op.INVERTER:
            return FAILURE if status is SUCCESS else SUCCESS
        return SUCCESS if node.op is Op.FORCE_SUCCESS else FAILURE

    def _again(self, n: int) -> Ticking:
        """RetryUntilSuccessful and Repeat: after an attempt that began and ended in one tick, the root is asked to be
        ticked again; after one that lasted, the next begins at once."""
        node = self.program.nodes[n]
        again = FAILURE if node.op is Op.RETRY else SUCCESS
        child = node.children[0]
        self._status[n] = RUNNING
        while node.amount == -1 or self._count[n] < node.amount:
            was_idle = self._status[child] is None
            status = yield child
            if status is RUNNING:
                return RUNNING
            self._reset_children(n)
            if status is not again:
                self._count[n] = 0
                return status
            self._count[n] += 1
            if was_idle and (node.amount == -1 or self._count[n] < node.amount):
                self._wake = True
                return RUNNING
        self._count[n] = 0
        return again

    def _timeout(self, n: int) -> Ticking:
        """Timeout: halts its child when the time is up, and fails. 0 ms: never."""
        node = self.program.nodes[n]
        if self._status[n] is not RUNNING:
            self._status[n] = RUNNING
            self._expired[n] = False
            self._deadline[n] = self._now + node.amount if node.amount > 0 else None
        if self._expired[n]:
            return FAILURE
        status = yield node.children[0]
        if status is not RUNNING:
            self._deadline[n] = None
            self._reset_children(n)
        return status

    def _delay(self, n: int) -> Ticking:
        """Delay: its child is ticked from the first tick on at which the time is up, which is never the same."""
        node = self.program.nodes[n]
        if self._status[n] is not RUNNING:
            self._status[n] = RUNNING
            self._expired[n] = False
            self._deadline[n] = self._now + node.amount
        if not self._expired[n]:
            return RUNNING
        status = yield node.children[0]
        if status is not RUNNING:
            self._reset_children(n)
        return status

    # -- timers and halts ---------------------------------------------------------------------------------------------

    def _expire(self) -> None:
        """Serve the timers that have run out, the earliest first."""
        due = [(d, n) for n in self._timed if (d := self._deadline[n]) is not None and d <= self._now]
        for _, n in sorted(due):
            if self._deadline[n] is None:
                continue
            self._deadline[n] = None
            self._expired[n] = True
            self._wake = True
            if self.program.nodes[n].op is Op.TIMEOUT:
                self._reset_children(n)

    def _reset_children(self, n: int) -> None:
        for child in self.program.nodes[n].children:
            self._reset(child)

    def _reset(self, top: int) -> None:
        """Make a node idle; if it is RUNNING, halt what is below it, in order."""
        stack = [top]
        while stack:
            n = stack.pop()
            if self._status[n] is RUNNING:
                node = self.program.nodes[n]
                if node.op is Op.ACTION:
                    self.leaves.halt(n)
                self._count[n] = 0
                self._deadline[n] = None
                stack.extend(reversed(node.children))
            self._status[n] = None
