"""What the disturbances do to bodies: the fingers slip, things are put in the way, taken or moved, a place is pushed.

An obstacle stands where it can be taken from, and blocks just what it is meant to; what is moved can be taken again.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.geometry import Vec3, yaw_from_quat
from llmbt_ir.scene import MAX_GRASP_M, Body, Scene, ScenePlace
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.bench import Bench
from llmbt_runtime.bullet.bodies import BodyState, Extent, lying_at
from llmbt_runtime.bullet.grasping import Verdict
from llmbt_runtime.bullet.judging import Judge
from llmbt_runtime.bullet.navigation import footprint_of
from llmbt_runtime.bullet.spots import free_spots, has_room, small_half_m
from llmbt_runtime.bullet.stage import Stage
from llmbt_runtime.bullet.terrain import Terrain

__all__ = ["Carry", "Draw", "Interventions", "Struck"]

_T = TypeVar("_T")
Struck = tuple[str, Condition | None]
"""What a disturbance is about, and the fact that it breaks."""

_HAND_AWAY_M, _LAST_CHANCE_M = 0.20, 0.32
_BASE_AWAY_M = 0.75
_BESIDE_M = (0.004, 0.001)
_DROP_AT_LEAST, _DROP_PATIENCE = 0.12, 0.20
"""Parts of the way over: when one is overdue; after the second a thing is dropped wherever it falls."""
_DROP_ROOM_M, _DROP_FLOOR_ROOM_M = 0.035, 0.30
_DROP_OFF_GOAL_M = 0.09
_SHELF_SHIFT_M = 0.05
_FURTHER_M = (0.15, 0.35, 0.05, 0.25)
_SPOTS_TRIED = 6


@dataclass(frozen=True, slots=True)
class Draw:
    """What was drawn for a disturbance: the carry at which a thing is dropped, or the number of grasps (of things in
    place) from which on it may come; its target, or None for any; the share of the way over at which a thing is
    dropped; for how many ticks a thing has been carried before its slot is taken."""

    occurrence: int
    target: str | None
    drop_at: float
    delay: int


@dataclass(frozen=True, slots=True)
class Carry:
    """The run as far as it matters to what may be done to it: the facts, what is held and how far it has been carried
    over, the action that runs, how many carries there have been, what has been in the hand so far."""

    facts: Facts
    held: str | None
    action: ActionCall | None
    transfer: float | None
    number: int = 0
    ticks: int = 0
    grasped: tuple[str, ...] = ()


@dataclass
class Interventions:
    """Hands that come from outside. `goals` say what is still to be done."""

    stage: Stage
    bench: Bench
    approach: Approach
    judge: Judge
    terrain: Terrain
    goals: tuple[Condition, ...]
    rng: np.random.Generator

    @property
    def scene(self) -> Scene:
        """The scene as it is now."""
        return self.stage.scene

    @staticmethod
    def carry(facts: Facts, held: str | None, action: ActionCall | None, transfer: float | None) -> Carry:
        """A moment of a run."""
        return Carry(facts, held, action, transfer)

    def strike(self, name: str, draw: Draw, now: Carry) -> Struck | None:
        """Do it, if this is the moment; None where it is not."""
        match name:
            case "drop":
                return self._drop(draw, now)
            case "obstacle_at_place":
                return self._obstacle_at_place(draw, now)
            case "obstacle_at_pick":
                return self._obstacle_at_pick(draw, now)
            case "placed_object_moved":
                return self._placed_object_moved(draw, now)
            case "object_moved":
                return self._object_moved(draw, now)
            case "object_taken":
                return self._object_taken(draw, now)
            case "base_blocked":
                return self._base_blocked(draw, now)
            case "destination_shifted":
                return self._destination_shifted(draw, now)
            case _:
                return self._impossible(draw, now)

    # ------------------------------------------------------------------ a drop

    def _drop(self, due: Draw, now: Carry) -> Struck | None:
        """On the way over, so that it falls where there is room if that can be, and never onto its goal."""
        if now.number < due.occurrence or now.held is None or now.transfer is None:
            return None
        if due.target is not None and now.held != due.target:
            return None
        if sorted(self.bench.kinds[now.held].size_m)[1] > MAX_GRASP_M:
            return None  # it might come to lie so that the gripper does not close on it
        x, y = self._landing(now.held)
        mine = [g for g in self.goals if g.name == "On" and g.args[0] == now.held]
        wanted = [self.scene.place(g.args[1]).surface_m for g in mine]
        if any(w is not None and math.hypot(x - w[0], y - w[1]) < _DROP_OFF_GOAL_M for w in wanted):
            return None
        drop_at = due.drop_at if now.number == max(1, due.occurrence) else _DROP_AT_LEAST  # overdue: as soon as may be
        anywhere = now.transfer >= drop_at + _DROP_PATIENCE and not self.terrain.drives
        if now.transfer < drop_at or not (anywhere or self._room_at(now.held, x, y)):
            return None
        self.bench.slip()
        return now.held, Condition("Holding", (now.held,))

    def _ground_m(self) -> float:
        """The height at which things come down: a bench's for an arm that is bolted to it."""
        return 0.0 if self.terrain.drives else self.scene.robot_xyz_m[2]

    def _landing(self, held: str) -> tuple[float, float]:
        """Where a held thing would come down if it were let go now, by its speed and height."""
        state = self.bench.sensed.states[held]
        vx, vy = self.bench.velocity(held)[:2]
        height = max(0.0, state.extent.bottom_m - self._ground_m())
        seconds = math.sqrt(2 * height / 9.81)
        return state.xyz[0] + vx * seconds, state.xyz[1] + vy * seconds

    def _room_at(self, held: str, x: float, y: float) -> bool:
        """Whether a thing that comes down there meets neither a fixture that stands out nor another thing."""
        half = self.bench.sensed.states[held].extent.half
        room = _DROP_FLOOR_ROOM_M if self.terrain.drives else _DROP_ROOM_M
        for f in self.scene.fixtures:
            if f.top_m < self._ground_m() + 0.01:
                continue
            gap = max(abs(x - f.xyz_m[0]) - f.size_m[0] / 2 - half[0], abs(y - f.xyz_m[1]) - f.size_m[1] / 2 - half[1])
            if gap < room:
                return False
        here = Extent((x, y, 0.0), half)
        return all(here.gap_xy(s.extent) > _DROP_ROOM_M for _, s in self.bench.others(held))

    # ------------------------------------------------------------------ obstacles

    def _obstacle_at_place(self, due: Draw, now: Carry) -> Struck | None:
        """Where the held thing is to go: onto its slot, or so that its region has no room left."""
        if now.number < due.occurrence or now.held is None:
            return None
        for place in self._destinations(due, now):
            free = Condition("Free", (place.id,))
            if free not in now.facts or place.surface_m is None or not self._hand_away(place.surface_m):
                continue
            if now.ticks < due.delay and self._hand_away(place.surface_m, _LAST_CHANCE_M):
                continue
            for body in sorted(self._parked(), key=lambda b: (b.size_m[2], b.id)):
                for state in self._filling(place, body, now.held):
                    if self._can_stand(body, state, ()):
                        self.bench.put(body.id, state.pose)
                        return place.id, free
        return None

    def _filling(self, place: ScenePlace, body: Body, held: str) -> Iterator[BodyState]:
        """Poses of an obstacle after which a place has no room."""
        assert place.surface_m is not None
        x, y, z = place.surface_m
        if place.is_slot:
            yield lying_at(body, (x, y, z + body.size_m[2] / 2), 0.0)
            return
        for yaw in (math.pi / 2, 0.0):
            state = lying_at(body, (x, y, z + body.size_m[2] / 2), yaw)
            lying = [s.extent for _, s in self.bench.others(held, body.id)]
            small = small_half_m(drives=self.terrain.drives)
            room = free_spots(place, small, [*lying, state.extent], self.scene.fixtures, None)
            if not room and self._fits_on(body, but=place.id):
                yield state

    def _has_room(self, place: ScenePlace, body: Body) -> bool:
        """Whether a thing could be put down somewhere on a region, one way round or the other."""
        lying = [s.extent for _, s in self.bench.others(body.id)]
        return has_room(place, body.size_m, lying, self.scene.fixtures)

    def _fits_on(self, body: Body, only: str | None = None, but: str | None = None) -> bool:
        """Whether there is a place that an obstacle can be put aside on, of all, `but` one, or `only` one; the floor is
        none."""
        places = [p for p in self.scene.places if p.surface_m is not None and p.id != but and only in (None, p.id)]
        return any(self._has_room(p, body) for p in places)

    def _destinations(self, due: Draw, now: Carry) -> Iterator[ScenePlace]:
        """Where the held thing is to go, as far as one obstacle can take the room."""
        wanted = [g.args[1] for g in self.goals if g.name == "On" and g.args[0] == now.held and g not in now.facts]
        if now.action is not None and now.action.name == "place" and now.action.args[1] not in wanted:
            inside = set(self.scene.with_containers(now.action.args[1]))
            if inside & set(wanted):
                wanted.append(now.action.args[1])
        for id_ in wanted:
            place = self.scene.place(id_)
            if (place.is_slot or self.terrain.drives) and due.target in (None, id_, now.held):
                yield place

    def _obstacle_at_pick(self, due: Draw, now: Carry) -> Struck | None:
        """Close beside a thing that is still to be taken."""
        if now.number < due.occurrence or not self._under_way(now):
            return None
        for target in self._shuffled(self._still_to_take(due, now)):
            state = self.bench.sensed.states.get(target)
            clear = Condition("Clear", (target,))
            if state is None or clear not in now.facts or not self._hand_away(state.xyz):
                continue
            here = self._where(target, now.facts)
            bodies = sorted(self._parked(), key=lambda b: (-b.size_m[2], b.id))
            if self.terrain.drives:  # put aside where it stands
                bodies = [b for b in bodies if here is not None and self._fits_on(b, only=here)]
            for body in bodies:
                for beside in self._beside(state, body):
                    if self._can_stand(body, beside, (target,)):
                        self.bench.put(body.id, beside.pose)
                        return target, clear
        return None

    def _beside(self, state: BodyState, body: Body) -> Iterator[BodyState]:
        """Poses of a body next to the faces and the edges of a thing, a few millimetres off."""
        yaw = math.remainder(yaw_from_quat(state.quat), math.pi / 2)
        half = min(state.extent.half[0], state.extent.half[1])
        sides = [(0.0, half + _BESIDE_M[0])]
        if self.terrain.drives:
            sides = [(math.pi / 4, math.hypot(half, half) + gap) for gap in _BESIDE_M] + [(0.0, half + _BESIDE_M[1])]
        for turn, reach in sides:
            for side in self._shuffled([0, 1, 2, 3]):
                angle = yaw + turn + side * math.pi / 2
                across = reach + body.size_m[0] / 2
                x, y = state.xyz[0] + across * math.cos(angle), state.xyz[1] + across * math.sin(angle)
                facing = angle if turn or self.terrain.drives else yaw
                yield lying_at(body, (x, y, state.extent.bottom_m + body.size_m[2] / 2), facing)

    # ------------------------------------------------------------------ things that move

    def _still_to_take(self, due: Draw, now: Carry) -> list[str]:
        """The things that goals are about and that are not held, nor where they should be."""
        targets = {
            g.args[0]
            for g in self.goals
            if g.name == "On" and g not in now.facts and g.args[0] != now.held and due.target in (None, g.args[0])
        }
        return sorted(targets)

    def _under_way(self, now: Carry) -> bool:
        """Before its first grasp, a robot that drives is under way while it does."""
        return now.number > 0 or (now.action is not None and not self.bench.base.arrived)

    def _placed_object_moved(self, due: Draw, now: Carry) -> Struck | None:
        """Something that is where it should be is put elsewhere: another slot, or a buffer."""
        placed = [g for g in self.goals if g.name == "On" and g in now.facts and g.args[0] in now.grasped]
        placed = [g for g in placed if g.args[0] != now.held and due.target in (None, g.args[0])]
        if len(placed) < (due.occurrence if due.target is None else 1):
            return None
        for goal in self._shuffled(placed):
            if self._put_elsewhere(goal.args[0], goal.args[1], now):
                return goal.args[0], goal
        return None

    def _object_moved(self, due: Draw, now: Carry) -> Struck | None:
        """Something that is still to be taken is put onto another place."""
        if now.number < due.occurrence or not self._under_way(now):
            return None
        for target in self._shuffled(self._still_to_take(due, now)):
            state, here = self.bench.sensed.states.get(target), self._where(target, now.facts)
            if state is None or here is None or not self._hand_away(state.xyz) or self._handled(target, now):
                continue
            if self._put_elsewhere(target, here, now):
                return target, Condition("On", (target, here))
        return None

    def _put_elsewhere(self, id_: str, here: str, now: Carry) -> bool:
        body = self.bench.kinds[id_]
        for x, y, z in self._elsewhere(body, here, now):
            state = lying_at(body, (x, y, z + body.size_m[2] / 2), 0.0)
            if self._hand_away(state.xyz) and self._can_stand(body, state, ()):
                self.bench.put(id_, state.pose)
                return True
        return False

    def _elsewhere(self, body: Body, here: str, now: Carry) -> Iterator[Vec3]:
        """Free slots that nothing is to go to, and the roomiest spots of other regions, in a drawn order."""
        wanted = {g.args[1] for g in self.goals if g.name == "On"}
        found: list[Vec3] = []
        for place in self.scene.places:
            if place.surface_m is None or place.id == here:
                continue
            if place.is_slot and place.id not in wanted and Condition("Free", (place.id,)) in now.facts:
                found.append(place.surface_m)
            elif place.buffer or (self.terrain.drives and place.id not in wanted):
                keep_off = [s.extent for _, s in self.bench.others(body.id)]
                frame = None if self.terrain.drives else self.bench.base.pose
                half = max(body.size_m[:2]) / 2
                spots = free_spots(place, (half, half), keep_off, self.scene.fixtures, frame)
                found += [(x, y, place.surface_m[2]) for x, y in spots[:_SPOTS_TRIED]]
        yield from self._shuffled(found)

    def _object_taken(self, due: Draw, now: Carry) -> Struck | None:
        """Something that is still to be taken is carried off, for good."""
        if now.number < due.occurrence or not self._under_way(now):
            return None
        for target in self._shuffled(self._still_to_take(due, now)):
            state, here = self.bench.sensed.states.get(target), self._where(target, now.facts)
            if state is not None and here is not None and self._hand_away(state.xyz) and not self._handled(target, now):
                self.bench.park(target)
                return target, Condition("On", (target, here))
        return None

    # ------------------------------------------------------------------ the base, the places

    def _base_blocked(self, due: Draw, now: Carry) -> Struck | None:
        """Things on the floor before every pose from which a place is reached, until there is no way there."""
        if now.number < due.occurrence or not self.terrain.drives or not self._under_way(now):
            return None
        return self._close_off(due, now, movable=True)

    def _impossible(self, due: Draw, now: Carry) -> Struck | None:
        """What nobody can move stands on the slot that a thing is to go to, or before the only ways to its place."""
        if now.number < due.occurrence:
            return None
        if self.terrain.drives:
            return self._close_off(due, now, movable=False)
        for place in self._destinations(due, now):
            free = Condition("Free", (place.id,))
            if free not in now.facts or place.surface_m is None or not self._hand_away(place.surface_m):
                continue
            for body in self._parked(movable=False):
                x, y, z = place.surface_m
                state = lying_at(body, (x, y, z + body.size_m[2] / 2), 0.0)
                self._mirror(without=now.held)
                if self.approach.fits(body.id, state):
                    self.bench.put(body.id, state.pose)
                    return place.id, free
        return None

    def _close_off(self, due: Draw, now: Carry, *, movable: bool) -> Struck | None:
        for place in self._next_places(due, now):
            clear, near = Condition("Clear", (place,)), Condition("Near", (place,))
            if clear not in now.facts or near in now.facts:
                continue
            put = self._barrier(place, now, movable)
            for body, state in put:
                self.bench.put(body.id, state.pose)
            if put:
                return place, clear
        return None

    def _next_places(self, due: Draw, now: Carry) -> list[str]:
        """Where the robot goes next: with the held thing, or else for one that is still to be taken."""
        if now.held is not None:
            found = [g.args[1] for g in self.goals if g.name == "On" and g.args[0] == now.held and g not in now.facts]
        else:
            open_goals = [g for g in self.goals if g.name == "On" and g not in now.facts]
            where = (self._where(g.args[0], now.facts) for g in open_goals)
            found = [p for p in where if p is not None]
            found += [g.args[1] for g in open_goals]
        return [p for p in dict.fromkeys(found) if due.target in (None, p)]

    def _barrier(self, place: str, now: Carry, movable: bool) -> list[tuple[Body, BodyState]]:
        """Parked bodies, and where to put them so that there is no way to a place; none where they do not suffice."""
        base = self.bench.base.pose
        here, docks = (base.x_m, base.y_m), self.terrain.docks[place]
        floor = self.terrain.floor(self.bench.sensed.states, now.held)
        put: list[tuple[Body, BodyState]] = []
        for body in sorted(self._parked(movable=movable), key=lambda b: (-b.size_m[1], b.id)):
            left = [d for d in docks if floor.connected(here, (d.x_m, d.y_m))]
            if not left:
                break
            dock = left[0]
            if math.dist(here, (dock.x_m, dock.y_m)) < _BASE_AWAY_M:
                return []
            state = lying_at(body, (dock.x_m, dock.y_m, body.size_m[2] / 2), dock.yaw_rad)
            put.append((body, state))
            floor = floor.with_(footprint_of(body, state))
        closed = not any(floor.connected(here, (d.x_m, d.y_m)) for d in docks)
        return put if closed else []

    def _destination_shifted(self, due: Draw, now: Carry) -> Struck | None:
        """A place where something has been put, or where the robot stands with what it brings, is pushed away."""
        goals = [g for g in self.goals if g.name == "On" and due.target in (None, *g.args)]
        placed = [g for g in goals if g in now.facts and g.args[0] in now.grasped]
        near = [g for g in goals if g.args[0] == now.held and Condition("Near", (g.args[1],)) in now.facts]
        keys = placed if len(placed) >= max(1, due.occurrence) else []
        for key in (*self._shuffled(keys), *near):
            place = self.scene.place(key.args[1])
            if place.surface_m is None or not (self.terrain.drives or self._hand_away(place.surface_m)):
                continue
            for dx, dy in self._pushes(place):
                pushed = self.stage.shifted(place.id, dx, dy)
                if pushed is not None and self._serves(pushed, place.id, now.held):
                    self._shift(pushed)
                    return place.id, key if key in now.facts else Condition("Near", (place.id,))
        return None

    def _pushes(self, place: ScenePlace) -> list[tuple[float, float]]:
        if place.is_slot:
            return self._shuffled([(0.0, _SHELF_SHIFT_M), (0.0, -_SHELF_SHIFT_M)])
        x, y = place.size_m
        along = [(s * (x + more), 0.0) for more in _FURTHER_M for s in (1, -1)]
        return self._shuffled([*along, *((0.0, s * (y + more)) for more in _FURTHER_M for s in (1, -1))])

    def _serves(self, pushed: Scene, place: str, held: str | None) -> bool:
        """Whether all of a pushed place is on something, clear of other places, and can be reached."""
        if not self.terrain.drives:
            return self._slots_in_reach(pushed)
        here = pushed.place(place)
        assert here.surface_m is not None
        x, y, z = here.surface_m
        hx, hy = here.size_m[0] / 2, here.size_m[1] / 2
        tops = [f for f in pushed.fixtures if abs(f.top_m - z) < 0.01]
        on = all(
            any(
                abs(x + i * hx - f.xyz_m[0]) <= f.size_m[0] / 2 and abs(y + j * hy - f.xyz_m[1]) <= f.size_m[1] / 2
                for f in tops
            )
            for i in (-1, 1)
            for j in (-1, 1)
        )
        apart = all(
            max(abs(x - q[0]) - hx - p.size_m[0] / 2, abs(y - q[1]) - hy - p.size_m[1] / 2) > 0.02
            for p in pushed.places
            if p.id != place and (q := p.surface_m) is not None
        )
        if not (on and apart):
            return False
        base, states = self.bench.base.pose, self.bench.sensed.states
        return self.terrain.would_reach(pushed, place, states, held, (base.x_m, base.y_m))

    def _slots_in_reach(self, pushed: Scene) -> bool:
        base = self.bench.base.pose
        slots = [p.surface_m for p in pushed.places if p.is_slot and p.surface_m is not None]
        return self.approach.reaches(base, [(x, y, z + 0.12) for x, y, z in slots])

    def _shift(self, pushed: Scene) -> None:
        self.stage.become(pushed)
        self.bench.move_fixtures(pushed)
        self.approach.move_fixtures()
        self.bench.surprises += 1

    # ------------------------------------------------------------------ what may stand where

    def _where(self, id_: str, facts: Facts) -> str | None:
        """The most specific place that a thing is on."""
        found = sorted(f.args[1] for f in facts if f.name == "On" and f.args[0] == id_)
        return max(found, key=self.scene.depth, default=None)

    @staticmethod
    def _handled(id_: str, now: Carry) -> bool:
        """Whether the running action is about a thing that the hand may be over by now."""
        return now.action is not None and now.action.name != "navigate" and id_ in now.action.args

    def _parked(self, *, movable: bool = True) -> list[Body]:
        return [b for b in self.scene.obstacles if b.id not in self.bench.in_play and b.movable is movable]

    def _hand_away(self, xyz: Vec3, metres: float = _HAND_AWAY_M) -> bool:
        tip = self.bench.tip_xyz()
        return math.hypot(tip[0] - xyz[0], tip[1] - xyz[1]) > metres

    def _mirror(self, without: str | None) -> None:
        self.approach.stand_at(self.bench.base.pose)
        self.approach.mirror(self.bench.sensed.states, without=without)

    def _can_stand(self, body: Body, state: BodyState, blocks: tuple[str, ...]) -> bool:
        """Whether a body fits at a pose, can be taken from there, and then blocks just the bodies it is meant to."""
        held = self.bench.sensed.held
        states = dict(self.bench.others(body.id))
        self._mirror(without=held)
        self.approach.mirror(states, without=held)
        if not self.approach.fits(body.id, state):
            return False
        others = [id_ for id_ in sorted(states) if id_ != held and self._is_near(states[id_], state, body)]
        before = {id_: self._verdict(id_, states) for id_ in others}
        after_states: Mapping[str, BodyState] = {**states, body.id: state}
        self.approach.mirror(after_states, without=held)
        if self._verdict(body.id, after_states).grasp is None:
            return False
        for id_ in others:
            after = self._verdict(id_, after_states)
            if id_ in blocks:
                if after.grasp is not None or after.blocker != body.id:
                    return False
            elif after.grasp is None and before[id_].grasp is not None:
                return False
        return True

    def _is_near(self, other: BodyState, state: BodyState, body: Body) -> bool:
        """Whether a body may change how another is approached: where it comes from counts, too."""
        if not self.terrain.drives:
            return True
        places = [state, *([self.bench.sensed.states[body.id]] if body.id in self.bench.sensed.states else [])]
        return any(math.dist(other.xyz[:2], s.xyz[:2]) < 0.6 for s in places)

    def _verdict(self, id_: str, states: Mapping[str, BodyState]) -> Verdict:
        """Whether a thing could be taken in a world that is mirrored."""
        state = states[id_]
        x, y, _ = state.xyz
        place = self.scene.most_specific(x, y, state.extent.bottom_m)
        places = frozenset(self.scene.with_containers(place)) if place is not None else frozenset[str]()
        return self.judge.verdict(id_, states, self.bench.sensed.held, self.bench.base.pose, places)

    def _shuffled(self, items: list[_T]) -> list[_T]:
        return [items[i] for i in self.rng.permutation(len(items))]
