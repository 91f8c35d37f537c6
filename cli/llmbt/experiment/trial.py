"""One trial: a request is compiled from its recording, its tree executed with one disturbance, the end judged by the
truth at rest."""

from __future__ import annotations

import json
import time
import traceback
from collections.abc import Iterable, Mapping
from dataclasses import replace
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Any

from llmbt.compilation import Request as Order
from llmbt.compilation import compile_into
from llmbt.execution import Order as Execution
from llmbt.execution import execute_tree
from llmbt.experiment.cases import Case, Request, cassette_of
from llmbt.experiment.plan import Trial
from llmbt.progress import Progress
from llmbt_atl.state import Domain
from llmbt_compiler.reasoning.cassette import read_cassette
from llmbt_ir.condition import Condition, Facts, Goals, satisfied
from llmbt_ir.diagnostics import ExitCode, LlmbtError
from llmbt_ir.scene import Scene, to_semantic_map
from llmbt_ir.versions import VersionStore, write_atomic
from llmbt_runtime.chance import chance
from llmbt_runtime.disturbance import DisturbanceSpec
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.variation import varied
from llmbt_runtime.world import World, WorldLostError

__all__ = ["Verdict", "come_to_rest", "judged", "means", "run_trial"]


class Verdict(StrEnum):
    """What a trial came to. Every trial has exactly one; all but SUCCESS count as no success.

    ASKED and REFUSED: the compiler ended with a question, or with a diagnostic. PARSER: the compiled goals do not mean
    the case's success. UPDATE: the loop ended short of the goals. ACTION: actions failed until nothing led on.
    RECOGNITION: the camera's map was wrong. TRUTH: the loop claims success and the truth denies it. FAULT: our own bug.
    """

    SUCCESS = "success"
    ASKED = "asked"
    REFUSED = "refused"
    PARSER = "parser"
    UPDATE = "update"
    ACTION = "action"
    RECOGNITION = "recognition"
    TRUTH = "truth"
    FAULT = "fault"


def means(goals: Iterable[Condition], success: Goals, domain: Domain) -> bool:
    """Whether reaching goals is a success, no more and no less: for one of its alternatives each condition follows from
    a goal, and each goal brings one of its conditions about."""
    goals = tuple(goals)
    if any(g.negated or g.name not in domain.library.conditions for g in goals):
        return False
    implied = [frozenset(domain.upward(g)) for g in goals]
    return any(
        all(any(c in facts for facts in implied) for c in alternative)
        and all(not facts.isdisjoint(alternative) for facts in implied)
        for alternative in success
    )


def come_to_rest(world: World, patience_s: float = 3.0) -> None:
    """Let a world go on without an action until nothing moves, or for a bounded time."""
    waited = 0.0
    while waited < patience_s:
        world.settle(0.5)
        waited += 0.5
        if world.at_rest:
            return


def judged(success: Goals, world: World, outcome: Outcome, *, sees: bool = False) -> dict[str, Any]:
    """The success condition by the truth, at rest. A success was checked at rest by the executor; everything else is
    given time to come to rest. Of a world that `sees` also whether what is then seen of where things are is true."""
    try:
        if outcome not in (Outcome.SUCCESS, Outcome.WORLD_LOST):
            come_to_rest(world)
        truth = world.truth()
        found = {"success_by_truth": satisfied(success, truth), "at_rest": world.at_rest}
        return found | ({"seen_right": _where(world.observe()) == _where(truth)} if sees else {})
    except WorldLostError:
        return {"success_by_truth": False, "at_rest": False}


def _where(facts: Facts) -> Facts:
    return frozenset(c for c in facts if c.name in ("On", "Holding"))


def run_trial(trial: Trial, case: Case, folder: Path) -> dict[str, Any]:
    """Run a trial in an empty folder, which afterwards holds what any run leaves; its line of the ledger.

    LlmbtError only where there is no recording (exit code 4): that is no result of the trial.
    """
    began = time.monotonic()
    request = next(r for r in case.requests if r.id == trial.request)
    try:
        found = _compiled_once(case, request, folder)
        if "goals" in found:
            found |= _executed(trial, case, folder)
    except LlmbtError as fault:
        if fault.exit_code is ExitCode.NO_RECORDING:
            raise
        found = _fault(f"{fault}")
    except Exception:
        (folder / "fault.txt").write_text(traceback.format_exc(), encoding="utf-8")
        found = _fault(traceback.format_exc().strip().splitlines()[-1])
    line = trial.as_json() | {"kind": "clear" if request.clear else "unclear", "register": request.register}
    return line | found | {"verdict": _verdict(line | found), "wall_time_s": round(time.monotonic() - began, 3)}


def _fault(why: str) -> dict[str, Any]:
    return {"compiled": "fault", "says": why}


_KEPT: dict[tuple[str, str], tuple[dict[str, Any], Mapping[str, bytes]]] = {}
"""What a request compiled to in this process, with the files. There is no chance in compiling, so its further trials
take what the first made."""


