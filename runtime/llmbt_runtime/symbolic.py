"""A world of facts: the templates' exact effects, actions that last and may fail, and events from outside.

An action that starts first ends those of its start-conditions that it touches, and brings its Post about when it is
done; its hold-conditions last until then. So a tree sees the same order of things as in physics.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from llmbt_atl.state import Domain, GroundAction, applicable
from llmbt_ir.condition import ActionCall, Condition, Facts, holds
from llmbt_runtime.chance import Chance
from llmbt_runtime.facts import Change, FactBase
from llmbt_runtime.world import TICK_S, ActionReport, Disturbed, Status, Vec3

__all__ = ["Event", "SymbolicWorld"]


@dataclass(frozen=True, slots=True)
class Event:
    """Something from outside: at a tick, or at the first tick from it on at which `when` holds, facts end and begin.

    It fires once, and of a `group` one fires. Containment is spelt out by the caller (`Domain.upward`). It also waits
    until so many things have been grasped, until a held thing has been carried over by a share of the running action
    (`transfer`), and until the action named `after` has succeeded `count` times.
    """

    tick: int
    removes: Facts = frozenset()
    adds: Facts = frozenset()
    when: tuple[Condition, ...] = ()
    name: str = "event"
    target: str = ""
    grasps: int = 0
    transfer: float = 0.0
    after: str = ""
    count: int = 1
    group: str = ""


class SymbolicWorld:
    """A world of facts behind the protocol `World`. All chance comes from `rng`."""

    def __init__(
        self,
        domain: Domain,
        facts: Facts,
        rng: Chance,
        *,
        ticks: tuple[int, int] = (1, 8),
        failure_rate: float = 0.0,
        events: Iterable[Event] = (),
        goals: tuple[Condition, ...] = (),
    ) -> None:
        """`ticks` bounds how long an action lasts, both included; a disturbance is over once a goal about its target
        holds, too."""
        self._domain = domain
        self._state = FactBase(facts)
        self._rng = rng
        self._ticks = ticks
        self._failure_rate = failure_rate
        self._events = tuple(events)
        self._goals = goals
        self._log: tuple[Disturbed, ...] = ()
        self._now = 0
        self._running: GroundAction | None = None
        self._left = self._lasts = 0
        self._grasps = 0
        self._succeeded: Counter[str] = Counter()
        self._failing = False
        self._suspended: Facts = frozenset()

    @property
    def time_s(self) -> float:
        """Simulated time: ticks of 0.1 s."""
        return round(self._now * TICK_S, 6)

    @property
    def at_rest(self) -> bool:
        """Facts do not roll."""
        return True

    def observe(self) -> Facts:
        """The facts."""
        return self._state.facts

    def changes(self) -> Change:
        """What was written to the facts since this was last asked."""
        return self._state.take()

    def truth(self) -> Facts:
        """The facts."""
        return self._state.facts

    def start(self, action: ActionCall) -> None:
        """Begin an action (ValueError where the domain has none such). It fails where its Pre does not hold."""
        ground = self._domain.action(action)
        if ground is None:  # it may be about a thing that has turned up
            self._domain = self._domain.for_state(self._state.facts)
            ground = self._domain.action(action)
        if ground is None:
            raise ValueError(f"the domain has no action {action}")
        if self._running is not None:
            raise RuntimeError("an action is running")
        self._running = ground
        self._left = self._lasts = int(self._rng.integers(self._ticks[0], self._ticks[1] + 1))
        self._failing = bool(self._rng.random() < self._failure_rate) or not applicable(ground, self._state)
        touched = ground.deletes | ground.adds
        positive = frozenset(c for c in ground.start if not c.negated) - frozenset(ground.hold)
        self._suspended = frozenset(c for c in positive & touched if c in self._state)
        if not self._failing:
            self._state.write(self._suspended, ())

    def halt(self) -> bool:
        """Stop at once: what the action had ended for a while holds again."""
        if self._running is not None:
            self._restore()
            self._running = None
        return True

    def _restore(self) -> None:
        self._state.write((), self._suspended)
        self._suspended = frozenset()

    def advance(self) -> ActionReport:
        """One tick: events first, then the action."""
        self._now += 1
        self._fire()
        action = self._running
        if action is None:
            return ActionReport(Status.IDLE)
        self._left -= 1
        if self._left > 0:
            return ActionReport(Status.RUNNING)
        self._running = None
        broken = [c for c in action.hold if not holds(c, self._state)]
        if self._failing or broken:
            self._restore()
            return ActionReport(Status.FAILURE, "failed" if self._failing else f"lost {broken[0]}")
        self._suspended = frozenset()
        self._state.write(action.deletes, action.adds)
        self._grasps += any(f.name == "Holding" for f in action.adds)
        self._succeeded[action.call.name] += 1
        self._recovered()
        return ActionReport(Status.SUCCESS)

    def _fire(self) -> None:
        waiting: list[Event] = []
        fired: set[str] = set()
        for event in self._events:
            if event.group in fired or not self._due(event):
                waiting.append(event)
                continue
            broke = tuple(sorted(f for f in event.removes - event.adds if f in self._state))
            self._state.write(event.removes, event.adds)
            self._suspended = self._suspended - event.removes
            self._log = (*self._log, Disturbed(event.name, event.target, self.time_s, broke))
            fired |= {event.group} if event.group else set()
        self._events = tuple(e for e in waiting if e.group not in fired)

    def _due(self, event: Event) -> bool:
        if event.tick > self._now or event.grasps > self._grasps:
            return False
        if event.transfer and (self._running is None or 1 - self._left / self._lasts < event.transfer):
            return False
        if event.after and self._succeeded[event.after] < event.count:
            return False
        return all(holds(c, self._state) for c in event.when)

    def _recovered(self) -> None:
        reached = {arg for g in self._goals if holds(g, self._state) for arg in g.args}
        self._log = tuple(
            replace(d, recovered_at_s=self.time_s)
            if d.recovered_at_s is None and d.broke and (all(c in self._state for c in d.broke) or d.target in reached)
            else d
            for d in self._log
        )

    def settle(self, seconds: float) -> None:
        """Let time go by."""
        for _ in range(round(seconds / TICK_S)):
            self.advance()

    def objects(self) -> dict[str, Vec3]:
        """Facts have no coordinates."""
        return {}

    def places(self) -> dict[str, Vec3]:
        """Facts have no coordinates."""
        return {}

    def disturbances(self) -> tuple[Disturbed, ...]:
        """The events that have fired."""
        return self._log

    def close(self) -> None:
        """Nothing to give back."""
