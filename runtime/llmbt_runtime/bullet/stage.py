"""The scene as it is now: fixtures and places may be shifted from outside while everything else goes on."""

from __future__ import annotations

from dataclasses import dataclass, replace

from llmbt_ir.geometry import Vec3
from llmbt_ir.scene import Fixture, Scene, ScenePlace

__all__ = ["Stage"]


@dataclass
class Stage:
    """Holds the present scene for all parts of a world. `shifts` counts how often it has changed."""

    scene: Scene
    shifts: int = 0

    def shifted(self, place: str, dx_m: float, dy_m: float) -> Scene | None:
        """The scene with a place, the places that hang together with it, and the fixtures that move with those, pushed
        over the floor; None where nothing moves with the place."""
        group = self.group(place)
        if not any(f.moves_with in group for f in self.scene.fixtures):
            return None

        def pushed(xyz: Vec3) -> Vec3:
            return xyz[0] + dx_m, xyz[1] + dy_m, xyz[2]

        def place_of(p: ScenePlace) -> ScenePlace:
            moves = p.id in group and p.surface_m is not None
            return replace(p, surface_m=pushed(p.surface_m)) if moves and p.surface_m is not None else p

        def fixture_of(f: Fixture) -> Fixture:
            return replace(f, xyz_m=pushed(f.xyz_m)) if f.moves_with in group else f

        return replace(
            self.scene,
            fixtures=tuple(map(fixture_of, self.scene.fixtures)),
            places=tuple(map(place_of, self.scene.places)),
        )

    def group(self, place: str) -> frozenset[str]:
        """A place's outermost container and all that is in it."""
        *_, root = self.scene.with_containers(place)
        return frozenset(p.id for p in self.scene.places if root in self.scene.with_containers(p.id))

    def become(self, scene: Scene) -> None:
        """Another scene with the same ids."""
        self.scene = scene
        self.shifts += 1
