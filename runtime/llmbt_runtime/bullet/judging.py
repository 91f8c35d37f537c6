"""Which things can be approached, and what is in the way of those that cannot: Clear and Blocks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from llmbt_ir.condition import Condition, Facts
from llmbt_runtime.bullet.approach import Approach
from llmbt_runtime.bullet.bench import Sensed
from llmbt_runtime.bullet.bodies import BodyState, any_moved
from llmbt_runtime.bullet.frames import BasePose
from llmbt_runtime.bullet.grasping import Verdict
from llmbt_runtime.bullet.terrain import Terrain

__all__ = ["Judge"]

_RESTLESS_TICKS = 20
"""After this many ticks in which something moves, approaches are judged all the same: it may roll for ever."""
_AFFECTS_M = 0.6
"""What has moved changes nothing for the approach to things that are further away than this."""
_POSES_TRIED = 6


@dataclass
class Judge:
    """Keeps its verdicts until something moves."""

    approach: Approach
    terrain: Terrain
    _judged: dict[str, BodyState] = field(default_factory=dict)
    _judged_held: str | None = None
    _judged_shifts: int = 0
    _verdicts: dict[str, Verdict] = field(default_factory=dict)
    _blockers: dict[str, str | None] = field(default_factory=dict)
    _restless: int = 0

    def facts(self, sensed: Sensed, on: Mapping[str, frozenset[str]], *, at_rest: bool) -> Facts:
        """Clear and Blocks of every thing in play. `on`: the places that each is on."""
        self._restless = 0 if at_rest else self._restless + 1
        lying = {id_: s for id_, s in sensed.states.items() if id_ != sensed.held}
        shifts = self.terrain.stage.shifts
        changed = sensed.held != self._judged_held or shifts != self._judged_shifts or any_moved(lying, self._judged)
        if changed and (at_rest or self._restless >= _RESTLESS_TICKS or not self._verdicts):
            self._judge(sensed, lying, on)
            self._judged, self._judged_held, self._judged_shifts = lying, sensed.held, shifts
            self._restless = 0
        facts: set[Condition] = set()
        for id_ in sensed.states:
            verdict = self._verdicts.get(id_)
            if id_ == sensed.held or verdict is None or verdict.grasp is not None:
                facts.add(Condition("Clear", (id_,)))
            elif (blocker := self._blockers.get(id_)) is not None:
                facts.add(Condition("Blocks", (blocker, id_)))
        return frozenset(facts)

    def _judge(self, sensed: Sensed, lying: dict[str, BodyState], on: Mapping[str, frozenset[str]]) -> None:
        self.approach.mirror(sensed.states, without=sensed.held)
        stale = self._stale(lying, on)
        kept = {id_: v for id_, v in self._verdicts.items() if id_ in lying and id_ not in stale}
        held, base = sensed.held, sensed.base
        fresh = {id_: self.verdict(id_, lying, held, base, on.get(id_, frozenset())) for id_ in sorted(stale)}
        self._verdicts = {**kept, **fresh}
        clear = frozenset(id_ for id_, v in self._verdicts.items() if v.grasp is not None)
        self._blockers = {
            id_: self.approach.blocker(id_, v.options, clear)
            for id_, v in sorted(self._verdicts.items())
            if v.grasp is None
        }

    def _stale(self, lying: dict[str, BodyState], on: Mapping[str, frozenset[str]]) -> set[str]:
        """The things whose approach what has moved since may have changed."""
        if not self.terrain.drives or self._judged_shifts != self.terrain.stage.shifts:
            return set(lying)
        before = self._judged
        touched = [
            s
            for id_ in {*lying, *before}
            for s in (lying.get(id_), before.get(id_))
            if s is not None and (id_ not in lying or id_ not in before or lying[id_].moved_from(before[id_]))
        ]

        def near(state: BodyState) -> bool:
            return any(math.dist(state.xyz[:2], t.xyz[:2]) < _AFFECTS_M for t in touched)

        return {id_ for id_, s in lying.items() if id_ not in self._verdicts or not on.get(id_) or near(s)}

    def verdict(
        self, id_: str, states: Mapping[str, BodyState], held: str | None, base: BasePose, places: frozenset[str]
    ) -> Verdict:
        """How a thing of the mirrored world can be taken, from the first pose of the base from which it can; else what
        all of them have found in the way."""
        state = states[id_]
        floor = self.terrain.floor(states, held)
        options: list[tuple[str, ...]] = []
        reachable = False
        poses = self.terrain.poses_for(state, places, floor, base)
        for pose in itertools.islice(poses, _POSES_TRIED):
            with self.approach.standing_at(pose):
                verdict = self.approach.grasp(id_)
            if verdict.grasp is not None:
                return verdict
            reachable |= verdict.reachable
            options += [o for o in verdict.options if o not in options]
        return Verdict(None, self.approach.blocker(id_, options), reachable, tuple(options))

    def can_take(self, id_: str, sensed: Sensed, pose: BasePose) -> bool:
        """Whether a thing can be taken from a pose of the base, as things are now."""
        self.approach.mirror(sensed.states, without=sensed.held)
        with self.approach.standing_at(pose):
            return self.approach.grasp(id_).grasp is not None

    def blocker_of(self, id_: str) -> str | None:
        """What was last found to be in the way of a thing."""
        return self._blockers.get(id_)

    def pose_to_take(self, id_: str, sensed: Sensed, places: frozenset[str]) -> BasePose | None:
        """A pose of the base from which a thing can be taken now; the present one where it serves."""
        state = sensed.states[id_]
        floor = self.terrain.floor(sensed.states, sensed.held)
        here = (sensed.base.x_m, sensed.base.y_m)
        poses = self.terrain.poses_for(state, places, floor, sensed.base)
        for pose in itertools.islice(poses, 2 * _POSES_TRIED):
            if not floor.connected(here, (pose.x_m, pose.y_m)):
                continue
            if self.can_take(id_, sensed, pose):
                return pose
        return None
