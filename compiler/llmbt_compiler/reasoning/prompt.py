"""The prompt: request, semantic map and library as symbols, rendered the same way every time.

Contract: the messages depend on nothing but the arguments' ids, names, colours, shapes, places and words, and on the
relations that hold between things by their margins; no float, path, clock or iteration order of a set gets in. Names
are data: cleaned, bounded and quoted.
"""

from __future__ import annotations

import hashlib
import importlib.resources
import json
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from llmbt_atl.library import Library
from llmbt_compiler.relations import facts_of
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap

if TYPE_CHECKING:
    from jinja2 import Template

__all__ = [
    "GOALS",
    "MAX_PROMPT_CHARS",
    "MAX_REQUEST_CHARS",
    "STEPS",
    "Message",
    "Messages",
    "Prompt",
    "build_prompt",
    "clean",
    "continue_prompt",
    "correct_prompt",
    "quoted",
    "request_of",
    "template_version",
]

Message = tuple[str, str]
"""(role, content); role is system, user or assistant."""
Messages = tuple[Message, ...]

STEPS, GOALS = "steps", "json"
"""What the model may be asked for: steps in words, or the goals themselves."""
TEMPLATE_NUMBER = 2
"""Goes up when the meaning of the prompt changes; the hash in `template_version` sees every other change."""
MAX_REQUEST_CHARS = 2_000
MAX_NAME_CHARS = 80
MAX_FACT_CHARS = 2_000
MAX_QUESTION_CHARS = 500
MAX_PROMPT_CHARS = 60_000
MAX_DEPTH = 12


@dataclass(frozen=True, slots=True)
class Prompt:
    """What is sent: messages, and the version of the template they were made with."""

    messages: Messages
    template_version: str

    def text(self) -> str:
        """The messages as a person reads them."""
        return "\n".join(f"[{role}]\n{content}\n" for role, content in self.messages)

    def as_json(self) -> dict[str, Any]:
        """The artifact `prompt.json`."""
        return {
            "schema_version": 1,
            "template_version": self.template_version,
            "messages": [{"role": role, "content": content} for role, content in self.messages],
        }

    @staticmethod
    def from_json(data: Mapping[str, Any]) -> Prompt:
        """The inverse of `as_json`; KeyError or TypeError where it is not one."""
        return Prompt(
            tuple((str(m["role"]), str(m["content"])) for m in data["messages"]),
            str(data["template_version"]),
        )


def clean(text: str, limit: int = MAX_NAME_CHARS) -> str:
    """One line of printable text: control and invisible characters out, runs of space to one, at most `limit`
    long."""
    kept = (
        " " if c in "\t\n\r\v\f\x85\u2028\u2029" else c
        for c in unicodedata.normalize("NFC", text)
        if c in "\t\n\r\v\f\x85\u2028\u2029" or not unicodedata.category(c).startswith("C")
    )
    line = " ".join("".join(kept).split())
    return line if len(line) <= limit else line[: limit - 1].rstrip() + "…"


def quoted(text: str, limit: int = MAX_NAME_CHARS) -> str:
    """Cleaned text between double quotes; quotes and backslashes within are escaped."""
    return json.dumps(clean(text, limit), ensure_ascii=False)


def build_prompt(request: str, semantic_map: SemanticMap, library: Library, *, reply_format: str = STEPS) -> Prompt:
    """The first prompt of a dialogue. `reply_format` says what the model is asked for: STEPS, or GOALS as JSON.

    Errors: E120 the request is empty, E121 it is too long, E122 map and library are too large for a prompt.
    """
    line = clean(request, MAX_REQUEST_CHARS + 1)
    if not line:
        raise LlmbtError(Diagnostic("E120", "the request is empty", help="say in a sentence what the robot should do"))
    if len(line) > MAX_REQUEST_CHARS:
        raise LlmbtError(
            Diagnostic(
                "E121",
                f"the request has more than {MAX_REQUEST_CHARS} characters",
                Span("request"),
                help="say it in a few sentences",
            )
        )
    if reply_format == GOALS:
        system = _render("system_json", conditions=_conditions(library))
    else:
        system = _render("system", actions=_actions(library))
    messages = (
        ("system", system),
        (
            "user",
            _render(
                "user",
                places=_places(semantic_map),
                objects=[_object(o) for o in semantic_map.objects],
                facts=[clean(f, MAX_FACT_CHARS) for f in facts_of(semantic_map)],
                viewer=quoted(semantic_map.viewpoint.of),
                request=quoted(line, MAX_REQUEST_CHARS),
            ),
        ),
    )
    size = sum(len(content) for _, content in messages)
    if size > MAX_PROMPT_CHARS:
        raise LlmbtError(
            Diagnostic(
                "E122",
                f"the prompt would have {size} characters, more than {MAX_PROMPT_CHARS}",
                Span(semantic_map.source),
                help="leave objects and places out of the map that the request is not about",
            )
        )
    return Prompt(messages, template_version())


