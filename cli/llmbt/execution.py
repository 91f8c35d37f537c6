"""Executing a tree: finds scene, library and world, and writes the run's folder. Shared by `execute` and `run`."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from llmbt.progress import Progress
from llmbt.recorded import Judge, goal_records, recorded
from llmbt_atl.library import Library, load_library
from llmbt_atl.state import Domain, domain_of
from llmbt_ir.condition import ActionCall, Condition, Facts, Goals, parse_condition
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Severity, Span, nearest
from llmbt_ir.scene import Scene, to_semantic_map
from llmbt_ir.semantic_map import write_map
from llmbt_ir.tree import Tree, goals_of
from llmbt_ir.tree_xml import Provenance, TreeFile, parse_tree
from llmbt_ir.versions import VersionStore, sha256, write_atomic
from llmbt_ir.xml import read_bytes
from llmbt_runtime.chance import chance
from llmbt_runtime.disturbance import DisturbanceSpec, applicable, draw
from llmbt_runtime.engine.drive import drive
from llmbt_runtime.engine.program import Program
from llmbt_runtime.executor import Settings, execute
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.outcome import Happening, Result
from llmbt_runtime.record import RunFolder, signatures_of
from llmbt_runtime.schedule import read_schedule
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.symbolic_disturbance import symbolic_events
from llmbt_runtime.world import World

__all__ = ["Order", "Physics", "execute_tree", "is_schedule", "load_tree", "read_state"]


Physics = Callable[[Scene, int, tuple[DisturbanceSpec, ...], tuple[Condition, ...]], World]
"""Opens a physical world for a scene, a seed, what is to come, and what it is to come about."""


@dataclass(frozen=True, slots=True)
class Order:
    """What to execute and how."""

    scene: Scene
    world: str = "bullet"
    seed: int = 0
    disturb: str = "none"
    budget: int = 200_000
    pictures: bool = False
    state: Path | None = None
    update: bool = True


def load_tree(data: bytes, source: str, scene: Scene) -> tuple[TreeFile, Library, Domain, Goals]:
    """A tree with the library and the domain of its scene, and its goals: those its provenance names, or else those
    that the tree states. E055 where it names a thing that the scene does not have, E058 without goals."""
    library = load_library(scene.library, beside=Path(scene.source).parent)
    file = parse_tree(data, source, signatures_of(library))
    domain = domain_of(library, to_semantic_map(scene))
    _check_leaves(
        ((leaf, file.line(n.id)) for n in file.tree.preorder() if (leaf := n.condition or n.action)),
        library,
        domain,
        scene,
    )
    try:
        goals = file.goals or goals_of(file.tree)
    except ValueError as fault:
        raise LlmbtError(Diagnostic("E058", str(fault), file.line(file.tree.root))) from None
    return file, library, domain, goals


def _check_leaves(
    leaves: Iterable[tuple[Condition | ActionCall, Span]], library: Library, domain: Domain, scene: Scene
) -> None:
    """E055, E059 where a leaf names a thing that the scene does not have, or that is of the wrong type."""
    known = {**domain.types, **{b.id: b.type for b in scene.obstacles}}
    faults = []
    for leaf, span in leaves:
        declared = library.conditions.get(leaf.name) or library.templates[leaf.name]
        for arg, param in zip(leaf.args, declared.params, strict=True):
            close = nearest(arg, known)
            if arg not in known:
                hint = f"did you mean {', '.join(close)}?" if close else f"see `llmbt atl show {library.name}`"
                title = f"scene `{scene.name}` has no `{arg}`"
                faults.append(Diagnostic("E055", title, span, help=hint, candidates=close))
            elif not library.is_a(known[arg], param.type):
                title = f"`{arg}` is of type {known[arg]}, and `{leaf.name}` takes a {param.type} as {param.name}"
                faults.append(Diagnostic("E059", title, span))
    if faults:
        raise LlmbtError(*faults[:10])


def load_program(data: bytes, source: str, scene: Scene) -> tuple[Program, Library, Domain, Provenance]:
    """Any BehaviorTree.CPP 4 file as the engine ticks it (docs/engine.md), with the library and the domain of its
    scene, and the provenance of a tree of ours."""
    from llmbt_ir.btcpp.document import parse_document
    from llmbt_ir.btcpp.includes import with_includes
    from llmbt_runtime.engine.load import program_of_document

    library = load_library(scene.library, beside=Path(scene.source).parent)
    document, faults = with_includes(parse_document(data, source), Path(source))
    if faults:
        raise LlmbtError(*(replace(f, severity=Severity.ERROR) for f in faults))
    program = program_of_document(document, signatures_of(library))
    try:
        provenance = parse_tree(data, source, signatures_of(library)).provenance
    except LlmbtError:
        provenance = Provenance()
    domain = domain_of(library, to_semantic_map(scene))
    leaves = ((leaf, Span(source, n.line)) for n in program.nodes if (leaf := n.condition or n.action))
    _check_leaves(leaves, library, domain, scene)
    return program, library, domain, provenance


def execute_tree(
    data: bytes,
    source: str,
    folder: Path,
    order: Order,
    progress: Progress,
    *,
    extra: Mapping[str, Any] | None = None,
    judge: Judge | None = None,
    physics: Physics | None = None,
) -> dict[str, Any]:
    """Execute a tree in `folder`, which holds it as its newest version already or gets it as v000.

    Writes the versions, `events.jsonl` and `result.json`, and returns the latter's content; what `judge` says of the
    world after the end is part of it. `physics` opens a physical world in place of a new one.
    """
    started = time.monotonic()
    tree: Tree | Program
    if order.update:
        file, library, domain, goals = load_tree(data, source, order.scene)
        tree, provenance = file.tree, file.provenance
    else:
        tree, library, domain, provenance = load_program(data, source, order.scene)
        goals = provenance.stated
    aims = goals[0] if goals else _aims(tree, domain)
    start = facts_of_map(domain, to_semantic_map(order.scene))
    specs = disturbances(order, domain, start, aims)
    kind: dict[str, Any] = {} if order.update else {"update": False}
    run = _run_folder(data, source, provenance, library, folder, goals, kind)
    if not (folder / "map.xml").exists():
        write_atomic(folder / "map.xml", write_map(to_semantic_map(order.scene)))
    world = _world(order, domain, aims, specs, physics or _bullet)
    told = {
        "scene": order.scene.name,
        "world": order.world,
        "disturb": order.disturb,
        "drawn": [s.name for s in specs],
        **kind,
        **(extra or {}),
    }

    def picture(name: str) -> None:
        if order.pictures and order.world == "bullet":
            _picture(world, folder, name)

    settings = Settings(order.budget)

    def act(tell: Callable[[Happening], None]) -> Result:
        if isinstance(tree, Program):
            return drive(world, domain, tree, goals, tell=tell, max_ticks=settings.max_ticks)
        return execute(world, domain, tree, goals, keep=run.keep, tell=tell, settings=settings)

    return recorded(
        act, world, run, progress, started=started, seed=order.seed, extra=told, picture=picture, judge=judge
    )


def _aims(tree: Tree | Program, domain: Domain) -> tuple[Condition, ...]:
    """What a tree that states no goals is about, for the disturbances: where its actions put things."""
    calls = [n.action for n in tree.nodes if n.action] if isinstance(tree, Program) else []
    adds = dict.fromkeys(c for call in calls if (a := domain.action(call)) for c in sorted(a.adds))
    implied = {u for c in adds for u in domain.upward(c) if u != c}
    return tuple(c for c in adds if c.name == "On" and c not in implied)


def _run_folder(
    data: bytes,
    source: str,
    provenance: Provenance,
    library: Library,
    folder: Path,
    goals: Goals,
    told: Mapping[str, Any],
) -> RunFolder:
    """The folder's versions: those of the compile that wrote this very tree, or this tree copied as v000 with a record
    that says what is `told`."""
    store = VersionStore(folder)
    versions = store.versions()
    if versions and versions[-1].record["sha256"] == sha256(data):
        number = versions[-1].number
    elif versions:
        raise LlmbtError(
            Diagnostic("E010", f"`{folder}` holds another run", help="give an empty folder"),
            exit_code=ExitCode.USAGE,
        )
    else:
        number = 0
        record = {
            "parent": None,
            "parent_sha256": provenance.parent_sha256,
            "from": Path(source).name,
            **told,
        }
        store.append(data, record, 0)
    records = provenance.goals or goal_records(goals)
    return RunFolder(folder, signatures_of(library), records, number, sha256(data), f"tree.v{number:03d}.xml")


def disturbances(
    order: Order, domain: Domain, start: Facts, aims: tuple[Condition, ...]
) -> tuple[DisturbanceSpec, ...]:
    """What `--disturb` asks for: names, drawn from those that apply, or a schedule in a file."""
    if is_schedule(order.disturb):
        known = {*domain.types, *(b.id for b in order.scene.obstacles)}
        return read_schedule(Path(order.disturb), known, domain.library.templates)
    names = draw(order.disturb, chance(order.seed, "disturb"), applicable(domain, start, aims))
    return tuple(DisturbanceSpec(name) for name in names)


def is_schedule(disturb: str) -> bool:
    """Whether `--disturb` names a file."""
    return disturb.endswith(".xml") or "/" in disturb


def _world(
    order: Order,
    domain: Domain,
    aims: tuple[Condition, ...],
    specs: tuple[DisturbanceSpec, ...],
    physics: Physics,
) -> World:
    made: dict[str, Callable[[], World]] = {
        "symbolic": lambda: _symbolic(order, domain, aims, specs),
        "bullet": lambda: physics(order.scene, order.seed, specs, aims),
    }
    return made[order.world]()


def _symbolic(order: Order, domain: Domain, aims: tuple[Condition, ...], specs: tuple[DisturbanceSpec, ...]) -> World:
    facts = read_state(order.state) if order.state else facts_of_map(domain, to_semantic_map(order.scene))
    there = domain.for_state(facts)
    rng = chance(order.seed, "world")
    return SymbolicWorld(there, facts, rng, events=symbolic_events(specs, there, facts, aims, rng), goals=aims)


def read_state(path: Path) -> Facts:
    """The state that a version's record says its certificate starts from. E063 where there is none."""
    try:
        texts = json.loads(read_bytes(path, "record"))["certificate"]["state"]
        facts = frozenset(c for t in texts if (c := parse_condition(t)) is not None)
    except (ValueError, KeyError, TypeError):
        facts = frozenset()
    if not facts:
        hint = "give the tree.vNNN.json of a version that was made during a run"
        raise LlmbtError(Diagnostic("E063", "no state is recorded here", Span(str(path)), help=hint))
    return facts


def _bullet(scene: Scene, seed: int, specs: tuple[DisturbanceSpec, ...], aims: tuple[Condition, ...]) -> World:
    from llmbt_runtime.bullet.world import BulletWorld

    return BulletWorld(scene, seed, disturbances=specs, goals=aims)


def _picture(world: World, folder: Path, name: str) -> None:
    """A PNG of the scene as it is now."""
    from llmbt_runtime.bullet.camera import render_png
    from llmbt_runtime.bullet.world import BulletWorld

    assert isinstance(world, BulletWorld)
    render_png(world, folder / f"scene.{name}.png")
