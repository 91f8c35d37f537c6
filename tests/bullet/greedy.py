"""A policy without a tree, for tests of the world: the next unmet goal, and whatever stands in its way first."""

from __future__ import annotations

from dataclasses import dataclass, field

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.scene import Scene
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.world import Status

BUFFER = "sorting_area"
CANONICAL = tuple(
    Condition("On", (f"object_{o}", f"position_{p}")) for o, p in ((1, 12), (2, 13), (4, 14), (3, 22), (5, 23), (6, 32))
)


@dataclass
class Episode:
    """What a run was like."""

    solved: bool = False
    actions: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    ticks: int = 0


def _of(facts: Facts, name: str) -> list[Condition]:
    return sorted(f for f in facts if f.name == name)


def place_of(scene: Scene, facts: Facts, id_: str) -> str | None:
    """The most specific place that a thing is on."""
    found = [f.args[1] for f in facts if f.name == "On" and f.args[0] == id_]
    return max(found, key=lambda p: (scene.depth(p), p), default=None)


def decide(scene: Scene, facts: Facts, goals: tuple[Condition, ...]) -> ActionCall | None:
    """What to do now; None when nothing can be done."""
    for held in _of(facts, "Holding"):
        o = held.args[0]
        for g in goals:
            if g.args[0] == o and Condition("Free", (g.args[1],)) in facts:
                return ActionCall("place", g.args)
        return ActionCall("put_down", (o, BUFFER))
    for touched in _of(facts, "Touching"):
        return ActionCall("release", touched.args)
    for fallen in _of(facts, "Fallen"):
        o = fallen.args[0]
        for b in _of(facts, "Blocks"):
            where = place_of(scene, facts, b.args[0])
            if b.args[1] == o and where is not None and Condition("Clear", (b.args[0],)) in facts:
                return ActionCall("clear_away", (b.args[0], o, where, BUFFER))
        return ActionCall("recover", (o, BUFFER))
    for goal in goals:
        if goal in facts:
            continue
        o, p = goal.args
        if Condition("Free", (p,)) not in facts:
            for inside in _of(facts, "Obstructs"):
                if inside.args[1] == p and (where := place_of(scene, facts, inside.args[0])) is not None:
                    return ActionCall("clear_place", (inside.args[0], where, p, BUFFER))
            for there in _of(facts, "On"):
                if there.args[1] == p:
                    return ActionCall("move_aside", (there.args[0], p, BUFFER))
        if Condition("Clear", (o,)) in facts:
            where = place_of(scene, facts, o)
            return ActionCall("pick", (o, where)) if where else None
        for b in _of(facts, "Blocks"):
            if b.args[1] == o:
                where = place_of(scene, facts, b.args[0])
                return ActionCall("clear_away", (b.args[0], o, where, BUFFER)) if where else None
    return None


def holding_conditions(action: ActionCall) -> tuple[Condition, ...]:
    """What must stay true while an action runs."""
    match action.name, action.args:
        case "pick", (o, p):
            return (Condition("On", (o, p)), Condition("Clear", (o,)))
        case (("place" | "put_down"), (o, p)):
            return (Condition("Holding", (o,)), Condition("Free", (p,)))
        case _:
            return ()


def faults_in(facts: Facts, *, carrying: bool = False) -> list[str]:
    """Where facts contradict the library's variables. `carrying`: an action that picks and places in one runs, and what
    it holds meanwhile is not told."""
    found = []
    hand = [f for f in facts if f.name in ("HandEmpty", "Holding", "Touching")]
    if len(hand) > 1 or (not hand and not carrying):
        found.append(f"hand: {sorted(map(str, hand))}")
    for o in sorted({f.args[0] for f in facts if f.name in ("On", "Clear")}):
        at = {f.name for f in facts if f.name in ("On", "Holding", "Fallen") and f.args[0] == o}
        if len(at) > 1:
            found.append(f"position of {o}: {sorted(at)}")
        way = [f for f in facts if f.name in ("Clear", "Blocks") and f.args[-1] == o]
        if len(way) > 1:
            found.append(f"approach of {o}: {sorted(map(str, way))}")
    for f in facts:
        taken = any(g.name == "On" and g.args[1:] == f.args for g in facts)
        if f.name == "Free" and taken and f.args[0].startswith("position"):
            found.append(f"{f} though taken")
    return found


def run(world: BulletWorld, goals: tuple[Condition, ...], limit_s: float = 400.0) -> Episode:
    """Until every goal holds by the truth with the hand empty, or nothing helps."""
    episode = Episode()
    failures = 0

    def tick(action: ActionCall | None = None) -> Status:
        report = world.advance()
        episode.ticks += 1
        facts = world.observe()
        carrying = action is not None and action.name in ("move_aside", "clear_away", "clear_place", "recover")
        for fault in faults_in(facts, carrying=carrying):
            episode.faults.append(f"{world.time_s:.1f} s {fault}")
        nowhere = [
            o
            for o in world.objects()
            if world.at_rest
            and not (carrying and action is not None and o == action.args[0])
            and not any(f.args[0] == o for f in facts if f.name in ("On", "Holding", "Fallen"))
        ]
        if nowhere:
            episode.faults.append(f"{world.time_s:.1f} s nowhere: {nowhere}")
        tick.report = report  # type: ignore[attr-defined]
        return report.status

    while world.time_s < limit_s and failures < 12:
        while not world.at_rest:
            tick()
        facts = world.observe()
        if all(g in world.truth() for g in goals) and Condition("HandEmpty") in facts:
            episode.solved = True
            return episode
        action = decide(world.scene, facts, goals)
        if action is None:
            episode.actions.append("nothing to do")
            return episode
        started = world.time_s
        world.start(action)
        halted = False
        while (status := tick(action)) is Status.RUNNING:
            if not halted and not all(c in world.observe() for c in holding_conditions(action)):
                halted = True
            if halted and world.halt():
                break
        report = tick.report  # type: ignore[attr-defined]
        failures += status is Status.FAILURE
        result = "HALTED" if halted else f"{status} {report.reason} {report.blocker or ''}"
        episode.actions.append(f"{action} {result} {world.time_s - started:.1f} s")
    return episode
