"""Compiling a request: finds scene, map and library, runs the stages, and proves that the goals can be reached."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from llmbt.progress import Progress
from llmbt_atl.library import load_library
from llmbt_atl.state import Domain, domain_of
from llmbt_compiler.parsing import say
from llmbt_compiler.pipeline import STAGES, Compiled, Context, compile_request
from llmbt_compiler.reasoning.chat import Record, Replay, Settings, Transport
from llmbt_compiler.reasoning.prompt import template_version
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap, read_map
from llmbt_ir.tree import goal_tree
from llmbt_ir.versions import VersionStore, write_atomic
from llmbt_ir.xml import read_bytes
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.search import OutOfBudget, Unsolvable
from llmbt_runtime.update.loop import update

__all__ = ["Request", "compile_into", "document_of", "scene_map"]


@dataclass(frozen=True, slots=True)
class Request:
    """What to compile and how."""

    text: str
    scene: str
    map_file: Path | None = None
    cassette: Path | None = None
    record: bool = False
    replace: bool = False
    base_url: str = ""
    model: str = ""
    answers: tuple[str, ...] = ()
    tagger: str = "default"
    partial: bool = False
    stop_after: str | None = None
    start_from: str | None = None
    recognise: bool = False


def scene_map(scene: str, map_file: Path | None = None, *, recognise: bool = False) -> SemanticMap:
    """The scene's own map, the one in a file, or one recognised from the scene's cameras. E012 for both of these."""
    if map_file is not None and recognise:
        fault = Diagnostic("E012", "--map and --recognise are two maps", help="give one of them")
        raise LlmbtError(fault, exit_code=ExitCode.USAGE)
    if recognise:
        from llmbt.vision import map_of_start

        return map_of_start(load_scene(scene))
    return read_map(map_file) if map_file is not None else to_semantic_map(load_scene(scene))


def compile_into(request: Request, folder: Path, progress: Progress) -> Compiled:
    """Run the stages and write their artifacts into `folder`; the tree only once everything before it is right and
    the goals are shown to be reachable from what the map says. LlmbtError otherwise."""
    scene = load_scene(request.scene)
    semantic_map = scene_map(request.scene, request.map_file, recognise=request.recognise)
    library = load_library(scene.library, beside=Path(scene.source).parent)
    domain = domain_of(library, semantic_map)
    context = Context(
        request.text,
        semantic_map,
        library,
        _transport(request),
        _settings(request),
        request.answers,
        request.tagger,
        partial=request.partial,
    )
    compiled = compile_request(
        context,
        stop_after=request.stop_after,
        start_from=request.start_from,
        stored=lambda name: read_bytes(folder / name, "artifact"),
        keep=lambda name, data: write_atomic(folder / name, data),
        observe=lambda stage, value: progress.stage(stage.name, stage.tell(value)),
    )
    for note in compiled.notes:
        progress.stage("note", f"step {note.step_number}: {note.text}")
    tree = compiled.values.get("build")
    if tree is not None:
        _prove(compiled, context, domain)
        record = {
            "parent": None,
            "request": request.text,
            "reply": compiled.reply.provenance.provenance if compiled.reply else "",
            "goals": [
                {
                    "condition": str(g.condition),
                    "says": say(g.condition, library),
                    "step": g.step_number,
                    "words": g.words,
                }
                for g in compiled.goals
            ],
        }
        VersionStore(folder).append(tree, record, 0)
    return compiled


def _prove(compiled: Compiled, context: Context, domain: Domain) -> None:
    """E341 (exit code 3) where the goals cannot be reached from the map's state by the library's templates."""
    facts = facts_of_map(domain, context.semantic_map)
    goals = (tuple(dict.fromkeys(g.condition for g in compiled.goals)),)
    found = update(goal_tree(goals), domain.for_state(facts), facts, goals)
    if isinstance(found, OutOfBudget):
        raise LlmbtError(
            Diagnostic("E342", f"no plan was found within {found.expansions} expansions"),
            exit_code=ExitCode.NO_SUCCESS,
        )
    if isinstance(found, Unsolvable):
        blamed = [g for g in compiled.goals if g.condition in found.goals]
        raise LlmbtError(
            Diagnostic(
                "E341",
                f"the goals cannot be reached: {found.reason}",
                help="change the request, or what stands where",
                notes=tuple(f"{say(g.condition, context.library)} (step {g.step_number}: {g.words})" for g in blamed),
            ),
            exit_code=ExitCode.NO_SUCCESS,
        )


def _settings(request: Request) -> Settings:
    return Settings(request.model, request.base_url) if request.base_url else Settings(request.model)


def _transport(request: Request) -> Transport:
    if not request.record:
        return Replay(request.cassette)
    if request.cassette is None:
        raise LlmbtError(
            Diagnostic("E012", "--record needs --cassette FILE to record into", help="as --cassette my.yaml"),
            exit_code=ExitCode.USAGE,
        )
    return Record(request.cassette, request.text, request.scene, template_version(), request.replace)


def document_of(compiled: Compiled, folder: Path | None) -> Mapping[str, Any]:
    """What `compile --json` prints."""
    reply = compiled.reply
    last = next(s for s in reversed(STAGES) if s.name in compiled.values)
    return {
        "stage": last.name,
        "reply": reply.provenance.provenance if reply else None,
        "goals": [
            {
                "name": g.condition.name,
                "args": list(g.condition.args),
                "step": g.step_number,
                "words": g.words,
            }
            for g in compiled.goals
        ],
        "notes": [{"step": n.step_number, "kind": n.kind.value, "text": n.text} for n in compiled.notes],
        "tree": str(folder / "tree.v000.xml") if folder and "build" in compiled.values else None,
    }
