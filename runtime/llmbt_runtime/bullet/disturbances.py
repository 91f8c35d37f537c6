"""What happens to a run from outside: a drop, an obstacle, a thing moved. Drawn by a seed, fired on an event, logged.

Every disturbance comes after the first grasp and before the end, outside contact phases, with nothing else in motion,
and makes something false that held. What it leaves behind can be dealt with: obstacles are within reach and can be
lifted, a moved thing can be taken again.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, nearest
from llmbt_ir.geometry import Vec3, yaw_from_quat
from llmbt_ir.scene import Body, Scene, ScenePlace
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.bench import Bench
from llmbt_runtime.bullet.bodies import BodyState, Extent, lying_at
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.world import Disturbed

__all__ = ["DISTURBANCES", "Disturber", "Moment"]

_T = TypeVar("_T")

DISTURBANCES = ("drop", "obstacle_at_pick", "obstacle_at_place", "placed_object_moved")
_HAND_AWAY_M, _LAST_CHANCE_M = 0.20, 0.32
_BESIDE_M = 0.004
_DROP_AT, _DROP_PATIENCE = (0.12, 0.32), 0.20
"""Parts of the way over: from one drawn in the first range on; later by the second, wherever it falls."""
_DROP_ROOM_M = 0.035
_DROP_OFF_GOAL_M = 0.09
_BROKEN_BY_TICKS = 4
_MAX_DELAY_TICKS = 12
"""An obstacle comes onto a slot up to so long after the thing that is to go there was taken."""


@dataclass(frozen=True, slots=True)
class Moment:
    """The run at the end of a tick. `transfer` is how far a carried thing has been carried over, while it is."""

    facts: Facts
    action: ActionCall | None
    in_contact: bool
    at_rest: bool
    held: str | None
    transfer: float | None


@dataclass
class _Pending:
    """A disturbance to come, and once it has been set off, what held until then."""

    name: str
    occurrence: int
    target: str | None
    drop_at: float = 0.5
    delay: int = 0
    about: str = ""
    key: Condition | None = None
    before: Facts = frozenset()
    fired_at_s: float = 0.0
    waited: int = 0


@dataclass
class Disturber:
    """Sets off disturbances. `step` is to be called at the end of every tick."""

    scene: Scene
    bench: Bench
    approach: Approach
    goals: tuple[Condition, ...]
    rng: np.random.Generator
    log: list[Disturbed] = field(default_factory=list)
    _keys: list[Condition] = field(default_factory=list)
    _waiting: list[_Pending] = field(default_factory=list)
    _fired: list[_Pending] = field(default_factory=list)
    _grasped: list[str] = field(default_factory=list)
    _carries: int = 0
    _carried_ticks: int = 0
    _last_held: str | None = None

    def plan(self, specs: tuple[DisturbanceSpec, ...]) -> None:
        """Draw what specs leave open. E064 for an unknown name, E065 where a scene has no obstacle to bring in."""
        for spec in specs:
            name = spec.name
            if name == "none":
                continue
            if name == "random":
                choices = [d for d in DISTURBANCES if self.scene.obstacles or not d.startswith("obstacle")]
                name = str(self.rng.choice(choices))
            if name not in DISTURBANCES:
                close = nearest(name, (*DISTURBANCES, "random", "none"))
                raise LlmbtError(
                    Diagnostic(
                        "E064",
                        f"unknown disturbance `{name}`",
                        help=f"known: {', '.join((*DISTURBANCES, 'random', 'none'))}",
                        candidates=close,
                    )
                )
            if name.startswith("obstacle") and not self.scene.obstacles:
                raise LlmbtError(
                    Diagnostic(
                        "E065",
                        f"scene `{self.scene.name}` has no obstacle for `{name}`",
                        help="declare one under <Obstacles>",
                    )
                )
            last = max(1, len(self.goals) - 1)
            drawn = int(self.rng.integers(1, last + 1))
            drop_at = float(self.rng.uniform(*_DROP_AT))
            delay = int(self.rng.integers(0, _MAX_DELAY_TICKS + 1))
            wanted = spec.when.grasp if spec.when is not None else 0
            self._waiting.append(_Pending(name, wanted or drawn, spec.target, drop_at, delay))

    # ------------------------------------------------------------------ each tick

    def step(self, now: Moment) -> None:
        """Set off what is due; note what has been broken, and what has been mended since."""
        self._note_mended(now)
        self._note_broken(now)
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
        if self._fired or not self._grasped or now.in_contact or not now.at_rest or not self._waiting:
            return
        due = self._waiting[0]
        if self._set_off(due, now):
            due.before, due.fired_at_s = now.facts, self.bench.time_s
            self._waiting.pop(0)
            self._fired.append(due)

    def _note_broken(self, now: Moment) -> None:
        """A tick or more after a disturbance: which facts about it hold no more."""
        for one in list(self._fired):
            one.waited += 1
            assert one.key is not None
            if one.key in now.facts:
                if one.waited >= _BROKEN_BY_TICKS:  # it had no effect: try again
                    self._fired.remove(one)
                    self._waiting.insert(0, replace(one, waited=0, key=None))
                continue
            self._fired.remove(one)
            involved = {one.about, *one.key.args}
            broke = tuple(sorted(f for f in one.before - now.facts if f == one.key or involved & set(f.args)))
            self.log.append(Disturbed(one.name, one.about, one.fired_at_s, broke))
            self._keys.append(one.key)

    def _note_mended(self, now: Moment) -> None:
        for i, (entry, key) in enumerate(zip(self.log, self._keys, strict=True)):
            if entry.recovered_at_s is not None:
                continue
            reached = any(g in now.facts and entry.target in g.args for g in self.goals)
            if key in now.facts or reached:
                self.log[i] = replace(entry, recovered_at_s=self.bench.time_s)

    def _set_off(self, due: _Pending, now: Moment) -> bool:
        match due.name:
            case "drop":
                return self._drop(due, now)
            case "obstacle_at_place":
                return self._obstacle_at_place(due, now)
            case "obstacle_at_pick":
                return self._obstacle_at_pick(due, now)
            case _:
                return self._placed_object_moved(due, now)

    # ------------------------------------------------------------------ the four

    def _drop(self, due: _Pending, now: Moment) -> bool:
        """On the way over, so that it falls onto the open workbench where that can be, and never onto its goal."""
        if self._carries < due.occurrence or now.held is None or now.transfer is None:
            return False
        if due.target is not None and now.held != due.target:
            return False
        x, y = self._landing(now.held)
        mine = [g for g in self.goals if g.name == "On" and g.args[0] == now.held]
        wanted = [self.scene.place(g.args[1]).surface_m for g in mine]
        if any(w is not None and math.hypot(x - w[0], y - w[1]) < _DROP_OFF_GOAL_M for w in wanted):
            return False
        drop_at = due.drop_at if self._carries == due.occurrence else _DROP_AT[0]  # overdue: as soon as may be
        anywhere = now.transfer >= drop_at + _DROP_PATIENCE
        if now.transfer < drop_at or not (anywhere or self._room_at(now.held, x, y)):
            return False
        due.about, due.key = now.held, Condition("Holding", (now.held,))
        self.bench.slip()
        return True

    def _landing(self, held: str) -> tuple[float, float]:
        """Where a held thing would come down on the workbench if it were let go now, by its speed and height."""
        state = self.bench.sensed.states[held]
        vx, vy = self.bench.velocity(held)[:2]
        height = max(0.0, state.extent.bottom_m - self.scene.robot_xyz_m[2])
        seconds = math.sqrt(2 * height / 9.81)
        return state.xyz[0] + vx * seconds, state.xyz[1] + vy * seconds

    def _room_at(self, held: str, x: float, y: float) -> bool:
        """Whether a thing that comes down there meets neither a fixture that stands out nor another thing."""
        half = self.bench.sensed.states[held].extent.half
        for f in self.scene.fixtures:
            if f.top_m < self.scene.robot_xyz_m[2] + 0.01:
                continue
            gap = max(abs(x - f.xyz_m[0]) - f.size_m[0] / 2 - half[0], abs(y - f.xyz_m[1]) - f.size_m[1] / 2 - half[1])
            if gap < _DROP_ROOM_M:
                return False
        here = Extent((x, y, 0.0), half)
        return all(here.gap_xy(s.extent) > _DROP_ROOM_M for _, s in self.bench.others(held))

    def _obstacle_at_place(self, due: _Pending, now: Moment) -> bool:
        """Onto the slot that the held thing is to go to."""
        if self._carries < due.occurrence or now.held is None:
            return False
        for slot in self._destinations(due, now):
            free = Condition("Free", (slot.id,))
            if free not in now.facts or slot.surface_m is None or not self._hand_away(slot.surface_m):
                continue
            if self._carried_ticks < due.delay and self._hand_away(slot.surface_m, _LAST_CHANCE_M):
                continue
            for body in sorted(self._parked(), key=lambda b: (b.size_m[2], b.id)):
                x, y, z = slot.surface_m
                state = lying_at(body, (x, y, z + body.size_m[2] / 2), 0.0)
                if self._can_stand(body, state, ()):
                    due.about, due.key = slot.id, free
                    self.bench.put(body.id, state.pose)
                    return True
        return False

    def _destinations(self, due: _Pending, now: Moment) -> Iterator[ScenePlace]:
        wanted = [g.args[1] for g in self.goals if g.name == "On" and g.args[0] == now.held and g not in now.facts]
        if now.action is not None and now.action.name == "place" and now.action.args[1] not in wanted:
            inside = set(self.scene.with_containers(now.action.args[1]))
            if inside & set(wanted):
                wanted.append(now.action.args[1])
        for id_ in wanted:
            place = self.scene.place(id_)
            if place.is_slot and due.target in (None, id_):
                yield place

    def _obstacle_at_pick(self, due: _Pending, now: Moment) -> bool:
        """Close beside a thing that is still to be taken."""
        if self._carries < due.occurrence:
            return False
        targets = [
            g.args[0]
            for g in self.goals
            if g.name == "On" and g not in now.facts and g.args[0] != now.held and due.target in (None, g.args[0])
        ]
        for target in self._shuffled(sorted(set(targets))):
            state = self.bench.sensed.states.get(target)
            clear = Condition("Clear", (target,))
            if state is None or clear not in now.facts or not self._hand_away(state.xyz):
                continue
            for body in sorted(self._parked(), key=lambda b: (-b.size_m[2], b.id)):
                for beside in self._beside(state, body):
                    if self._can_stand(body, beside, (target,)):
                        due.about, due.key = target, clear
                        self.bench.put(body.id, beside.pose)
                        return True
        return False

    def _beside(self, state: BodyState, body: Body) -> Iterator[BodyState]:
        """Poses of a body next to the faces of a thing, a few millimetres off."""
        yaw = math.remainder(yaw_from_quat(state.quat), math.pi / 2)
        across = min(state.extent.half[0], state.extent.half[1]) + body.size_m[0] / 2 + _BESIDE_M
        for side in self._shuffled([0, 1, 2, 3]):
            angle = yaw + side * math.pi / 2
            x = state.xyz[0] + across * math.cos(angle)
            y = state.xyz[1] + across * math.sin(angle)
            yield lying_at(body, (x, y, state.extent.bottom_m + body.size_m[2] / 2), yaw)

    def _placed_object_moved(self, due: _Pending, now: Moment) -> bool:
        """Something that is where it should be is put elsewhere: another slot, or a buffer."""
        placed = [g for g in self.goals if g.name == "On" and g in now.facts and g.args[0] in self._grasped]
        placed = [g for g in placed if g.args[0] != now.held and due.target in (None, g.args[0])]
        if len(placed) < (due.occurrence if due.target is None else 1):
            return False
        for goal in self._shuffled(placed):
            id_ = goal.args[0]
            body = self.bench.kinds[id_]
            for x, y, z in self._elsewhere(body, now):
                state = lying_at(body, (x, y, z + body.size_m[2] / 2), 0.0)
                if self._hand_away(state.xyz) and self._can_stand(body, state, ()):
                    due.about, due.key = id_, goal
                    self.bench.put(id_, state.pose)
                    return True
        return False

    def _elsewhere(self, body: Body, now: Moment) -> Iterator[Vec3]:
        """Free slots that nothing is to go to, and the roomiest spots of the buffers, in a drawn order."""
        wanted = {g.args[1] for g in self.goals if g.name == "On"}
        found: list[Vec3] = []
        for place in self.scene.places:
            if place.surface_m is None:
                continue
            if place.is_slot and place.id not in wanted and Condition("Free", (place.id,)) in now.facts:
                found.append(place.surface_m)
            elif place.buffer:
                keep_off = [s.extent for _, s in self.bench.others(body.id)]
                spots = self.approach.spots(place, max(body.size_m[:2]) / 2, keep_off)
                found += [(x, y, place.surface_m[2]) for x, y in spots[:6]]
        yield from self._shuffled(found)

    # ------------------------------------------------------------------ what may stand where

    def _parked(self) -> list[Body]:
        return [b for b in self.scene.obstacles if b.id not in self.bench.in_play]

    def _hand_away(self, xyz: Vec3, metres: float = _HAND_AWAY_M) -> bool:
        tip = self.bench.tip_xyz()
        return math.hypot(tip[0] - xyz[0], tip[1] - xyz[1]) > metres

    def _can_stand(self, body: Body, state: BodyState, blocks: tuple[str, ...]) -> bool:
        """Whether a body fits at a pose, can be taken from there, and then blocks just the bodies it is meant to."""
        held = self.bench.sensed.held
        states = dict(self.bench.others(body.id))
        approach = self.approach
        approach.mirror(states, without=held)
        if not approach.fits(body.id, state):
            return False
        others = [id_ for id_ in sorted(states) if id_ != held]
        before = {id_: approach.grasp(id_) for id_ in others}
        approach.mirror({**states, body.id: state}, without=held)
        if approach.grasp(body.id).grasp is None:
            return False
        for id_ in others:
            after = approach.grasp(id_)
            if id_ in blocks:
                if after.grasp is not None or after.blocker != body.id:
                    return False
            elif after.grasp is None and before[id_].grasp is not None:
                return False
        return True

    def _shuffled(self, items: list[_T]) -> list[_T]:
        return [items[i] for i in self.rng.permutation(len(items))]
