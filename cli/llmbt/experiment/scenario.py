"""Scenarios for comparing methods: a scene, goals, one kind of disturbance and a seed, the same for every method.

The disturbance is fixed by what happens in the task, not by the clock: a slow method meets it as a fast one does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from llmbt.experiment.cases import Case, Request, cassette_of
from llmbt.experiment.plan import trial_seed
from llmbt.experiment.trial import means
from llmbt_compiler.pipeline import Context, compile_request
from llmbt_compiler.reasoning.chat import Replay
from llmbt_ir.condition import Condition, Goals, parse_condition
from llmbt_ir.diagnostics import ExitCode, LlmbtError
from llmbt_ir.scene import to_semantic_map
from llmbt_runtime.baselines import Limits, run
from llmbt_runtime.chance import chance
from llmbt_runtime.disturbance import DisturbanceSpec, When, applicable, draw
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.symbolic import Event, SymbolicWorld
from llmbt_runtime.symbolic_disturbance import symbolic_events
from llmbt_runtime.world import World

__all__ = [
    "ATTACKS",
    "CELLS",
    "LIMITS",
    "UNSOLVABLE_CELLS",
    "Scenario",
    "applies",
    "heard",
    "open_world",
    "right_goals",
]
__all__ += ["seed_of", "tell"]

CELLS: Mapping[str, str] = {
    "none": "nothing happens",
    "drop": "the thing in the hand falls",
    "obstacle_at_pick": "a thing turns up in the way of a thing that is still to be taken",
    "obstacle_at_place": "a thing turns up where the held thing is to go",
    "placed_object_moved": "a thing that was in place is put elsewhere",
    "object_moved": "a thing that waits is put elsewhere",
    "base_blocked": "something stands where the robot is to drive",
    "destination_shifted": "the place where things go is moved",
    "two": "two of these, one after the other",
    "failures": "one of these at random, and one in ten actions fails",
}
"""The kinds of disturbance that methods are compared by."""

UNSOLVABLE_CELLS: Mapping[str, str] = {
    "object_taken": "a thing that is wanted is taken away for good",
    "impossible": "something that nobody can move stands where a thing is to go",
}
"""Those after which the only right end is to say that it cannot be done, and why."""

ATTACKS: Mapping[str, int] = {"one_attack": 1, "two_attacks": 2}
"""Cells of events that are searched for what breaks a method, with how many there are in one scenario."""

LIMITS: Mapping[str, Limits] = {
    "symbolic": Limits(ticks=1_000, expansions=20_000, updates=200, nodes=10_000, attempts=10, patience_ticks=40),
    "bullet": Limits(ticks=4_000, expansions=20_000, updates=200, nodes=10_000, attempts=3, patience_ticks=40),
}
"""The same for every method. Ten attempts in the world of facts, where failures are dice."""


Told = tuple[str, str, tuple[str, ...], tuple[str, ...], tuple[str, ...]]
"""Of an event the name, what it is about, when it comes, what it ends and what it begins."""


@dataclass(frozen=True, slots=True)
class Scenario:
    """`goals` are those that a request of the case was compiled to, as text; `events` are given where they do not
    follow from cell and seed."""

    world: str
    cell: str
    case: str
    request: str
    goals: tuple[str, ...]
    number: int
    seed: int
    events: tuple[Told, ...] = ()

    @property
    def key(self) -> str:
        """Its name within a plan."""
        return f"{self.world}.{self.cell}.{self.number:03}.{self.case}"

    def as_json(self) -> dict[str, Any]:
        """For the ledger."""
        return asdict(self)

    def conditions(self) -> Goals:
        """The goals as conditions."""
        return (_conditions(self.goals),)


def tell(event: Event) -> Told:
    """An event as text."""
    when, removes, adds = (tuple(map(str, sorted(part))) for part in (event.when, event.removes, event.adds))
    return event.name, event.target, when, removes, adds


def heard(told: Told) -> Event:
    """The event that `tell` told: once, from the first tick on."""
    name, target, when, removes, adds = told
    return Event(1, frozenset(_conditions(removes)), frozenset(_conditions(adds)), _conditions(when), name, target)


def _conditions(texts: Iterable[str]) -> tuple[Condition, ...]:
    return tuple(c for t in texts if (c := parse_condition(t)) is not None)


def right_goals(case: Case) -> Iterator[tuple[Request, tuple[Condition, ...]]]:
    """The goals of the clear requests of a case, of those that compile to what the case means."""
    domain = case.domain()
    for request in case.requests:
        if not request.clear:
            continue
        context = Context(request.text, to_semantic_map(case.scene), case.library, Replay(cassette_of(case, request)))
        try:
            goals = tuple(g.condition for g in compile_request(context, stop_after="parse").goals)
        except LlmbtError as fault:
            if fault.exit_code is ExitCode.NO_RECORDING:
                raise
            continue
        if means(goals, case.success, domain):
            yield request, goals


def applies(world: str, cell: str, case: Case, goals: tuple[Condition, ...]) -> bool:
    """Whether what a cell is about can come about on the way to goals: physics takes a thing of the scene for it."""
    if world == "bullet":
        from llmbt_runtime.bullet.disturbances import has_what_is_brought

        if not has_what_is_brought(case.scene, cell):
            return False
    domain = case.domain()
    able = applicable(domain, facts_of_map(domain, to_semantic_map(case.scene)), goals)
    return bool(able) if cell in ("two", "failures") else cell in ("none", *ATTACKS, *able)


def comes_about(scenario: Scenario, case: Case) -> bool:
    """Whether the disturbance of a scenario comes about on the way of the undisturbed plan; in physics that is not
    known before it is tried."""
    if scenario.world == "bullet" or scenario.cell == "none":
        return True
    world = open_world(scenario, case)
    run("script", world, case.domain(), scenario.conditions(), LIMITS[scenario.world])
    return bool(world.disturbances())


def seed_of(seed: int, world: str, cell: str, number: int) -> int:
    """The seed of a scenario."""
    return trial_seed(seed, "baselines", world, cell, number)


def open_world(scenario: Scenario, case: Case) -> World:
    """A new world for a scenario: the same at every call."""
    goals = scenario.conditions()
    domain = case.domain()
    facts = facts_of_map(domain, to_semantic_map(case.scene))
    if scenario.cell in ATTACKS:
        given = tuple(map(heard, scenario.events))
        return SymbolicWorld(
            domain.for_state(facts), facts, chance(scenario.seed, "world"), events=given, goals=goals[0]
        )
    wanted = {"two": "random:2", "failures": "random"}.get(scenario.cell, scenario.cell)
    names = draw(wanted, chance(scenario.seed, "disturb"), applicable(domain, facts, goals[0]))
    if scenario.world == "bullet":
        return _bullet(scenario, case, goals, names)
    rng = chance(scenario.seed, "world")
    there = domain.for_state(facts)
    specs = tuple(DisturbanceSpec(name) for name in names)
    events = symbolic_events(specs, there, facts, goals[0], rng)
    rate = 0.1 if scenario.cell == "failures" else 0.0
    return SymbolicWorld(there, facts, rng, failure_rate=rate, events=events, goals=goals[0])


def _bullet(scenario: Scenario, case: Case, goals: Goals, names: tuple[str, ...]) -> World:
    """In physics the thing or the slot that a disturbance is about is settled beforehand, too."""
    from llmbt.experiment.worlds import kept_world

    rng = chance(scenario.seed, "targets")
    targets = ((name, _target(name, goals[0], rng.integers)) for name in names)
    # A target says by itself when in the task it is: from the first grasp on. How many grasps went before differs by
    # method, and a number drawn for them could pass a target by.
    specs = tuple(DisturbanceSpec(n, target=t, when=When(grasp=1) if t is not None else None) for n, t in targets)
    return kept_world(case.scene, scenario.seed, specs, goals[0])


def _target(name: str, goals: tuple[Condition, ...], pick: Any) -> str | None:
    placed = [g for g in goals if g.name == "On"]
    if name == "drop" or not placed:
        return None  # whatever is carried the so-manieth time
    first, last = (1, len(placed)) if name == "obstacle_at_pick" else (0, max(1, len(placed) - 1))
    goal = placed[pick(first, last) if first < last else 0]
    return goal.args[1] if name == "obstacle_at_place" else goal.args[0]
