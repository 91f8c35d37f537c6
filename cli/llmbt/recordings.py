"""Recordings as a user manages them: what there is, whether it still holds, all of it anew from another model."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from llmbt_atl.library import Library, load_library
from llmbt_compiler.drift import Drift, answers_of, compare, play, replies_of, verify
from llmbt_compiler.pipeline import Context, compile_request
from llmbt_compiler.reasoning.cassette import (
    Cassette,
    all_cassettes,
    folders,
    read_cassette,
    write_cassette,
)
from llmbt_compiler.reasoning.chat import Record, Settings
from llmbt_compiler.reasoning.prompt import STEPS, template_version
from llmbt_compiler.stages import FRONT_ENDS
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["described", "found", "noted", "recorded_anew", "verified"]


def found(paths: Sequence[Path]) -> tuple[Path, ...]:
    """The recordings in files and folders; without any, the user's own and the shipped ones. E001 for a path that is
    not there."""
    for path in paths:
        if not path.exists():
            raise LlmbtError(Diagnostic("E001", f"`{path}` does not exist", Span(str(path))))
    return all_cassettes(paths or folders())


def described(path: Path) -> dict[str, Any]:
    """What a recording says of itself; `fault` where it is none."""
    try:
        cassette = read_cassette(path)
    except LlmbtError as wrong:
        return {"cassette": str(path), "fault": f"{wrong.diagnostics[0].code}: {wrong.diagnostics[0].title}"}
    source = {"says": cassette.provenance.words(), **dataclasses.asdict(cassette.provenance)}
    return {"cassette": str(path), "fault": "", "turns": len(cassette.turns), **source}


def verified(path: Path) -> dict[str, Any]:
    """A recording held against today."""
    row = described(path)
    if row["fault"]:
        return {**row, "good": False, "stale": True, "drift": Drift.UNKNOWN.value, "turn": 0}
    verdict = verify(read_cassette(path), _scene)
    told = {**dataclasses.asdict(verdict), "drift": verdict.drift.value, "good": verdict.good}
    return {**row, **told}


def recorded_anew(path: Path, folder: Path, settings: Settings) -> dict[str, Any]:
    """Record a dialogue's request again, into `folder` under the same name, with the same answers; and compare."""
    row = described(path)
    if row["fault"]:
        return {**row, "drift": Drift.UNKNOWN.value}
    old = read_cassette(path)
    new = folder / path.name
    try:
        scene = _scene(old.provenance.scene)
        before = _replayed(old, scene)
        _record(old, new, settings, scene)
        made = noted(new, scene)
        drift = compare(before, made.provenance.outcome, same_words=replies_of(made) == replies_of(old))
    except LlmbtError as wrong:
        first = wrong.diagnostics[0]
        return {**row, "drift": Drift.UNKNOWN.value, "fault": f"{first.code}: {first.title}"}
    now = made.provenance.outcome
    return {**row, "cassette": str(new), "drift": drift.value, "before": before, "now": now, "fault": ""}


def _record(old: Cassette, new: Path, settings: Settings, scene: tuple[SemanticMap, Library]) -> None:
    """Ask for every turn; what the replies come to is no fault here."""
    source = old.provenance
    semantic_map, library = scene
    left = list(answers_of(old))
    transport = Record(new, source.request, source.scene, template_version(), replace=new.exists())
    form = source.reply_format or STEPS
    context = Context(
        source.request,
        semantic_map,
        library,
        transport,
        replace(settings, reply_format=form),
        corrections=0,
        front_end=FRONT_ENDS[form],
    )
    try:
        compile_request(context, consult=lambda _: left.pop(0) if left else None)
    except LlmbtError:
        if not new.exists():
            raise


def noted(path: Path, scene: tuple[SemanticMap, Library]) -> Cassette:
    """A recording with a note of what its replies come to; the note is written into the file."""
    cassette = read_cassette(path)
    made = replace(cassette, provenance=replace(cassette.provenance, outcome=_replayed(cassette, scene)))
    if made != cassette:
        write_cassette(made)
    return made


def _replayed(cassette: Cassette, scene: tuple[SemanticMap, Library]) -> str:
    source = cassette.provenance
    form = source.reply_format or STEPS
    return play(source.request, *scene, replies_of(cassette), answers_of(cassette), reply_format=form).outcome


def _scene(name: str) -> tuple[SemanticMap, Library]:
    scene = load_scene(name)
    return to_semantic_map(scene), load_library(scene.library, beside=Path(scene.source).parent)
