"""The skills of the robot: generators that are resumed once a tick, after the physics, with what was sensed in it.

A skill ends by returning, or by raising SkillError with a reason. It may be closed between any two ticks outside a
contact phase; arm and base then brake on their paths. Every skill starts from wherever the robot is.

Reasons: not_holding, not_approachable, moved_since_seen, missed, not_lifted, ik_unreachable, tracking_error,
spot_occupied, blocked, no_free_buffer, no_room_upright, dropped_on_the_way, unstable_after_release, held_askew,
hand_not_empty, not_let_go, unknown_object, no_plan, no_path, not_seen.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from llmbt_ir.condition import ActionCall, Condition
from llmbt_runtime.bullet.arm import Skill, SkillError
from llmbt_runtime.bullet.driving import Driver
from llmbt_runtime.bullet.handling import Hand
from llmbt_runtime.bullet.looking import Searcher
from llmbt_runtime.bullet.spots import has_room

__all__ = ["Skill", "SkillError", "Skills"]

_UPRIGHT = 0.9


@dataclass
class Skills:
    """The actions of the shipped libraries, made of taking, putting down and driving."""

    hand: Hand
    driver: Driver
    searcher: Searcher

    def skill(self, action: ActionCall) -> Skill:
        """The skill for an action of a library. ValueError where there is none."""
        match action.name, action.args:
            case "pick", (o, p):
                return self.pick(o, p)
            case (("place" | "put_down"), (o, p)):
                return self.place(o, p)
            case "move_aside", (o, p, region):
                return self.transfer(o, p, region)
            case "clear_away", (b, o, p, region):
                return self.transfer(b, p, region, for_=o)
            case "clear_away", (b, o, p):
                return self.transfer(b, p, p, for_=o)
            case "clear_place", (o, p, _, region):
                return self.transfer(o, p, region)
            case "release", (o,):
                return self.hand.release(o)
            case "recover", (o, region):
                return self.recover(o, region)
            case "navigate", (p,):
                return self.driver.navigate(p)
            case "look", (o, _):
                return self.searcher.look_for(o)
            case "clear_way", (b, p):
                return self.clear_way(b, p)
            case _:
                raise ValueError(f"no such action: {action}")

    def pick(self, target: str, place: str) -> Skill:
        """Take a thing from above; ends with it held, a little above where it was."""
        yield from self.driver.come_to_rest()
        yield from self.driver.face(target, place)
        yield from self.hand.take(target, place)

    def place(self, target: str, place: str) -> Skill:
        """Put the held thing onto a slot, or onto a free spot of a region.

        One that has turned in the hand cannot be set onto a slot: it is put down in a buffer, to be taken anew.
        """
        yield from self.driver.come_to_rest()
        scene = self.hand.scene
        buffer = next((p for p in scene.places if p.buffer), None)
        if scene.place(place).is_slot and buffer is not None and self.hand.askew(target):
            yield from self.hand.put(target, buffer)
            raise SkillError("held_askew")
        yield from self.hand.put(target, scene.place(place))

    def transfer(self, target: str, place: str, region: str, for_: str | None = None) -> Skill:
        """Take a thing and put it down in a region, so that `for_` can be taken afterwards."""
        if region != place:
            self._expect_room(target, region)
        yield from self.pick(target, place)
        if self.driver.drives and region != place:
            yield from self.driver.navigate(region)
        yield from self.hand.put(target, self.hand.scene.place(region), for_)

    def recover(self, target: str, place: str) -> Skill:
        """Take a thing from where it fell, on a bench or the floor, and put it onto a place."""
        self._expect_room(target, place)
        yield from self.driver.come_to_rest()
        yield from self.driver.face(target, None)
        yield from self.hand.take(target, place)
        if self.driver.drives:
            yield from self.driver.navigate(place)
        yield from self.hand.put(target, self.hand.scene.place(place))

    def _expect_room(self, target: str, region: str) -> None:
        """no_free_buffer where a thing could stand nowhere in a region: better known before it is in the hand."""
        bench, place = self.hand.bench, self.hand.scene.place(region)
        state = bench.sensed.states.get(target)
        if state is None or place.is_slot or abs(state.axes[2][2]) < _UPRIGHT:
            return
        lying = [s.extent for _, s in bench.others(target)]
        if not has_room(place, bench.kinds[target].size_m, lying, self.hand.scene.fixtures):
            raise SkillError("no_free_buffer", denies=Condition("Free", (region,)))

    def clear_way(self, obstacle: str, location: str) -> Skill:
        """Put a thing on the floor aside, so that there is a way, and go it.

        Once it is in the hand it is set down before the action may be halted: no place may have room for it.
        """
        yield from self.driver.come_to_rest()
        yield from self.driver.face(obstacle, None)
        aside = self.driver.floor_around(location, obstacle)
        for step in itertools.chain(self.hand.take(obstacle, None), self.hand.put(obstacle, aside)):
            self.driver.reporter.commit()
            yield step
        self.driver.reporter.release()
        yield from self.driver.navigate(location)
