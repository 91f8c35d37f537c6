"""The disturbances by name, and what each is in a world of facts. The bullet room has its own, of bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Facts
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, nearest
from llmbt_runtime.chance import Chance
from llmbt_runtime.symbolic import Event

__all__ = ["NAMES", "applicable", "draw", "symbolic_events"]

NAMES = ("drop", "obstacle_at_place", "obstacle_at_pick", "placed_object_moved")
"""Those that can be dealt with; `none` and `random` (or `random:N`) stand beside them."""


def draw(wanted: str, rng: Chance, names: tuple[str, ...] = NAMES) -> tuple[str, ...]:
    """The disturbances that `wanted` stands for: a name, `none`, `random` or `random:N`, several joined by commas.

    `names` are those that apply. E061 an unknown one, E062 one that does not apply here.
    """
    drawn: list[str] = []
    for part in wanted.split(","):
        name, _, count = part.strip().partition(":")
        if name == "none":
            continue
        if name == "random" and names and _counted(part, count):
            n = int(count or 1)
            pool: list[str] = []
            for _ in range(n):
                pool = pool or list(names)
                drawn.append(pool.pop(rng.integers(len(pool))))
        elif name in names and not count:
            drawn.append(name)
        elif (name in NAMES and not count) or (name == "random" and _counted(part, count)):
            raise _does_not_apply(name)
        else:
            close = nearest(part, (*names, "none", "random"))
            raise LlmbtError(
                Diagnostic(
                    "E061",
                    f"unknown disturbance `{part}`",
                    help=f"did you mean {', '.join(close)}?" if close else f"known: none, random, {', '.join(names)}",
                    candidates=close,
                ),
                exit_code=ExitCode.BAD_INPUT,
            )
    return tuple(drawn)


def _counted(part: str, count: str) -> bool:
    return part.strip() == "random" or (count.isdigit() and int(count) > 0)


def applicable(domain: Domain, facts: Facts, goals: tuple[Condition, ...]) -> tuple[str, ...]:
    """The disturbances that can come about in a task: after its first grasp, before its end, and dealt with."""
    still = [g for g in goals if g.name == "On" and not g.negated and g not in facts]
    slots = [g for g in still if domain.fits(g.args[1], "slot")]
    able = {
        "drop": bool(still),
        "obstacle_at_place": bool(slots),
        "obstacle_at_pick": len(still) > 1,
        "placed_object_moved": len(slots) > 1,
    }
    return tuple(n for n in NAMES if able[n])


def _does_not_apply(name: str) -> LlmbtError:
    hint = "there are too few things left to be placed"
    return LlmbtError(Diagnostic("E062", f"`{name}` does not apply here", help=hint))


@dataclass(frozen=True, slots=True)
class _Setting:
    domain: Domain
    facts: Facts
    goals: tuple[Condition, ...]
    rng: Chance
    obstacle: str = "obstacle_1"

    def open(self) -> list[Condition]:
        return [g for g in self.goals if g.name == "On" and not g.negated and g not in self.facts]

    def pick(self, goals: list[Condition]) -> Condition:
        return goals[int(self.rng.integers(len(goals)))]

    def region(self) -> str:
        regions = self.domain.by_type.get("region", ()) or self.domain.by_type["place"]
        plain = [r for r in regions if not self.domain.fits(r, "buffer")]
        return (plain or list(regions))[0]

    def on(self, thing: str, place: str) -> Facts:
        return frozenset(self.domain.upward(Condition("On", (thing, place))))


def symbolic_events(
    names: tuple[str, ...],
    domain: Domain,
    facts: Facts,
    goals: tuple[Condition, ...],
    rng: Chance,
) -> tuple[Event, ...]:
    """The named disturbances as events on facts, each on an event of the task. E062 where one does not apply."""
    setting, obstacles = _Setting(domain, facts, goals, rng), 0
    made: dict[str, Callable[[_Setting], Event | None]] = {
        "drop": _drop,
        "obstacle_at_place": _obstacle_at_place,
        "obstacle_at_pick": _obstacle_at_pick,
        "placed_object_moved": _placed_object_moved,
    }
    events = []
    for name in names:
        if name.startswith("obstacle"):
            obstacles += 1  # one thing is in one place
            setting = replace(setting, obstacle=f"obstacle_{obstacles}")
        event = made[name](setting)
        if event is None:
            raise _does_not_apply(name)
        events.append(event)
    return tuple(events)


def _drop(s: _Setting) -> Event | None:
    if not s.open():
        return None
    thing = s.pick(s.open()).args[0]
    held = Condition("Holding", (thing,))
    adds = s.on(thing, s.region()) | {Condition("HandEmpty")}
    return Event(1, frozenset({held}), adds, (held,), "drop", thing)


def _obstacle_at_place(s: _Setting) -> Event | None:
    slots = [g for g in s.open() if s.domain.fits(g.args[1], "slot")]
    if not slots:
        return None
    thing, place = s.pick(slots).args
    free = Condition("Free", (place,))
    adds = s.on(s.obstacle, place) | {Condition("Clear", (s.obstacle,))}
    return Event(1, frozenset({free}), adds, (Condition("Holding", (thing,)), free), "obstacle_at_place", place)


def _obstacle_at_pick(s: _Setting) -> Event | None:
    waiting = s.open()
    if len(waiting) < 2:
        return None
    first, later = waiting[0], s.pick(waiting[1:])
    thing = later.args[0]
    clear = Condition("Clear", (thing,))
    where = next((f.args[1] for f in sorted(s.facts) if f.name == "On" and f.args[0] == thing), s.region())
    adds = s.on(s.obstacle, where if not s.domain.fits(where, "slot") else s.region()) | {
        Condition("Blocks", (s.obstacle, thing)),
        Condition("Clear", (s.obstacle,)),
    }
    return Event(
        1,
        frozenset({clear}),
        adds,
        (Condition("Holding", (first.args[0],)), clear),
        "obstacle_at_pick",
        thing,
    )


def _placed_object_moved(s: _Setting) -> Event | None:
    slots = [g for g in s.open() if s.domain.fits(g.args[1], "slot")]
    if len(slots) < 2:
        return None
    goal = s.pick(slots[:-1])
    thing, place = goal.args
    adds = s.on(thing, s.region()) | {Condition("Free", (place,))}
    when = (goal, Condition("HandEmpty"))
    return Event(1, s.on(thing, place) - adds, adds, when, "placed_object_moved", thing)
