"""Recordings made from replies that somebody wrote, for people (and machines) without access to a model.

The openai SDK asks, vcrpy records, and a transport inside the process answers with the written reply in the
shape of a chat completion: no socket is opened. What comes out says `authored` and names no model.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from llmbt_atl.library import Library
from llmbt_compiler.drift import play
from llmbt_compiler.reasoning import cassette as tape
from llmbt_compiler.reasoning.cassette import AUTHORED, Cassette, Provenance
from llmbt_compiler.reasoning.chat import (
    DEFAULT_BASE_URL,
    DUMMY_KEY,
    Settings,
    no_network,
    request_body,
    through_the_sdk,
)
from llmbt_compiler.reasoning.prompt import STEPS, Messages, build_prompt, clean, template_version
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span
from llmbt_ir.semantic_map import SemanticMap
from llmbt_ir.xml import Element, parse_xml, read_bytes

__all__ = ["Authored", "Dialogue", "author", "author_all", "read_replies", "read_reply"]


@dataclass(frozen=True, slots=True)
class Authored:
    """A recording that was made. `changed` is false where the file already said exactly this."""

    path: Path
    cassette: Cassette
    changed: bool


@dataclass(frozen=True, slots=True)
class Dialogue:
    """An entry of replies.xml: `answers` stand between `replies`. `line` is where it begins."""

    name: str
    scene: str
    date: str
    request: str
    replies: tuple[Path, ...]
    answers: tuple[str, ...]
    line: int = 0


def author(
    request: str,
    semantic_map: SemanticMap,
    library: Library,
    replies: Sequence[str],
    out: Path,
    *,
    answers: Sequence[str] = (),
    scene: str = "",
    date: str = "",
    overwrite: bool = False,
    reply_format: str = STEPS,
) -> Authored:
    """Make a recording from written replies, with the user's answers between them, or, where a reply is no question and
    another one follows without an answer, the complaints of the check. The same arguments give the same bytes; without
    a `date`, a file that differs in its date alone is left as it is.

    Errors: E131 (exit code 2) answers and replies do not take turns, E132 the file is the recording of a
    model or no cassette, and E120-E122 of the prompt.
    """
    old = _existing(out, overwrite)
    build_prompt(request, semantic_map, library, reply_format=reply_format)
    played = play(request, semantic_map, library, replies, answers, reply_format=reply_format)
    if len(played.prompts) != len(replies) or played.unused:
        raise LlmbtError(
            Diagnostic(
                "E131",
                f"{len(replies)} replies and {len(answers)} answers do not take turns: "
                f"{len(played.prompts)} replies are asked for, {len(played.unused)} answers are not",
                help="give --reply FILE, then for each further turn --answer TEXT and --reply FILE",
            ),
            exit_code=ExitCode.USAGE,
        )
    provenance = Provenance(
        AUTHORED,
        request=clean(request, 2000),
        scene=scene or semantic_map.scene,
        endpoint_kind="none",
        date=date or datetime.now(UTC).date().isoformat(),
        template_version=template_version(),
        reply_format=reply_format if reply_format != STEPS else "",
        outcome=played.outcome,
    )
    made = Cassette(out, provenance)
    for messages, text in zip(played.prompts, replies, strict=True):
        made = _add_turn(made, messages, text, reply_format)
    if old is not None and not date:
        dated = replace(made, provenance=replace(provenance, date=old.provenance.date))
        made = dated if tape.render_cassette(dated) == tape.render_cassette(old) else made
    changed = not out.exists() or out.read_text(encoding="utf-8") != tape.render_cassette(made)
    if changed:
        tape.write_cassette(made)
    return Authored(out, made, changed)


def _existing(out: Path, overwrite: bool) -> Cassette | None:
    if not out.exists() or overwrite:
        return None
    try:
        old = tape.read_cassette(out)
    except LlmbtError:
        old = None
    if old is None or not old.provenance.authored:
        what = f"is {old.provenance.words()}" if old is not None else "is no cassette"
        raise LlmbtError(
            Diagnostic("E132", f"`{out}` {what}; it is not written over", Span(str(out)), help="name another file")
        )
    return old


def _add_turn(made: Cassette, messages: Messages, text: str, reply_format: str) -> Cassette:
    import httpx2

    settings = Settings(base_url=DEFAULT_BASE_URL, retries=0, reply_format=reply_format)
    sha256 = tape.body_hash(request_body(messages, settings))
    if made.turn(sha256) is not None:
        return made

    def answer(_: Any) -> Any:
        return httpx2.Response(200, json=_completion(text, sha256))

    with (
        no_network(),
        tape.session(made, record=True) as saved,
        httpx2.Client(transport=httpx2.MockTransport(answer), trust_env=False) as client,
    ):
        through_the_sdk(messages, settings, DUMMY_KEY, client)
    return saved[-1]


def _completion(text: str, sha256: str) -> dict[str, Any]:
    return {
        "id": f"authored-{sha256[:12]}",
        "object": "chat.completion",
        "created": 0,
        "model": AUTHORED,
        "choices": [
            {
                "index": 0,
                "message": {"role": "assistant", "content": text.encode("utf-8", "replace").decode("utf-8")},
                "finish_reason": "stop",
            }
        ],
    }


def read_reply(path: Path) -> str:
    """The words of a reply file: UTF-8, where a byte that is none becomes the replacement character. E001,
    E002."""
    return read_bytes(path, "reply").decode("utf-8-sig", "replace")


def read_replies(path: Path) -> tuple[Dialogue, ...]:
    """Read replies.xml; each faulty line is told (E001-E006, and E134 a name used twice)."""
    root = parse_xml(read_bytes(path, "list of replies"), str(path), schema=f"{__package__}:replies")
    found: list[Dialogue] = []
    for node in root.iterfind("Dialogue"):
        name, line = node.get("name", ""), _line(node)
        if any(d.name == name for d in found):
            raise LlmbtError(Diagnostic("E134", f"the dialogue `{name}` is there twice", Span(str(path), line)))
        found.append(
            Dialogue(
                name,
                node.get("scene", ""),
                node.get("date", ""),
                " ".join((node.findtext("Request") or "").split()),
                tuple(path.parent / str(r.get("file")) for r in node.iterfind("Reply")),
                tuple(" ".join((a.text or "").split()) for a in node.iterfind("Answer")),
                line,
            )
        )
    return tuple(found)


def _line(node: Element) -> int:
    line: Any = node.sourceline
    return line if isinstance(line, int) else 0


def author_all(
    replies: Path, out: Path, scene_of: Callable[[str], tuple[SemanticMap, Library]]
) -> tuple[Authored, ...]:
    """Every dialogue of `replies`/replies.xml as `out`/NAME.yaml. `scene_of` gives a scene's map and
    library."""
    return tuple(
        author(
            d.request,
            *scene_of(d.scene),
            [read_reply(r) for r in d.replies],
            out / f"{d.name}.yaml",
            answers=d.answers,
            scene=d.scene,
            date=d.date,
        )
        for d in read_replies(replies / "replies.xml")
    )