def _compiled_once(case: Case, request: Request, folder: Path) -> dict[str, Any]:
    key = case.source, request.id
    if key not in _KEPT:
        found = _compiled(case, request, folder)
        _KEPT[key] = found, {p.name: p.read_bytes() for p in folder.iterdir()}
        return dict(found)
    found, files = _KEPT[key]
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return dict(found)


def _compiled(case: Case, request: Request, folder: Path) -> dict[str, Any]:
    """Compile; the goals, or why there are none. A diagnostic is a result, a missing recording is not."""
    recording = cassette_of(case, request)
    source = read_cassette(recording).provenance
    order = Order(request.text, case.scene.source, cassette=recording)
    told = {"reply": source.provenance, "reply_source": source.words()}
    try:
        compiled = compile_into(order, folder, Progress(quiet=True))
    except LlmbtError as fault:
        if fault.exit_code is ExitCode.NO_RECORDING:
            raise
        codes = [d.code for d in fault.diagnostics]
        asked = fault.exit_code is ExitCode.UNCLEAR
        return told | {
            "compiled": "asked" if asked else "refused",
            "by": "reply" if "E140" in codes else "check",
            "codes": codes,
            "says": fault.diagnostics[0].title,
        }
    goals = [g.condition for g in compiled.compiled.goals]
    return told | {
        "compiled": "tree",
        "goals": [str(g) for g in goals],
        "goals_right": means(goals, case.success, case.domain()),
    }


def _executed(trial: Trial, case: Case, folder: Path) -> dict[str, Any]:
    tree = folder / "tree.v000.xml"
    there = trial.setting
    order = Execution(
        *(case.scene, there.world, trial.seed, "random"), vary=there.scenes == "varied", perception=there.perception
    )
    seen: dict[str, Any] = {}
    if there.world == "symbolic" and there.perception == "camera":
        right, state = _seen(trial, case, folder)
        order, seen = replace(order, state=state), {"seen_right": right}
    document = execute_tree(
        tree.read_bytes(),
        str(tree),
        folder,
        order,
        Progress(quiet=True),
        judge=lambda world, outcome: judged(case.success, world, outcome, sees=there.perception == "camera"),
        physics=None if order.vary else partial(_physics, sees=there.perception == "camera"),
    )
    seen = {"seen_right": document["seen_right"], **seen} if "seen_right" in document else seen
    told = [v.record for v in VersionStore(folder).versions()]
    return {
        "outcome": document["outcome"],
        "reason": document.get("reason", ""),
        "success_by_truth": document["success_by_truth"],
        "at_rest": document["at_rest"],
        "drawn": document["drawn"],
        "disturbances": document["disturbances"],
        "actions": len(document["actions"]),
        "failed_actions": sum(a["result"] == "FAILURE" for a in document["actions"]),
        "updates": document["updates"],
        "planner_calls": document["planner_calls"],
        "nodes": [r["nodes"] for r in told if "nodes" in r],
        "sim_time_s": document["sim_time_s"],
        **seen,
    }


def _physics(
    scene: Scene, seed: int, specs: tuple[DisturbanceSpec, ...], aims: tuple[Condition, ...], *, sees: bool
) -> World:
    from llmbt.experiment.worlds import kept_world

    return kept_world(scene, seed, specs, aims, sees=sees)


def _seen(trial: Trial, case: Case, folder: Path) -> tuple[bool, Path]:
    """The facts that the cameras show before the run, as a state to start from, and whether they are the true ones."""
    from llmbt.vision import map_of_start

    scene = case.scene
    if trial.setting.scenes == "varied":
        scene = varied(scene, chance(trial.seed, "vary"))
    domain = case.domain()
    facts = facts_of_map(domain, map_of_start(scene, seed=trial.seed))
    path = folder / "seen.json"
    write_atomic(path, json.dumps({"certificate": {"state": sorted(map(str, facts))}}).encode())
    return facts == facts_of_map(domain, to_semantic_map(scene)), path


def _verdict(found: Mapping[str, Any]) -> str:
    if found["compiled"] != "tree":
        return {"asked": Verdict.ASKED, "refused": Verdict.REFUSED, "fault": Verdict.FAULT}[found["compiled"]]
    if not found["goals_right"]:
        return Verdict.PARSER
    outcome = Outcome(found["outcome"])
    if not found.get("seen_right", True) and (found["world"] == "symbolic" or outcome is not Outcome.SUCCESS):
        return Verdict.RECOGNITION  # what follows from facts that are wrong is judged by them, and means nothing
    if outcome is Outcome.SUCCESS:
        return Verdict.SUCCESS if found["success_by_truth"] else Verdict.TRUTH
    return Verdict.ACTION if outcome in (Outcome.ACTION_FAILED, Outcome.WORLD_LOST) else Verdict.UPDATE
