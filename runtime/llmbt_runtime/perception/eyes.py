"""A robot's eyes: what is known by looking. Recognition is handed in, as a function.

A glance takes small pictures and says whether something has changed; a look takes full ones and recognises what they
show. When to do which is for whoever has the eyes to say.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

from llmbt_ir.capture import Capture
from llmbt_ir.geometry import Pose
from llmbt_ir.scene import Scene
from llmbt_ir.semantic_map import SemanticMap
from llmbt_ir.workspace import workspace
from llmbt_runtime.perception.belief import Sight, Standing, Thing, looked_for, revised, sight_of
from llmbt_runtime.perception.rgbd import cloud_of
from llmbt_runtime.perception.sensors import Sensors, capture_of
from llmbt_runtime.perception.watch import Box, Watch

__all__ = ["Eyes", "Recognise"]

Recognise = Callable[[Capture, Scene, SemanticMap | None], SemanticMap]
"""A capture, the scene as it is declared, and the map before, to the map of what is seen."""

_GLANCE_SCALE = 0.25
_MOVED_M = 0.004


@dataclass
class Eyes:
    """`things`: what is known of each declared thing. `looks` counts looks, `changes` those after which something was
    not where it had been."""

    sensors: Sensors
    recognise: Recognise
    scene: Callable[[], Scene]
    things: dict[str, Thing] = field(default_factory=dict)
    looks: int = 0
    changes: int = 0
    _watch: Watch = field(default_factory=Watch)

    def open(self) -> None:
        """Forget everything, and look: whatever the scene has in play is unseen until it is found."""
        self.things = {o.id: Thing(Standing.UNSEEN) for o in self.scene().objects}
        self._watch = Watch()
        self.looks = self.changes = 0
        self.look()

    def glance(self, but: Iterable[Box] = ()) -> bool:
        """Whether something has changed since the last glance, outside of the robot and some boxes."""
        images = [self.sensors.look(c, _GLANCE_SCALE) for c in self.sensors.cameras]
        return self._watch.changed(images, self.sensors.robot(), but)

    def look(self, held: str | None = None, but: Iterable[Box] = ()) -> None:
        """Recognise what all cameras show now. What is `held` keeps its pose, which the hand knows better, unless it is
        seen to have slipped."""
        scene = self.scene()
        images = tuple(self.sensors.look(c) for c in self.sensors.cameras)
        capture = capture_of(self.sensors, {i.camera.id: cloud_of(i, workspace(scene)) for i in images})
        before = self.things
        found = self.recognise(capture, scene, self._map(scene))
        declared = {b.id for b in (*scene.objects, *scene.obstacles)}
        found = replace(found, objects=tuple(o for o in found.objects if o.id in declared))
        self.things = revised(before, found, lambda o: Sight.HIDDEN if o.id == held else sight_of(o, images))
        self.looks += 1
        self.changes += any(_moved(self.things[id_], before.get(id_)) for id_ in self.things if id_ != held)
        self.glance(but)

    def _map(self, scene: Scene) -> SemanticMap | None:
        """What is known, as a map; None before the first look."""
        if not self.looks:
            return None
        known = tuple(t.last for _, t in sorted(self.things.items()) if t.located and t.last is not None)
        return SemanticMap(scene.name, scene.library, known)

    def put(self, id_: str, pose: Pose, *, held: bool) -> None:
        """A thing is where the hand has it, or has let it go."""
        thing = self.things[id_]
        if thing.last is not None:
            last = replace(thing.last, pose=pose, held=held, place=None)
            self.things = {**self.things, id_: Thing(Standing.HIDDEN, last)}

    def lose(self, id_: str) -> None:
        """A thing is where it was no more."""
        self.things = {**self.things, id_: replace(self.things[id_], standing=Standing.UNSEEN)}

    def give_up(self, id_: str) -> None:
        """Every view was looked at for a thing."""
        self.things = looked_for(self.things, id_)

    @property
    def unseen(self) -> tuple[str, ...]:
        """The things of which nobody knows where they are."""
        return tuple(sorted(id_ for id_, t in self.things.items() if t.standing is Standing.UNSEEN))


def _moved(now: Thing, before: Thing | None) -> bool:
    """Whether something else is known of where a thing is."""
    if before is None or now.located != before.located:
        return True
    if now.last is None or before.last is None or not now.located:
        return False
    return math.dist(now.last.pose.xyz_m, before.last.pose.xyz_m) > _MOVED_M
