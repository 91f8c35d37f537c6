"""When a run is disturbed, and what came of it: drawn by a seed, set off at a moment, logged.

Every disturbance comes once the run is under way (a robot that stands still: after its first grasp) and before its end,
outside contact phases, with nothing else in motion, and makes something false that held. What it leaves behind can be
dealt with, but for the two that say otherwise. What each one does is in `interventions`.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, nearest
from llmbt_ir.scene import Scene
from llmbt_runtime.bullet.interventions import Draw, Interventions
from llmbt_runtime.disturbance import BRING_A_THING, NAMES, DisturbanceSpec, When
from llmbt_runtime.world import Disturbed

__all__ = ["Disturber", "Moment", "has_what_is_brought"]

_BROKEN_BY_TICKS = 4
_BEFORE_A_GRASP = ("obstacle_at_pick", "object_moved", "object_taken", "base_blocked")
"""For a robot that drives these may come while it is on its way to the first thing."""
_DROP_AT = (0.12, 0.32)
_MAX_DELAY_TICKS = 12


def has_what_is_brought(scene: Scene, name: str) -> bool:
    """Whether a scene declares the thing that a disturbance brings in, where it brings one."""
    movable = name != "impossible"
    return name not in BRING_A_THING or any(b.movable is movable for b in scene.obstacles)


@dataclass(frozen=True, slots=True)
class Moment:
    """The run at the end of a tick. `transfer` is how far a carried thing has been carried over, while it is; `ended`
    the action that has just succeeded."""

    facts: Facts
    action: ActionCall | None
    in_contact: bool
    at_rest: bool
    held: str | None
    transfer: float | None
    ended: str | None = None


@dataclass
class _Pending:
    """A disturbance to come, and once it has been set off, what held until then."""

    name: str
    draw: Draw
    when: When | None
    about: str = ""
    key: Condition | None = None
    before: Facts = frozenset()
    fired_at_s: float = 0.0
    waited: int = 0


@dataclass
class Disturber:
    """Sets off disturbances. `step` is to be called at the end of every tick."""

    interventions: Interventions
    rng: np.random.Generator
    log: list[Disturbed] = field(default_factory=list)
    _keys: list[Condition | None] = field(default_factory=list)
    _waiting: list[_Pending] = field(default_factory=list)
    _fired: list[_Pending] = field(default_factory=list)
    _grasped: list[str] = field(default_factory=list)
    _carries: int = 0
    _carried_ticks: int = 0
    _last_held: str | None = None
    _succeeded: Counter[str] = field(default_factory=Counter)

    def plan(self, specs: tuple[DisturbanceSpec, ...]) -> None:
        """Draw what specs leave open. E064 for an unknown name, E065 where a scene has no obstacle to bring in."""
        scene, goals = self.interventions.scene, self.interventions.goals
        for spec in specs:
            name = spec.name
            if name == "none":
                continue
            if name not in NAMES:
                close = nearest(name, (*NAMES, "none"))
                hint = f"known: {', '.join((*NAMES, 'none'))}"
                raise LlmbtError(Diagnostic("E064", f"unknown disturbance `{name}`", help=hint, candidates=close))
            if not has_what_is_brought(scene, name):
                movable = name != "impossible"
                what = "obstacle" if movable else "obstacle that cannot be moved"
                hint = "declare one under <Obstacles>" + ("" if movable else ', with movable="false"')
                title = f"scene `{scene.name}` has no {what} for `{name}`"
                raise LlmbtError(Diagnostic("E065", title, help=hint))
            early = self.interventions.terrain.drives and name in _BEFORE_A_GRASP
            first, last = 0 if early else 1, max(0 if early else 1, len(goals) - 1)
            drawn = int(self.rng.integers(first, last + 1))
            drop_at = float(self.rng.uniform(*_DROP_AT))
            delay = int(self.rng.integers(0, _MAX_DELAY_TICKS + 1))
            if spec.when is not None:
                drawn, delay = spec.when.grasp, 0
                drop_at = spec.when.transfer or drop_at
            self._waiting.append(_Pending(name, Draw(drawn, spec.target, drop_at, delay), spec.when))

    # ------------------------------------------------------------------ each tick

    def step(self, now: Moment) -> None:
        """Set off what is due; note what has been broken, and what has been mended since."""
        self._note_mended(now)
        self._note_broken(now)
        if now.ended is not None:
            self._succeeded[now.ended] += 1
        if now.held is not None and now.held != self._last_held and not now.in_contact:
            self._carries += 1
            if now.held not in self._grasped:
                self._grasped.append(now.held)
            self._last_held = now.held
            self._carried_ticks = 0
        elif now.held is None:
            self._last_held = None
        else:
            self._carried_ticks += 1
        if self._fired or now.in_contact or not now.at_rest:
            return
        for due in self._waiting:
            if self._is_due(due, now) and self._set_off(due, now):
                self._waiting.remove(due)
                return

    def _is_due(self, due: _Pending, now: Moment) -> bool:
        when = due.when
        if when is None:
            return bool(self._grasped) or due.draw.occurrence == 0
        if self.interventions.bench.time_s < when.time_s or self._carries < when.grasp:
            return False
        if when.after and self._succeeded[when.after] < when.count:
            return False
        return not when.transfer or (now.transfer is not None and now.transfer >= when.transfer)

    def _set_off(self, due: _Pending, now: Moment) -> bool:
        carry = self.interventions.carry(now.facts, now.held, now.action, now.transfer)
        carry = replace(carry, number=self._carries, ticks=self._carried_ticks, grasped=tuple(self._grasped))
        struck = self.interventions.strike(due.name, due.draw, carry)
        if struck is None:
            return False
        due.about, due.key = struck
        due.before, due.fired_at_s, due.waited = now.facts, self.interventions.bench.time_s, 0
        self._fired.append(due)
        return True

    def _note_broken(self, now: Moment) -> None:
        """A tick or more after a disturbance: which facts about it hold no more."""
        for one in list(self._fired):
            one.waited += 1
            if one.key in now.facts:
                if one.waited >= _BROKEN_BY_TICKS:  # it had no effect: try again
                    self._fired.remove(one)
                    self._waiting.insert(0, replace(one, waited=0, key=None))
                continue
            self._fired.remove(one)
            involved = {one.about, *(one.key.args if one.key is not None else ())}
            if one.name == "destination_shifted":
                involved |= self.interventions.stage.group(one.about)
            broke = tuple(sorted(f for f in one.before - now.facts if f == one.key or involved & set(f.args)))
            self.log.append(Disturbed(one.name, one.about, one.fired_at_s, broke))
            self._keys.append(one.key)

    def _note_mended(self, now: Moment) -> None:
        for i, (entry, key) in enumerate(zip(self.log, self._keys, strict=True)):
            if entry.recovered_at_s is not None:
                continue
            reached = any(g in now.facts and entry.target in g.args for g in self.interventions.goals)
            if key in now.facts or reached:
                self.log[i] = replace(entry, recovered_at_s=self.interventions.bench.time_s)
