"""Compiling a request: finds scene, map and library, runs the stages, and proves that the goals can be reached."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from llmbt.progress import Progress
from llmbt.recordings import noted
from llmbt.rehearsal import Rehearsal, rehearse
from llmbt_atl.library import Library, load_library
from llmbt_atl.state import domain_of
from llmbt_compiler.asking import Asked
from llmbt_compiler.parsing import say, say_outcome
from llmbt_compiler.pipeline import FRONT_ENDS, Compiled, Context, compile_request, stage_names
from llmbt_compiler.reasoning.chat import DEFAULT_BASE_URL, Record, Replay, Settings, Transport
from llmbt_compiler.reasoning.dialogue import Dialogue
from llmbt_compiler.reasoning.prompt import STEPS, template_version
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap, read_map
from llmbt_ir.versions import VersionStore, write_atomic
from llmbt_ir.xml import read_bytes

__all__ = ["Done", "Request", "compile_into", "continued", "document_of", "not_confirmed", "scene_map"]

DIALOGUE = "dialogue.json"


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
    goals: Path | None = None
    reply_format: str = STEPS
    corrections: int = 2
    timeout_s: float = 60.0
    retries: int = 4
    price: str = ""


@dataclass(frozen=True, slots=True)
class Done:
    """A compilation and the rehearsal of its tree; `unused` are answers to which there was no question."""

    compiled: Compiled
    library: Library
    rehearsal: Rehearsal | None = None
    unused: tuple[str, ...] = ()
    outcomes: tuple[str, ...] = field(default=())


def scene_map(scene: str, map_file: Path | None = None, *, recognise: bool = False) -> SemanticMap:
    """The scene's own map, the one in a file, or one recognised from the scene's cameras. E012 for both of these."""
    if map_file is not None and recognise:
        fault = Diagnostic("E012", "--map and --recognise are two maps", help="give one of them")
        raise LlmbtError(fault, exit_code=ExitCode.USAGE)
    if recognise:
        from llmbt.vision import map_of_start

        return map_of_start(load_scene(scene))
    return read_map(map_file) if map_file is not None else to_semantic_map(load_scene(scene))


def compile_into(
    request: Request,
    folder: Path,
    progress: Progress,
    *,
    consult: Callable[[Asked], str | None] = lambda _: None,
    confirm: Callable[[Sequence[str]], None] = lambda _: None,
) -> Done:
    """Run the stages and write their artifacts into `folder`; the tree only once everything before it is right, the
    goals are shown to be reachable from what the map says, and nobody objects. LlmbtError otherwise.

    `consult` is asked where the answers given do not reach; `confirm` gets the goals in plain words and raises where
    they are not what is wanted.
    """
    context, domain = _context(request)
    left = list(request.answers)
    rehearsed: list[Rehearsal] = []

    def answer(asked: Asked) -> str | None:
        progress.stage("question", f"{asked.text}{_listed(asked.candidates)}")
        return left.pop(0) if left else consult(asked)

    def check(compiled: Compiled) -> None:
        rehearsed[:] = [rehearse(compiled.goals, domain, context.semantic_map, context.where)]

    try:
        compiled = compile_request(
            context,
            stop_after=request.stop_after,
            start_from=request.start_from,
            stored=lambda name: read_bytes(folder / name, "artifact"),
            keep=lambda name, data: write_atomic(folder / name, data),
            observe=lambda stage, value: progress.stage(stage.name, stage.tell(value)),
            check=check,
            consult=answer,
        )
    finally:
        if request.record and request.cassette is not None and request.cassette.exists():
            noted(request.cassette, (context.semantic_map, context.library))
    for note in compiled.notes:
        progress.stage("note", f"step {note.step_number}: {note.text}")
    if compiled.reply is not None and compiled.reply.changed:
        progress.stage("changed", "the recording said something else before:")
        for line in compiled.reply.changed:
            progress.line(f"{'':11}{line}")
    if left:
        progress.stage("note", f"there was no question left for the answer {', '.join(map(repr, left))}")
    outcomes = tuple(say_outcome(g.condition, context.library, domain.types) for g in compiled.goals)
    tree = compiled.values.get("build")
    if tree is not None:
        progress.stage("check", rehearsed[0].words())
        confirm(outcomes)
        VersionStore(folder).append(tree, _record(request, compiled, context.library), 0)
    return Done(compiled, context.library, rehearsed[0] if rehearsed else None, tuple(left), outcomes)


def _listed(candidates: Sequence[str]) -> str:
    if not candidates:
        return ""
    more = f" and {len(candidates) - 8} more" if len(candidates) > 8 else ""
    return f" [{', '.join(candidates[:8])}{more}]"


def _context(request: Request) -> tuple[Context, Any]:
    scene = load_scene(request.scene)
    semantic_map = scene_map(request.scene, request.map_file, recognise=request.recognise)
    library = load_library(scene.library, beside=Path(scene.source).parent)
    stated = None
    if request.goals is not None:
        text = read_bytes(request.goals, "goals").decode("utf-8-sig", "replace")
        stated = (text, str(request.goals))
    context = Context(
        request.text,
        semantic_map,
        library,
        _transport(request),
        _settings(request),
        request.tagger,
        partial=request.partial,
        corrections=request.corrections,
        front_end=FRONT_ENDS[request.reply_format],
        stated=stated,
    )
    names = stage_names(context)
    for stage in (request.stop_after, request.start_from):
        if stage is not None and stage not in names:
            raise LlmbtError(
                Diagnostic("E013", f"there is no stage `{stage}` on this way", help=f"it has {', '.join(names)}"),
                exit_code=ExitCode.USAGE,
            )
    return context, domain_of(library, semantic_map)


def _settings(request: Request) -> Settings:
    return Settings(
        request.model,
        request.base_url or DEFAULT_BASE_URL,
        timeout_s=request.timeout_s,
        retries=request.retries,
        reply_format=request.reply_format,
        price=request.price,
    )


def _transport(request: Request) -> Transport:
    if not request.record:
        return Replay(request.cassette)
    if request.cassette is None:
        raise LlmbtError(
            Diagnostic("E012", "--record needs --cassette FILE to record into", help="as --cassette my.yaml"),
            exit_code=ExitCode.USAGE,
        )
    return Record(request.cassette, request.text, request.scene, template_version(), request.replace)


def _record(request: Request, compiled: Compiled, library: Library) -> Mapping[str, Any]:
    """What the first version's record says besides its hashes."""
    return {
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


def continued(request: Request, folder: Path) -> Request | None:
    """The request with the answers that a dialogue in `folder` has already; None where no question about it is open
    there, or nothing is answered."""
    before = _earlier_answers(folder, request.text) if request.answers else None
    if before is None:
        return None
    again = request.answers[: len(before)] == before
    return request if again else replace(request, answers=(*before, *request.answers))


def _earlier_answers(folder: Path, request: str) -> tuple[str, ...] | None:
    try:
        dialogue = Dialogue.from_json((folder / DIALOGUE).read_bytes())
    except (OSError, ValueError, KeyError, TypeError):
        return None
    same = bool(dialogue.turns) and dialogue.turns[0].text == request
    return dialogue.answers if same and dialogue.open and not any(folder.glob("tree.v*.xml")) else None


def document_of(done: Done, folder: Path | None) -> Mapping[str, Any]:
    """What `compile --json` prints."""
    compiled = done.compiled
    reply = compiled.reply
    return {
        "stage": list(compiled.values)[-1],
        "reply": reply.provenance.provenance if reply else None,
        "goals": [
            {
                "name": g.condition.name,
                "args": list(g.condition.args),
                "negated": g.condition.negated,
                "says": says,
                "step": g.step_number,
                "words": g.words,
            }
            for g, says in zip(compiled.goals, done.outcomes, strict=True)
        ],
        "notes": [{"step": n.step_number, "kind": n.kind.value, "text": n.text} for n in compiled.notes],
        "dialogue": [{"by": t.by, "kind": t.kind, "text": t.text} for t in compiled.dialogue.turns],
        "unused_answers": list(done.unused),
        "rehearsal": done.rehearsal.as_json() if done.rehearsal is not None else None,
        "changed": list(reply.changed) if reply else [],
        "tree": str(folder / "tree.v000.xml") if folder and "build" in compiled.values else None,
    }


def not_confirmed(outcomes: Sequence[str], why: str) -> LlmbtError:
    """E145: a person has not said that these goals are wanted."""
    return LlmbtError(
        Diagnostic(
            "E145", f"the goals are not confirmed: {why}", Span("goals"), help="--yes confirms", notes=tuple(outcomes)
        ),
        exit_code=ExitCode.UNCLEAR,
    )
