"""Where the robot can be: docking poses of the places, the floor as it is, and which poses reach a thing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from llmbt_ir.scene import Body, RobotModel, Scene
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.bodies import BodyState, any_moved
from llmbt_runtime.bullet.docking import Docks, around, find_docks
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.navigation import Floor, Footprint, Point, footprint_of
from llmbt_runtime.bullet.stage import Stage

__all__ = ["Terrain"]

States = Mapping[str, BodyState]


class Terrain:
    """For a robot that is bolted down: the one pose that it has, and no docking poses."""

    def __init__(self, stage: Stage, approach: Approach, kinds: Mapping[str, Body]) -> None:
        self.stage, self.approach, self._kinds = stage, approach, kinds
        self.drives = stage.scene.robot is RobotModel.MOBILE_PANDA
        self._docks: Docks | None = None
        self._docks_at = -1
        self._floor: Floor | None = None
        self._floor_at: tuple[int, dict[str, BodyState]] = (-1, {})

    @property
    def height_m(self) -> float:
        """Of the arm's base above the floor."""
        return self.stage.scene.robot_xyz_m[2]

    @property
    def docks(self) -> Docks:
        """The docking poses of the places where they are now."""
        if self._docks is None or self._docks_at != self.stage.shifts:
            self._docks = find_docks(self.stage.scene, self.approach) if self.drives else Docks({})
            self._docks_at = self.stage.shifts
        return self._docks

    def floor_bodies(self, states: States, held: str | None) -> dict[str, BodyState]:
        """The movable bodies that the platform could run into."""
        return {id_: s for id_, s in states.items() if id_ != held and s.extent.bottom_m < self.height_m - 0.02}

    def floor(self, states: States, held: str | None) -> Floor:
        """The floor as it is now."""
        lying = self.floor_bodies(states, held)
        shifts, before = self._floor_at
        if self._floor is None or shifts != self.stage.shifts or any_moved(lying, before):
            prints: list[Footprint] = [footprint_of(self._kinds[id_], s) for id_, s in sorted(lying.items())]
            self._floor = Floor.of(self.stage.scene, prints)
            self._floor_at = self.stage.shifts, lying
        return self._floor

    def would_reach(self, scene: Scene, place: str, states: States, held: str | None, here: Point) -> bool:
        """Whether in another scene, of the same things, there is a docking pose of a place, and a way to it."""
        docks = find_docks(scene, self.approach, only=place)[place]
        bodies = self.floor_bodies(states, held)
        floor = Floor.of(scene, [footprint_of(self._kinds[id_], s) for id_, s in sorted(bodies.items())])
        return any(floor.connected(here, (d.x_m, d.y_m)) for d in docks)

    def poses_for(self, state: BodyState, places: frozenset[str], floor: Floor, base: BasePose) -> Iterator[BasePose]:
        """From where a thing may be taken: the docking poses of the place that it is on, or else all around it."""
        if not self.drives:
            yield base
            return
        docked = [d for p in sorted(places) for d in self.docks[p]]
        if docked:
            yield from docked
        else:
            yield from around(state.xyz, self.height_m, floor, (base.x_m, base.y_m))
