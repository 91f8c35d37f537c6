"""The facts of the shipped libraries, read off the physics.

Two readings of one world: `strict`, for scoring, where a fact holds or not by this tick alone; and the settled one for
a tree, where what holds is kept by wider bounds than those by which it comes to hold, so that a brush changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from llmbt_ir.condition import Condition, Facts
from llmbt_ir.scene import SUPPORT_TOLERANCE_M, Body, Scene, ScenePlace
from llmbt_runtime.bullet.base_conditions import BaseConditions
from llmbt_runtime.bullet.bench import Sensed
from llmbt_runtime.bullet.bodies import BodyState, Extent, any_moved, overlap
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.judging import Judge
from llmbt_runtime.bullet.spots import free_spots, small_half_m
from llmbt_runtime.bullet.stage import Stage

__all__ = ["Conditions", "Reading"]

_KEEP_HEIGHT_M = 0.015
_KEEP_XY_M = 0.005
_STILL_TICKS = 3
"""What has been at rest for so long is where it is: no wider bounds."""
_SLOT_SPACE_M = 0.06
_BESIDE_M = 0.1


@dataclass(frozen=True, slots=True)
class Reading:
    """The facts of one tick. `at_rest`: nothing moves but what is held."""

    strict: Facts
    settled: Facts
    at_rest: bool


@dataclass
class Conditions:
    """Reads facts off what was sensed, tick by tick."""

    stage: Stage
    kinds: dict[str, Body]
    judge: Judge
    base: BaseConditions
    _on: dict[str, frozenset[str]] = field(default_factory=dict)
    _still: dict[str, int] = field(default_factory=dict)
    _space_at: dict[str, BodyState] = field(default_factory=dict)
    _space_held: str | None = None
    _free: Facts = frozenset()
    _denied: dict[Condition, dict[str, BodyState]] = field(default_factory=dict)
    _crowd: dict[str, tuple[str, ...]] = field(default_factory=dict)
    _arranged_at: int = -1
    _containers: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._arrange()

    @property
    def scene(self) -> Scene:
        """The scene as it is now."""
        return self.stage.scene

    def _arrange(self) -> None:
        """Where the places are now."""
        if self._arranged_at == self.stage.shifts:
            return
        self._arranged_at = self.stage.shifts
        self._space_at = {}
        self._containers = {p.id: tuple(self.scene.with_containers(p.id)) for p in self.scene.places}
        self._surfaces = [p for p in self.scene.places if p.surface_m is not None]
        self._surfaces.sort(key=self.scene.precedence)
        self._spaces = {
            p.id: Extent(
                (p.surface_m[0], p.surface_m[1], p.surface_m[2] + _SLOT_SPACE_M / 2),
                (p.size_m[0] / 2, p.size_m[1] / 2, _SLOT_SPACE_M / 2 - 0.002),
            )
            for p in self._surfaces
            if p.is_slot and p.surface_m is not None
        }

    def read(self, sensed: Sensed) -> Reading:
        """The facts of this tick."""
        self._arrange()
        at_rest = all(s.at_rest for id_, s in sensed.states.items() if id_ != sensed.held)
        hand = self._hand(sensed)
        strict, settled = set(hand), set(hand)
        for id_, state in sensed.states.items():
            if id_ == sensed.held:
                self._on[id_] = frozenset()
                continue
            now = self._places_of(id_, state, sensed, before=frozenset())
            kept = self._places_of(id_, state, sensed, before=self._on.get(id_, frozenset()))
            self._still[id_] = self._still.get(id_, 0) + 1 if state.at_rest else 0
            if self._still[id_] >= _STILL_TICKS:
                kept = now
            self._on[id_] = kept
            strict.update(Condition("On", (id_, p)) for p in now)
            settled.update(Condition("On", (id_, p)) for p in kept)
            fallen = Condition("Fallen", (id_,))
            if state.at_rest and not now:
                strict.add(fallen)
                if not kept:
                    settled.add(fallen)
        shared = self._space(sensed) | self.judge.facts(sensed, self._on, at_rest=at_rest) | self.base.ways(sensed)
        for facts, near in ((strict, self.base.near(sensed, strict=True)), (settled, self.base.near(sensed))):
            facts.update({Condition("Near", (near,))} if near is not None else ())
        strict.update(self._obstructs(strict))
        settled.update(self._obstructs(settled))
        return Reading(frozenset(strict) | shared, frozenset(settled) | shared, at_rest)

    @staticmethod
    def _hand(sensed: Sensed) -> Facts:
        """At most one of HandEmpty, Holding, Touching."""
        if sensed.held is not None:
            return frozenset({Condition("Holding", (sensed.held,))})
        if sensed.touched:
            return frozenset({Condition("Touching", (sensed.touched[0][0],))})
        return frozenset({Condition("HandEmpty")})

    # ------------------------------------------------------------------ On

    def _places_of(self, id_: str, state: BodyState, sensed: Sensed, before: frozenset[str]) -> frozenset[str]:
        """The places that a body is on, the most specific and its containers."""
        still = bool(before)
        if id_ not in sensed.supported or not state.upright(self.kinds[id_].shape, still=still):
            return frozenset()
        if not still and not state.at_rest:
            return frozenset()
        x, y, _ = state.xyz
        for place in self._surfaces:
            assert place.surface_m is not None
            known = place.id in before
            height = _KEEP_HEIGHT_M if known else SUPPORT_TOLERANCE_M
            if abs(state.extent.bottom_m - place.surface_m[2]) > height:
                continue
            if place.covers(x, y, _KEEP_XY_M if known else 0.0):
                return frozenset(self._containers[place.id])
        return frozenset()

    # ------------------------------------------------------------------ Free

    def _space(self, sensed: Sensed) -> Facts:
        """Free slots, and regions with room for one more block."""
        lying = {id_: s for id_, s in sensed.states.items() if id_ != sensed.held}
        if sensed.held != self._space_held or any_moved(lying, self._space_at):
            extents = [s.extent for s in lying.values()]
            free: set[Condition] = set()
            self._crowd = {}
            for place in self._surfaces:
                if place.is_slot:
                    within = tuple(id_ for id_, s in sorted(lying.items()) if overlap(self._spaces[place.id], s.extent))
                    if within:
                        self._crowd[place.id] = within
                    else:
                        free.add(Condition("Free", (place.id,)))
                elif self._takes_many(place) and self._has_room(place, extents):
                    free.add(Condition("Free", (place.id,)))
            self._free = frozenset(free) - self._still_denied(sensed)
            self._space_at, self._space_held = lying, sensed.held
        return self._free

    def deny(self, free: Condition, sensed: Sensed) -> None:
        """A place has no room after all, for what a skill held over it: so it is until something moves there."""
        self._denied[free] = self._around(free.args[0], sensed)
        self._free = self._free - {free}

    def _still_denied(self, sensed: Sensed) -> Facts:
        self._denied = {c: at for c, at in self._denied.items() if not any_moved(self._around(c.args[0], sensed), at)}
        return frozenset(self._denied)

    def _around(self, id_: str, sensed: Sensed) -> dict[str, BodyState]:
        """What lies on a place or beside it."""
        place = self.scene.place(id_)
        lying = ((i, s) for i, s in sensed.states.items() if i != sensed.held)
        return {i: s for i, s in lying if place.covers(s.xyz[0], s.xyz[1], _BESIDE_M)}

    def _has_room(self, place: ScenePlace, extents: list[Extent]) -> bool:
        """Whether a small thing could be put down somewhere on a region, in reach where the robot cannot drive.

        It does not ask for what is held, or the fact would come and go with every grasp.
        """
        drives = self.judge.terrain.drives
        frame = None if drives else BasePose.of_scene(self.scene)
        return bool(free_spots(place, small_half_m(drives=drives), extents, self.scene.fixtures, frame))

    def _obstructs(self, facts: Iterable[Condition]) -> Facts:
        """Of each slot that holds nothing and is not free, one thing that reaches into it."""
        on = {c.args for c in facts if c.name == "On"}
        return frozenset(
            Condition("Obstructs", (within[0], slot))
            for slot, within in self._crowd.items()
            if not any((id_, slot) in on for id_ in within)
        )

    def _takes_many(self, place: ScenePlace) -> bool:
        """Whether things lie anywhere on it: it contains no slots."""
        return not any(p.is_slot and place.id in self._containers[p.id] for p in self.scene.places)
