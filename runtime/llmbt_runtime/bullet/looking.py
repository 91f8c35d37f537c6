"""Looking for a thing: the arm goes out of each view in turn. Generators that are resumed once a tick."""

from __future__ import annotations

import math
from dataclasses import dataclass

from llmbt_runtime.bullet.arm import Arm, Skill, SkillError
from llmbt_runtime.bullet.driving import Driver
from llmbt_runtime.bullet.seen import Seen

__all__ = ["Searcher"]

_POSTURES_M = tuple(
    (0.38 * math.cos(a), 0.38 * math.sin(a), 0.55) for a in (math.radians(0), math.radians(75), math.radians(-75))
)
"""Where the tip is held, in the frame of the base: from one of these the arm is out of the way of every camera."""


@dataclass
class Searcher:
    """Looks with the eyes of a `Seen`; a robot that goes by the truth has none, and nothing is unseen to it."""

    arm: Arm
    driver: Driver
    seen: Seen | None

    def look_for(self, target: str) -> Skill:
        """Look at every view until a thing is seen; not_seen where it is in none: then it counts as gone."""
        if self.seen is None:
            return
        yield from self.driver.come_to_rest()
        for x, y, z in _POSTURES_M:
            self.seen.ask()
            while self.seen.asked:
                yield
            if self.seen.eyes.things[target].located:
                return
            yield from self.arm.over((x, y, z, math.atan2(y, x) + math.pi / 2), self.arm.bench.sensed.held)
        self.seen.ask()
        while self.seen.asked:
            yield
        if self.seen.eyes.things[target].located:
            return
        self.seen.eyes.give_up(target)
        raise SkillError("not_seen")
