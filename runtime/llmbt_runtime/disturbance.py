"""The disturbances by name, when one is to come, and which of them a task can meet. What each does to facts is in
`symbolic_disturbance`, what it does to bodies in the bullet room."""

from __future__ import annotations

from dataclasses import dataclass, field

from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Facts
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, nearest
from llmbt_runtime.chance import Chance

__all__ = [
    "BRING_A_THING",
    "NAMES",
    "SOLVABLE",
    "UNSOLVABLE",
    "DisturbanceSpec",
    "When",
    "applicable",
    "can_be_filled",
    "can_shift",
    "does_not_apply",
    "draw",
    "drives",
    "open_goals",
]

SOLVABLE = (
    "drop",
    "obstacle_at_place",
    "obstacle_at_pick",
    "placed_object_moved",
    "object_moved",
    "base_blocked",
    "destination_shifted",
)
"""Those that can be dealt with; `none` and `random` (or `random:N`), which draws from them, stand beside them."""
UNSOLVABLE = ("object_taken", "impossible")
"""Those after which a run can only end as UNSOLVABLE; they come when asked for, never by `random`."""
NAMES = SOLVABLE + UNSOLVABLE
BRING_A_THING = frozenset({"obstacle_at_place", "obstacle_at_pick", "base_blocked", "impossible"})
"""Those that bring something in: what nobody can move, if `impossible`."""


@dataclass(frozen=True, slots=True)
class When:
    """Not before all of this: a simulated time; the k-th grasp of the run (`grasp`); a share from 0 to 1 of what is
    then carried being carried over (`transfer`); the `count`-th success of an action (`after`, a template's name)."""

    time_s: float = 0.0
    grasp: int = 0
    transfer: float = 0.0
    after: str = ""
    count: int = 1


@dataclass(frozen=True, slots=True)
class DisturbanceSpec:
    """One disturbance to come. `target`, the thing or place that it is about, and `when` are drawn by the seed where
    they are None. It comes at the first moment from `when` on at which it breaks something."""

    name: str
    target: str | None = None
    when: When | None = field(default=None)


def draw(wanted: str, rng: Chance, names: tuple[str, ...] = NAMES) -> tuple[str, ...]:
    """The disturbances that `wanted` stands for: a name, `none`, `random` or `random:N`, several joined by commas.

    `names` are those that apply. E061 an unknown one, E062 one that does not apply here.
    """
    drawn: list[str] = []
    solvable = [n for n in names if n in SOLVABLE]
    for part in wanted.split(","):
        name, _, count = part.strip().partition(":")
        if name == "none":
            continue
        if name == "random" and solvable and _counted(part, count):
            n = int(count or 1)
            pool: list[str] = []
            for _ in range(n):
                pool = pool or list(solvable)
                drawn.append(pool.pop(rng.integers(len(pool))))
        elif name in names and not count:
            drawn.append(name)
        elif (name in NAMES and not count) or (name == "random" and _counted(part, count)):
            raise does_not_apply(name)
        else:
            close = nearest(part, (*names, "none", "random"))
            raise LlmbtError(
                Diagnostic(
                    "E061",
                    f"unknown disturbance `{part}`",
                    help=f"did you mean {', '.join(close)}?" if close else f"known: none, random, {', '.join(NAMES)}",
                    candidates=close,
                ),
                exit_code=ExitCode.BAD_INPUT,
            )
    return tuple(drawn)


def _counted(part: str, count: str) -> bool:
    return part.strip() == "random" or (count.isdigit() and int(count) > 0)


def does_not_apply(name: str) -> LlmbtError:
    """E062."""
    hint = {
        "base_blocked": "the robot of this scene does not drive",
        "obstacle_at_place": "nothing is left to be placed where an obstacle could take the room",
        "destination_shifted": "nothing is left to be placed on what can shift",
    }.get(name, "there are too few things left to be placed")
    return LlmbtError(Diagnostic("E062", f"`{name}` does not apply here", help=hint))


# -- what applies --------------------------------------------------------------------------------------------------


def drives(domain: Domain) -> bool:
    """Whether the robot is somewhere, and may be elsewhere."""
    return "Near" in domain.library.conditions


def open_goals(facts: Facts, goals: tuple[Condition, ...]) -> tuple[Condition, ...]:
    """The things that are still to be placed."""
    return tuple(g for g in goals if g.name == "On" and not g.negated and g not in facts)


def can_be_filled(domain: Domain, place: str) -> bool:
    """Whether one obstacle can take the room of a place: a slot, or where the robot has to drive to."""
    return domain.fits(place, "slot") or ("slot" not in domain.library.types and domain.fits(place, "location"))


def can_shift(domain: Domain, place: str) -> bool:
    """People move, and what has slots may be pushed."""
    return domain.fits(place, "slot") or domain.fits(place, "person")


def applicable(domain: Domain, facts: Facts, goals: tuple[Condition, ...]) -> tuple[str, ...]:
    """The disturbances that can come about in a task, before its end: where the robot stands still after its first
    grasp, so that most need a second thing to be placed."""
    still = open_goals(facts, goals)
    filled = [g for g in still if can_be_filled(domain, g.args[1])]
    shifted = [g for g in still if can_shift(domain, g.args[1])]
    enough = len(still) > 1 or (drives(domain) and bool(still))
    able = {
        "drop": bool(still),
        "obstacle_at_place": bool(filled),
        "obstacle_at_pick": enough,
        "placed_object_moved": len(still) > 1 and bool(filled),
        "object_moved": enough,
        "base_blocked": drives(domain) and bool(still),
        "destination_shifted": bool(shifted) and (len(shifted) > 1 or drives(domain)),
        "object_taken": enough,
        "impossible": bool(filled),
    }
    return tuple(n for n in NAMES if able[n])
