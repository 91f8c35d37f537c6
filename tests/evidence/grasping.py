"""Taking one thing and putting it down, alone: no tree, no disturbance, everything drawn by the seed."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.geometry import Pose, quat_from_yaw
from llmbt_ir.scene import Body, Scene, load_scene
from llmbt_runtime.bullet.world import BulletWorld
from llmbt_runtime.world import Status
from tests.evidence.ledger import Row, filled

__all__ = ["grasping"]

Rng = np.random.Generator
_LOCATIONS = ("bar", "table", "shelf", "desk")


@dataclass(frozen=True)
class Trial:
    """A scene with one thing in it, where that is, and where it is to go."""

    scene: Scene
    start: str
    goal: str
    drives: bool


def block(rng: Rng) -> Trial:
    """A block of 4 to 5 cm anywhere in the sorting area, onto any position of the shelf."""
    scene = load_scene("cargo_sorting")
    size = float(rng.uniform(0.04, 0.05))
    slots = [p.id for p in scene.places if p.is_slot]
    shape = replace(scene.objects[0], size_m=(size, size, size))
    return Trial(with_one(scene, shape, "sorting_area", rng), "sorting_area", str(rng.choice(slots)), drives=False)


def shape_of(kind: str, rng: Rng) -> dict[str, Any]:
    """A can, a carton, or a bag (which is a rigid box here, wider than thick)."""
    across, height = float(rng.uniform(0.05, 0.066)), float(rng.uniform(0.10, 0.18))
    mass = float(rng.uniform(0.1, 0.5))
    if kind == "can":
        return {"shape": "cylinder", "size_m": (across, across, height), "mass_kg": mass, "rolling": 0.004}
    deep = across if kind == "carton" else float(rng.uniform(0.07, 0.12))
    return {"shape": "box", "size_m": (deep, across, height), "mass_kg": mass, "rolling": 0.0}


def provisions(rng: Rng) -> Trial:
    """A can, a carton or a bag anywhere on the bar, the table, the shelf or the desk, onto another of them."""
    scene = load_scene("household")
    kind = ("can", "carton", "bag")[int(rng.integers(3))]
    start, goal = (str(x) for x in rng.permutation(_LOCATIONS)[:2])
    shape = replace(scene.objects[0], **shape_of(kind, rng))
    return Trial(with_one(scene, shape, start, rng), start, goal, drives=True)


def with_one(scene: Scene, body: Body, place: str, rng: Rng) -> Scene:
    """The scene with one thing somewhere on a place, turned at random, and nothing else."""
    there = scene.place(place)
    assert there.surface_m is not None
    half = math.hypot(body.size_m[0], body.size_m[1]) / 2
    x, y = (there.surface_m[i] + float(rng.uniform(-1, 1)) * max(0.0, there.size_m[i] / 2 - half) for i in (0, 1))
    pose = Pose((x, y, there.surface_m[2] + body.size_m[2] / 2), quat_from_yaw(float(rng.uniform(0, 2 * math.pi))))
    return replace(scene, objects=(replace(body, pose=pose),), obstacles=())


def tried(draw: Callable[[Rng], Trial], seed: int) -> Row:
    """One trial: how it ended, and how far the thing came to lie from where the skill meant to put it."""
    trial = draw(np.random.default_rng(seed))
    thing = trial.scene.objects[0]
    world = BulletWorld(trial.scene, seed=seed)
    aimed: list[tuple[float, float]] = []
    let_go = world._approach.let_go

    def noting(carried: Any, x: float, y: float, *rest: Any) -> Any:
        aimed.append((x, y))
        return let_go(carried, x, y, *rest)

    world._approach.let_go = noting  # type: ignore[method-assign]
    steps = [ActionCall("pick", (thing.id, trial.start)), ActionCall("place", (thing.id, trial.goal))]
    if trial.drives:
        steps = [s for step in steps for s in (ActionCall("navigate", (step.args[1],)), step)]
    row: Row = {"shape": thing.shape, "size_m": [round(s, 4) for s in thing.size_m], "way": [trial.start, trial.goal]}
    try:
        for step in steps:
            world.start(step)
            while (report := world.advance()).status is Status.RUNNING and world.time_s < 200:
                pass
            if report.status is not Status.SUCCESS:
                return row | {"ok": False, "why": f"{step.name}: {report.reason or 'too long'}"}
        world.settle(1.0)
        if Condition("On", (thing.id, trial.goal)) not in world.truth():
            return row | {"ok": False, "why": "not where it should be, at rest"}
        x, y, _ = world.objects()[thing.id]
        off = 1e3 * math.dist((x, y), aimed[-1])
        return row | {"ok": True, "off_mm": round(off, 3), "sim_time_s": round(world.time_s, 1)}
    finally:
        world.close()


def grasping(runs: int | None, first: int | None) -> list[str]:
    """Both kinds of trials, as a table."""
    lines = [
        "## Taking and putting down alone",
        "",
        "One thing in the scene, of random size, at a random pose; the error is from where the skill meant to put it.",
        "",
        "| | succeeded | error in mm: median, 95 %, worst | seeds |",
        "|---|---|---|---|",
    ]
    lost = []
    far = "cans, cartons and bags (rigid boxes), from one piece of furniture to another"
    kinds = (
        ("blocks", "blocks, from the sorting area onto the shelf", block, 200, 40_000),
        ("provisions", far, provisions, 100, 41_000),
    )
    for name, words, draw, number, begin in kinds:
        seeds = range(begin if first is None else first, (begin if first is None else first) + (runs or number))
        rows = filled(name, seeds, lambda seed, draw=draw: tried(draw, seed))  # type: ignore[misc]
        off = sorted(r["off_mm"] for r in rows if r["ok"])
        lost += [
            f"- {name}, seed {r['seed']}: {r['why']} ({r['shape']} {r['size_m']}, {r['way']})"
            for r in rows
            if not r["ok"]
        ]
        spread = f"{statistics.median(off):.2f}, {off[int(0.95 * len(off))]:.2f}, {off[-1]:.2f}" if off else ""
        lines.append(f"| {words} | {len(off)}/{len(rows)} | {spread} | {seeds.start} to {seeds.stop - 1} |")
    return [*lines, "", *lost]
