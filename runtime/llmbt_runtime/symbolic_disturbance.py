"""What the disturbances are in a world of facts: events that fire once, when the task has come so far."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Facts
from llmbt_runtime.chance import Chance
from llmbt_runtime.disturbance import (
    BRING_A_THING,
    DisturbanceSpec,
    When,
    can_be_filled,
    can_shift,
    does_not_apply,
    drives,
    open_goals,
)
from llmbt_runtime.symbolic import Event
from llmbt_runtime.world import TICK_S

__all__ = ["symbolic_events"]

C = Condition


@dataclass(frozen=True, slots=True)
class _Setting:
    domain: Domain
    facts: Facts
    goals: tuple[Condition, ...]
    rng: Chance
    target: str | None = None
    obstacle: str = "obstacle_1"
    timed: bool = False

    def open(self) -> list[Condition]:
        """The goals to choose from: those about the target, where one is named."""
        still = open_goals(self.facts, self.goals)
        return [g for g in still if self.target is None or self.target in g.args]

    def later(self) -> list[Condition]:
        """Those of a thing that is not taken first, where there are others."""
        still, wanted = open_goals(self.facts, self.goals), self.open()
        return [g for g in wanted if g != still[0]] or (wanted if drives(self.domain) or self.timed else [])

    def placed(self, goals: list[Condition]) -> list[Condition]:
        """Those that hold before the run is over."""
        still = open_goals(self.facts, self.goals)
        return [g for g in goals if len(still) > 1 and g != still[-1]]

    def begun(self, but: str) -> tuple[Condition, ...]:
        """The run has begun: the first thing is held, unless it is the one in question."""
        first = open_goals(self.facts, self.goals)[0].args[0]
        return (C("Holding", (first,)),) if first != but and not self.timed else ()

    def pick(self, goals: list[Condition]) -> Condition | None:
        return goals[int(self.rng.integers(len(goals)))] if goals else None

    def region(self) -> str:
        regions = self.domain.by_type.get("region", ()) or self.domain.by_type["place"]
        plain = [r for r in regions if not self.domain.fits(r, "buffer")]
        return (plain or list(regions))[0]

    def on(self, thing: str, place: str) -> Facts:
        return frozenset(self.domain.upward(C("On", (thing, place))))

    def lying(self, thing: str) -> Facts:
        """Where a thing ends that fell: on the bench, or on the floor of a room."""
        if drives(self.domain):
            return frozenset({C("Fallen", (thing,))})
        return self.on(thing, self.region())

    def where(self, thing: str) -> str | None:
        """The most specific place that a thing is on at the start."""
        found = [f.args[1] for f in self.facts if f.name == "On" and f.args[0] == thing]
        depth = {p: sum(1 for _ in self.domain.containers(p)) for p in found}
        return max(sorted(found), key=lambda p: depth[p], default=None)


def symbolic_events(
    specs: tuple[DisturbanceSpec, ...],
    domain: Domain,
    facts: Facts,
    goals: tuple[Condition, ...],
    rng: Chance,
) -> tuple[Event, ...]:
    """Disturbances as events on facts, each on an event of the task. E062 where one does not apply."""
    obstacles = 0
    events: list[Event] = []
    for number, spec in enumerate(specs):
        if spec.name in BRING_A_THING:
            obstacles += 1  # one thing is in one place
        setting = _Setting(
            domain, facts, goals, rng, spec.target, f"obstacle_{max(1, obstacles)}", spec.when is not None
        )
        if spec.when is not None and spec.target is None:  # whichever it can be about by then
            targets = [replace(setting, target=g.args[0]) for g in open_goals(facts, goals)]
        else:
            targets = [setting]
        made = [event for s in targets if (event := _MADE[spec.name](s)) is not None]
        if not made:
            raise does_not_apply(spec.name)
        events += [_timed(event, spec.when, f"{number}") for event in made]
    return tuple(events)


def _timed(event: Event, when: When | None, group: str) -> Event:
    if when is None:
        return event
    return replace(
        event,
        tick=max(1, round(when.time_s / TICK_S)),
        group=group,
        grasps=when.grasp,
        transfer=when.transfer,
        after=when.after,
        count=when.count,
    )


def _drop(s: _Setting) -> Event | None:
    goal = s.pick(s.open())
    if goal is None:
        return None
    thing = goal.args[0]
    held = C("Holding", (thing,))
    return Event(1, frozenset({held}), s.lying(thing) | {C("HandEmpty")}, (held,), "drop", thing)


def _obstacle_at_place(s: _Setting) -> Event | None:
    goal = s.pick([g for g in s.open() if can_be_filled(s.domain, g.args[1])])
    if goal is None:
        return None
    thing, place = goal.args
    free = C("Free", (place,))
    adds = s.on(s.obstacle, place) | {C("Clear", (s.obstacle,))}
    return Event(1, frozenset({free}), adds, (C("Holding", (thing,)), free), "obstacle_at_place", place)


def _obstacle_at_pick(s: _Setting) -> Event | None:
    goal = s.pick(s.later())
    if goal is None:
        return None
    thing = goal.args[0]
    clear = C("Clear", (thing,))
    place = s.where(thing) or s.region()
    adds = s.on(s.obstacle, place if not s.domain.fits(place, "slot") else s.region()) | {
        C("Blocks", (s.obstacle, thing)),
        C("Clear", (s.obstacle,)),
    }
    when = (*s.begun(thing), clear, ~C("Holding", (thing,)))
    return Event(1, frozenset({clear}), adds, when, "obstacle_at_pick", thing)


def _placed_object_moved(s: _Setting) -> Event | None:
    goal = s.pick(s.placed([g for g in s.open() if can_be_filled(s.domain, g.args[1])]))
    if goal is None:
        return None
    thing, place = goal.args
    there = s.where(thing) if drives(s.domain) else s.region()
    adds = s.on(thing, there or s.region()) | {C("Free", (place,))}
    return Event(1, s.on(thing, place) - adds, adds, (goal, C("HandEmpty")), "placed_object_moved", thing)


def _object_moved(s: _Setting) -> Event | None:
    goal = s.pick(s.later())
    here = s.where(goal.args[0]) if goal is not None else None
    if goal is None or here is None:
        return None
    thing = goal.args[0]
    wanted = {g.args[1] for g in s.goals if g.name == "On"}
    free = [f.args[0] for f in sorted(s.facts) if f.name == "Free" and f.args[0] not in {here, *wanted}]
    free = [p for p in free if can_be_filled(s.domain, p)]
    if not free:
        return None
    there = free[int(s.rng.integers(len(free)))]
    takes_one = s.domain.fits(there, "slot")
    adds = s.on(thing, there) | ({C("Free", (here,))} if s.domain.fits(here, "slot") else set())
    removes = (s.on(thing, here) | ({C("Free", (there,))} if takes_one else set())) - adds
    when = (*s.begun(thing), C("On", (thing, here)), C("Free", (there,)), C("Clear", (thing,)))
    return Event(1, removes, adds, when, "object_moved", thing)


def _base_blocked(s: _Setting) -> Event | None:
    goal = s.pick(s.open()) if drives(s.domain) else None
    if goal is None:
        return None
    thing, place = goal.args
    clear = C("Clear", (place,))
    adds = frozenset(C(n, a) for n, a in (("Blocks", (s.obstacle, place)), ("Clear", (s.obstacle,))))
    adds |= {C("Fallen", (s.obstacle,))}
    when = (C("Holding", (thing,)), clear, ~C("Near", (place,)))
    return Event(1, frozenset({clear}), adds, when, "base_blocked", place)


def _destination_shifted(s: _Setting) -> Event | None:
    """What has been placed there is no longer where it should be; a robot that stood there does so no more."""
    able = [g for g in s.open() if can_shift(s.domain, g.args[1])]
    goal = s.pick(s.placed(able))
    if goal is not None:
        thing, place = goal.args
        parents = tuple(s.domain.containers(place))
        inside = s.on(thing, parents[0]) if parents else frozenset({C("Fallen", (thing,))})
        if "Obstructs" in s.domain.library.conditions:
            inside |= {C("Obstructs", (thing, place))}
        removes = s.on(thing, place) | {C("Near", (place,))}
        return Event(1, removes - inside, inside, (goal, C("HandEmpty")), "destination_shifted", place)
    goal = s.pick(able) if drives(s.domain) else None
    if goal is None:
        return None
    near = C("Near", (goal.args[1],))
    when = (C("Holding", (goal.args[0],)), near)
    return Event(1, frozenset({near}), frozenset(), when, "destination_shifted", goal.args[1])


def _object_taken(s: _Setting) -> Event | None:
    goal = s.pick(s.later())
    here = s.where(goal.args[0]) if goal is not None else None
    if goal is None or here is None:
        return None
    thing = goal.args[0]
    removes = s.on(thing, here) | {C("Clear", (thing,))}
    adds = {C("Free", (here,))} if s.domain.fits(here, "slot") else set()
    when = (*s.begun(thing), C("On", (thing, here)))
    return Event(1, removes, frozenset(adds), when, "object_taken", thing)


def _impossible(s: _Setting) -> Event | None:
    """Something that nobody can move stands where a thing is to go, or in the only way there."""
    goal = s.pick([g for g in s.open() if can_be_filled(s.domain, g.args[1])])
    if goal is None:
        return None
    thing, place = goal.args
    held = C("Holding", (thing,))
    if not drives(s.domain):
        free = C("Free", (place,))
        return Event(1, frozenset({free}), s.on(s.obstacle, place), (held, free), "impossible", place)
    clear, adds = C("Clear", (place,)), {C("Blocks", (s.obstacle, place)), C("Fallen", (s.obstacle,))}
    when = (held, clear, ~C("Near", (place,)))
    return Event(1, frozenset({clear}), frozenset(adds), when, "impossible", place)


_MADE: dict[str, Callable[[_Setting], Event | None]] = {
    "drop": _drop,
    "obstacle_at_place": _obstacle_at_place,
    "obstacle_at_pick": _obstacle_at_pick,
    "placed_object_moved": _placed_object_moved,
    "object_moved": _object_moved,
    "base_blocked": _base_blocked,
    "destination_shifted": _destination_shifted,
    "object_taken": _object_taken,
    "impossible": _impossible,
}
