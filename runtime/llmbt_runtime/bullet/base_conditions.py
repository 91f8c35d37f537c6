"""The facts of a robot that drives: Near, and which locations there is a way to."""

from __future__ import annotations

from dataclasses import dataclass, field

from llmbt_ir.condition import Condition, Facts
from llmbt_runtime.bullet.bench import Sensed
from llmbt_runtime.bullet.bodies import BodyState, any_moved
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.navigation import Floor, Point
from llmbt_runtime.bullet.terrain import Terrain

__all__ = ["BaseConditions", "is_near"]

_NEAR_M, _NEAR_RAD = 0.05, 0.1
_STAYS_M, _STAYS_RAD = 0.08, 0.15


def is_near(base: BasePose, dock: BasePose, *, already: bool = False) -> bool:
    """Whether the base is at a docking pose: within 5 cm and 0.1 rad, wider to leave."""
    metres, radians = base.far_from(dock)
    if already:
        return metres <= _STAYS_M and radians <= _STAYS_RAD
    return metres <= _NEAR_M and radians <= _NEAR_RAD


@dataclass
class BaseConditions:
    """Reads them off what was sensed, tick by tick. `facts` is empty for a robot that is bolted down."""

    terrain: Terrain
    _near: str | None = None
    _ways: Facts = frozenset()
    _ways_at: tuple[int, dict[str, BodyState], int] | None = None
    _part_of_base: int = field(default=0)

    def near(self, sensed: Sensed, *, strict: bool = False) -> str | None:
        """The location that the robot is at."""
        if not self.terrain.drives:
            return None
        before = None if strict else self._near
        found = [
            (sensed.base.far_from(dock)[0], place)
            for place, docks in self.terrain.docks.of.items()
            for dock in docks
            if is_near(sensed.base, dock, already=place == before)
        ]
        place = min(found)[1] if found else None
        if not strict:
            self._near = place
        return place

    def ways(self, sensed: Sensed) -> Facts:
        """Clear of every location to which there is a way, and for the others what blocks it."""
        if not self.terrain.drives:
            return frozenset()
        lying = self.terrain.floor_bodies(sensed.states, sensed.held)
        floor = self.terrain.floor(sensed.states, sensed.held)
        here = (sensed.base.x_m, sensed.base.y_m)
        known = self._ways_at
        part = floor.part(here)
        if known is None or known[0] != self.terrain.stage.shifts or known[2] != part or any_moved(lying, known[1]):
            self._ways = self._judge(floor, here, tuple(sorted(lying)))
            self._ways_at = self.terrain.stage.shifts, lying, part
        return self._ways

    def _judge(self, floor: Floor, here: Point, lying: tuple[str, ...]) -> Facts:
        facts: set[Condition] = set()
        for place in self.terrain.docks.of:
            if self._accessible(floor, here, place):
                facts.add(Condition("Clear", (place,)))
                continue
            blocker = self._blocker(floor, here, place, lying)
            if blocker is not None:
                facts.add(Condition("Blocks", (blocker, place)))
        return frozenset(facts)

    def _accessible(self, floor: Floor, here: Point, place: str) -> bool:
        docks = self.terrain.docks[place]
        return any(floor.connected(here, (d.x_m, d.y_m)) for d in docks)

    def _blocker(self, floor: Floor, here: Point, place: str, lying: tuple[str, ...]) -> str | None:
        """One thing without which there is a way; else the first of those that all have to go."""
        for id_ in lying:
            if self._accessible(floor.without(id_), here, place):
                return id_
        if len(lying) > 1 and self._accessible(floor.without(*lying), here, place):
            return lying[0]
        return None
