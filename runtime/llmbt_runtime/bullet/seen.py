"""The bench as the robot knows it, by its cameras and its hand: what skills and a tree's conditions go by when they do
not go by the truth. It has the face of a `Bench`; arm and base are the real ones.

The hand feels that it grips, not what: that is the thing which was believed to be between the fingers. What is held
moves with the tip; what slipped out, and what was let go, is looked for.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from llmbt_ir.geometry import Box as Solid
from llmbt_ir.geometry import Pose
from llmbt_runtime.bullet.bench import Bench, Sensed
from llmbt_runtime.bullet.bodies import BodyState, state_at
from llmbt_runtime.bullet.stage import Stage
from llmbt_runtime.perception.eyes import Eyes
from llmbt_runtime.perception.watch import Box

__all__ = ["Seen"]

_GLANCE_TICKS = 2
_CALM_GLANCES = 2
_GRIP_N, _KEEP_N = 1.0, 0.3
_IN_REACH_M = 0.03
_HAND_AWAY_M = 0.045
_SLIPPED_M = 0.008
_AROUND_HELD_M = 0.04
_SUPPORT_M = 0.01
_RESTLESS = 1.0
"""The speed of what has been let go and not been looked at since, in metres a second: it is not at rest."""


class Seen:
    """What is known, tick by tick. `restless`: something is in motion, or has not been looked at since it was."""

    def __init__(self, bench: Bench, stage: Stage, eyes: Eyes) -> None:
        self._bench, self._stage, self.eyes = bench, stage, eyes
        self.kinds, self.panda, self.base = bench.kinds, bench.panda, bench.base
        self.begin()

    def begin(self) -> None:
        """From the start of a trial."""
        self._held: str | None = None
        self._in_hand = Pose((0.0, 0.0, 0.0))
        self._let_go: dict[str, Pose] = {}
        self._due = self._asked = False
        self._calm, self._since = _CALM_GLANCES, 0
        self.eyes.open()
        self.sensed = self._sense()

    # -- the face of a bench --------------------------------------------------------------------------------------

    @property
    def time_s(self) -> float:
        """Simulated time since the scene had settled."""
        return self._bench.time_s

    @property
    def surprises(self) -> int:
        """How often something was seen not to be where it was believed to be."""
        return self.eyes.changes

    def others(self, *but: str | None) -> Iterable[tuple[str, BodyState]]:
        """The things whose place is known, without some."""
        return ((id_, s) for id_, s in self.sensed.states.items() if id_ not in but)

    # -- each tick ------------------------------------------------------------------------------------------------

    @property
    def restless(self) -> bool:
        """Whether something moves or may have moved."""
        return self._calm < _CALM_GLANCES or self._due

    def ask(self) -> None:
        """Look, as soon as may be."""
        self._asked = True

    @property
    def asked(self) -> bool:
        """Whether a look that was asked for has still to come."""
        return self._asked

    def step(self, *, in_contact: bool) -> Sensed:
        """What is known after a tick of the physics."""
        self._feel()
        self._since += 1
        if self._since >= _GLANCE_TICKS:
            self._since = 0
            if self.eyes.glance(self._boxes()):
                self._calm, self._due = 0, True
            else:
                self._calm += 1
        if (self._due or self._asked) and self._may_look(in_contact=in_contact):
            self._look()
        self.sensed = self._sense()
        return self.sensed

    def _may_look(self, *, in_contact: bool) -> bool:
        """Once all is calm; in a contact phase only when the hand has come away from what it has let go."""
        if self._calm < _CALM_GLANCES:
            return False
        if not self._let_go:
            return not in_contact
        tip = self._bench.tip_xyz()
        return all(math.dist(tip, at.xyz_m) > _HAND_AWAY_M for at in self._let_go.values())

    def _look(self) -> None:
        self.eyes.look(self._held, self._boxes())
        self._due = self._asked = False
        self._let_go = {}
        if self._held is not None:
            self._correct_hold(self._held)

    # -- the hand -------------------------------------------------------------------------------------------------

    def _feel(self) -> None:
        left, right = self._bench.felt_n()
        closing = self.panda.opening_m < 1e-6
        if self._held is None and closing and min(left, right) > _GRIP_N:
            self._grip()
        elif self._held is not None and (not closing or min(left, right) < _KEEP_N):
            self._part(slipped=closing)
        if self._held is not None:
            self.eyes.put(self._held, self._bench.from_tip(self._in_hand), held=True)

    def _grip(self) -> None:
        """What was believed to be between the fingers is in the hand, in the middle between them."""
        id_ = self._at_tip()
        if id_ is None:
            return
        self._held = id_
        along, _, below = self._bench.to_tip(self.sensed.states[id_].pose).xyz_m
        self._in_hand = replace(self._bench.to_tip(self.sensed.states[id_].pose), xyz_m=(along, 0.0, below))

    def _at_tip(self) -> str | None:
        """The nearest thing to the tip, if it is close."""
        tip = np.array(self._bench.tip_xyz())
        near = []
        for id_, state in self.sensed.states.items():
            gap = np.abs(tip - state.extent.centre) - state.extent.half
            near.append((float(np.linalg.norm(np.maximum(gap, 0.0))), math.dist(tip, state.xyz), id_))
        best = min(near, default=(math.inf, 0.0, ""))
        return best[2] if best[0] < _IN_REACH_M else None

    def _part(self, *, slipped: bool) -> None:
        """The hand has let go of what it held, or lost it."""
        id_, self._held = self._held, None
        assert id_ is not None
        pose = self._bench.from_tip(self._in_hand)
        self.eyes.put(id_, pose, held=False)
        self._due = True
        if slipped:
            self.eyes.lose(id_)
            self._calm = 0
        else:
            self._let_go[id_] = Pose(self._bench.tip_xyz())

    def _correct_hold(self, id_: str) -> None:
        """Where the held thing is seen to be, if that is not where the hand believes it to be."""
        thing = self.eyes.things[id_].last
        if thing is None or not thing.held:
            return
        believed = self._bench.from_tip(self._in_hand)
        if math.dist(thing.pose.xyz_m, believed.xyz_m) > _SLIPPED_M:
            self._in_hand = self._bench.to_tip(thing.pose)

    def _boxes(self) -> list[Box]:
        """Around what the hand holds, which moves with it."""
        if self._held is None or self.eyes.things[self._held].last is None:
            return []
        pose = self._bench.from_tip(self._in_hand)
        reach = float(np.linalg.norm(self.kinds[self._held].size_m)) / 2 + _AROUND_HELD_M
        return [Box(np.array(pose.xyz_m) - reach, np.array(pose.xyz_m) + reach)]

    # -- what follows ---------------------------------------------------------------------------------------------

    def _sense(self) -> Sensed:
        states = {}
        for id_, thing in self.eyes.things.items():
            if thing.located and thing.last is not None and id_ in self.kinds:
                speed = _RESTLESS if id_ in self._let_go else 0.0
                states[id_] = state_at(self.kinds[id_], thing.last.pose, speed)
        touched: tuple[tuple[str, float], ...] = ()
        if self._bench.touching:
            id_at_tip = self._held or self._nearest(states)
            touched = ((id_at_tip, sum(self._bench.felt_n())),) if id_at_tip is not None else ()
        on = frozenset(id_ for id_, s in states.items() if id_ != self._held and self._supported(s))
        return Sensed(self.time_s, states, self._held, touched, on, self.base.measured())

    def _nearest(self, states: dict[str, BodyState]) -> str | None:
        """Of what the fingers touch it is not felt what it is."""
        tip = self._bench.tip_xyz()
        return min(states, key=lambda id_: (math.dist(states[id_].xyz, tip), id_), default=None)

    def _supported(self, state: BodyState) -> bool:
        """Whether a thing stands on a fixture or on the floor."""
        x, y, _ = state.xyz
        bottom = state.extent.bottom_m
        under = [f.top_m for f in self._stage.scene.fixtures if Solid(f.xyz_m, f.size_m).contains_xy(x, y, -0.005)]
        return any(abs(bottom - top) <= _SUPPORT_M for top in (0.0, *under))
