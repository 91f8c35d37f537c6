"""An execution with its story told and its result written: what `execute`, `run` and `solve` have in common."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from llmbt import __version__
from llmbt.progress import Progress
from llmbt_ir.condition import Goals
from llmbt_ir.diagnostics import ExitCode
from llmbt_ir.tree_xml import GoalRecord
from llmbt_runtime.outcome import Happening, Outcome, Result
from llmbt_runtime.record import RunFolder, result_document, write_result
from llmbt_runtime.world import World

__all__ = ["Judge", "exit_code_of", "goal_records", "recorded"]


Judge = Callable[[World, Outcome], Mapping[str, Any]]
"""Looks at the world after the end, for fields of its own in `result.json`."""


def exit_code_of(outcome: Outcome) -> ExitCode:
    """The process's answer to an outcome."""
    if outcome is Outcome.SUCCESS:
        return ExitCode.OK
    return ExitCode.INTERRUPTED if outcome is Outcome.INTERRUPTED else ExitCode.NO_SUCCESS


def goal_records(goals: Goals) -> tuple[GoalRecord, ...]:
    """The goals as a tree's provenance names them."""
    flat = ((k, g) for k, alternative in enumerate(goals, 1) for g in alternative)
    return tuple(GoalRecord(f"g{i}", g, alternative=k) for i, (k, g) in enumerate(flat, 1))


def _no_picture(_: str) -> None:
    """Nobody wants one."""


def recorded(
    act: Callable[[Callable[[Happening], None]], Result],
    world: World,
    run: RunFolder,
    progress: Progress,
    *,
    started: float,
    seed: int,
    extra: Mapping[str, Any],
    picture: Callable[[str], None] = _no_picture,
    names: Mapping[str, str] | None = None,
    judge: Judge | None = None,
) -> dict[str, Any]:
    """Let something act in a world, hand it what hears the story, and write `events.jsonl` and `result.json`, whose
    content is returned; what `judge` says of the world after the end is part of it. The world is closed. `names`
    gives a template's name elsewhere."""

    def tell(happening: Happening) -> None:
        run.tell(happening)
        progress.tell(happening)
        if happening.kind == "update":
            picture(str(happening.details["version"]))

    try:
        picture("start")
        result = act(tell)
        picture("end")
        document = result_document(
            result,
            world,
            versions=run.number + 1,
            seed=seed,
            wall_time_s=time.monotonic() - started,
            extra={**extra, "llmbt_version": __version__},
            names=names,
        )
        if judge is not None:
            document.update(judge(world, result.outcome))
    finally:
        world.close()
    write_result(run.folder, document)
    missing = list(Counter(document.get("drawn", ())) - Counter(d["name"] for d in document["disturbances"]))
    if missing:
        progress.line(f"never came about: {', '.join(missing)}")
    return document