def continue_prompt(prompt: Prompt, reply: str, answer: str, *, question: str = "") -> Prompt:
    """The dialogue after a question: what the model said, and what the user answers; `question` is what was asked where
    it was not the model that asked. E120, E121 as above."""
    line = clean(answer, MAX_REQUEST_CHARS + 1)
    if not line or len(line) > MAX_REQUEST_CHARS:
        raise LlmbtError(
            Diagnostic("E121" if line else "E120", f"the answer is {'too long' if line else 'empty'}", Span("answer"))
        )
    asked = quoted(question, MAX_QUESTION_CHARS) if question else ""
    said = _render("answer", answer=quoted(line, MAX_REQUEST_CHARS), question=asked)
    return Prompt((*prompt.messages, ("assistant", _speakable(reply)), ("user", said)), prompt.template_version)


def correct_prompt(prompt: Prompt, reply: str, complaints: Sequence[str]) -> Prompt:
    """The dialogue after a reply that failed the check: what was wrong, one complaint a line."""
    said = _render("correction", complaints=[clean(c, 300) for c in complaints[:20]])
    return Prompt((*prompt.messages, ("assistant", _speakable(reply)), ("user", said)), prompt.template_version)


def request_of(messages: Messages) -> str:
    """The request that a prompt's first user message ends with, as it stands in its quotes; else that
    message."""
    content = next((c for role, c in messages if role == "user"), "")
    tail = content.rpartition("\nRequest: ")[2]
    try:
        request = json.loads(tail)
    except ValueError:
        return content
    return request if isinstance(request, str) else content


def template_version() -> str:
    """As `1.3fa9c2d1`: the number, and the first eight hex digits of the template file's sha256."""
    return f"{TEMPLATE_NUMBER}.{hashlib.sha256(_source().encode()).hexdigest()[:8]}"


def _speakable(text: str) -> str:
    return text.encode("utf-8", "replace").decode("utf-8").replace("\x00", "")


def _actions(library: Library) -> list[str]:
    """The words of every template that a step may name, with the parameters as capitals."""
    found = []
    for t in library.templates.values():
        if t.verbs and t.words:
            words = t.words
            for p in t.params:
                words = words.replace("{" + p.name + "}", p.name.upper())
            found.append(clean(words, 200))
    return found


def _conditions(library: Library) -> list[str]:
    """The conditions that may be goals, with their parameters and what they say."""
    found = []
    for c in library.conditions.values():
        if c.goal:
            params = ", ".join(p.name for p in c.params)
            words = c.words
            for p in c.params:
                words = words.replace("{" + p.name + "}", p.name)
            found.append(clean(f"{c.name}({params}): {words}" if c.params else f"{c.name}: {words}", 200))
    return found


def _label(id_: str, name: str) -> str:
    plain = id_.replace("_", " ")
    return clean(id_) if clean(name).lower() in ("", plain.lower()) else f"{clean(id_)} {quoted(name)}"


def _object(o: MapObject) -> str:
    traits = [_label(o.id, o.name)]
    traits += [f"colour {quoted(o.colour)}"] if o.colour.strip() else []
    traits += [f"shape {quoted(o.shape)}"] if o.shape.strip() else []
    traits.append(f"on {clean(o.place)}" if o.place is not None else "on no place")
    return ", ".join(traits)


def _places(semantic_map: SemanticMap) -> list[dict[str, Any]]:
    """Places in the order of the file, each under the one that contains it, with what stands right on it."""
    children: dict[str | None, list[MapPlace]] = {}
    known = {p.id for p in semantic_map.places}
    for p in semantic_map.places:
        children.setdefault(p.parent if p.parent in known else None, []).append(p)
    standing: dict[str, list[str]] = {}
    for o in semantic_map.objects:
        if o.place is not None:
            standing.setdefault(o.place, []).append(clean(o.id))
    rows: list[dict[str, Any]] = []
    stack = [(p, 0) for p in reversed(children.get(None, []))]
    while stack:
        place, depth = stack.pop()
        inner = children.get(place.id, [])
        here = standing.get(place.id, [])
        holds = f": {', '.join(here)}" if here else ("" if inner or place.buffer else ": empty")
        note = " (things may be put aside here)" if place.buffer else ""
        rows.append({"depth": min(depth, MAX_DEPTH), "label": _label(place.id, place.name) + note, "holds": holds})
        stack += [(p, depth + 1) for p in reversed(inner)]
    return rows


@cache
def _source() -> str:
    return (importlib.resources.files(__package__) / "prompt.jinja2").read_text(encoding="utf-8")


@cache
def _template() -> Template:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(undefined=StrictUndefined, autoescape=False, trim_blocks=True, lstrip_blocks=True)
    return environment.from_string(_source())


def _render(block: str, **values: Any) -> str:
    template = _template()
    return "".join(template.blocks[block](template.new_context(values))).strip()
