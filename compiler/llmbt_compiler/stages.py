"""The stages of the compiler as tables: name, artifact, a pure `run`, and how its artifact is written and read.

A front end is the part of the table between the model's reply and the goals. There are two, and the pipeline knows
neither: FRONT_ENDS["steps"] reads steps in words (text filter, keyword tagger, parser), FRONT_ENDS["json"] goals as
JSON. Another one, or one with another stage in it, is another value (docs/architecture.md).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from llmbt_atl.library import Library
from llmbt_compiler.goals import ground, read_reply, read_stated
from llmbt_compiler.keywords.labels import KeywordSpan, Kind, Reading
from llmbt_compiler.parsing import Extent, Goal, LabelledStep, Note, NoteKind, ParseResult, parse, say
from llmbt_compiler.reasoning.cassette import Provenance as Source
from llmbt_compiler.reasoning.chat import Completion, Reply, Settings, Transport, ask
from llmbt_compiler.reasoning.filter import filter_steps
from llmbt_compiler.reasoning.prompt import GOALS, STEPS, Prompt, build_prompt
from llmbt_compiler.reasoning.steps import Question, Steps
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Severity, Span
from llmbt_ir.semantic_map import SemanticMap, parse_map, write_map
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import GoalRecord, Provenance, write_tree

__all__ = ["FRONT_ENDS", "STAGES", "Context", "FrontEnd", "Stage", "stages_of", "tagged"]

DEFAULT_THRESHOLD = 0.5
"""Below it the tagger's word is not taken (docs/keywords.md has how it was chosen)."""


@dataclass(frozen=True, slots=True)
class Stage:
    """One stage: what it makes of the stage before it, and its artifact. `tell` says it in a line."""

    name: str
    artifact: str
    run: Callable[[Any, Context], Any]
    write: Callable[[Any, Context], bytes]
    read: Callable[[bytes, str], Any]
    tell: Callable[[Any], str]


@dataclass(frozen=True, slots=True)
class FrontEnd:
    """From a reply to goals: the first stage takes a `Reply`, the last gives a `ParseResult`; any of them may give a
    `Question` instead. `reply_format` is what the prompt asks the model for."""

    reply_format: str
    stages: tuple[Stage, ...]


@dataclass(frozen=True, slots=True)
class Context:
    """What the stages need besides what flows through them. `stated` are goals that a person gives in place of the
    model's, with the name of their source; `corrections` bounds how often a faulty reply goes back to the model."""

    request: str
    semantic_map: SemanticMap
    library: Library
    transport: Transport
    settings: Settings = field(default_factory=Settings)
    tagger: str = "default"
    threshold: float = DEFAULT_THRESHOLD
    partial: bool = False
    corrections: int = 2
    front_end: FrontEnd = field(default_factory=lambda: FRONT_ENDS[STEPS])
    stated: tuple[str, str] | None = None

    def where(self, goal: Goal) -> Span:
        """Where a goal is written: in which step, or in which line of the goals that a person states."""
        if self.stated is None:
            return Span("steps.json", goal.step_number, goal.span.start + 1, goal.span.end + 1)
        text, source = self.stated
        return Span(source, text.count("\n", 0, goal.span.start) + 1)


def stages_of(context: Context) -> tuple[Stage, ...]:
    """The stages of a compilation, in order."""
    if context.stated is not None:
        return (MAP, STATED, BUILD)
    return (MAP, PROMPT, REASON, *context.front_end.stages, BUILD)


def tagged(texts: Sequence[str], tagger: str) -> tuple[LabelledStep, ...]:
    """Texts with their keywords, numbered from 1. LlmbtError (E201, E204) where there is no such tagger."""
    from llmbt_compiler.keywords.tagger import UnknownTaggerError, load_tagger
    from llmbt_compiler.keywords.weights import WeightsError

    try:
        loaded = load_tagger(tagger)
    except UnknownTaggerError as fault:
        raise LlmbtError(Diagnostic("E201", str(fault)), exit_code=ExitCode.USAGE) from None
    except WeightsError as fault:
        raise LlmbtError(Diagnostic("E204", str(fault))) from None
    found = loaded.tag(list(texts))
    return tuple(LabelledStep.of(i, t) for i, t in enumerate(found, 1))


# -- the stages ----------------------------------------------------------------------------------------------------


def _keywords(steps: Steps, context: Context) -> tuple[LabelledStep, ...]:
    found = tagged([s.text for s in steps.steps], context.tagger)
    return tuple(
        replace(t, number=s.number, reply=Extent(s.start, s.end), runs=s.runs)
        for s, t in zip(steps.steps, found, strict=True)
    )


def _parse(steps: tuple[LabelledStep, ...], context: Context) -> ParseResult:
    return parse(steps, context.semantic_map, context.library, threshold=context.threshold, partial=context.partial)


def _goals_of_reply(reply: Reply, context: Context) -> ParseResult | Question:
    found = read_reply(reply.text)
    return found if isinstance(found, Question) else ground(found, context.semantic_map, context.library)


def _stated(_: SemanticMap, context: Context) -> ParseResult:
    assert context.stated is not None
    return ground(read_stated(*context.stated), context.semantic_map, context.library)


def _build(parsed: ParseResult, context: Context) -> bytes:
    tree = goal_tree((tuple(g.condition for g in parsed.goals),))
    signatures = Signatures(
        {c.name: tuple(p.name for p in c.params) for c in context.library.conditions.values()},
        {t.name: tuple(p.name for p in t.params) for t in context.library.templates.values()},
    )
    by_condition = {g.condition: g for g in reversed(parsed.goals)}
    told = tuple(
        GoalRecord(node.id, node.condition, f"step {g.step_number}: {g.words}")
        for node in tree.preorder()
        if node.condition is not None
        for g in (by_condition[node.condition],)
    )
    return write_tree(tree, signatures, Provenance("v000", "", told))


# -- their artifacts -----------------------------------------------------------------------------------------------


def _json(value: Any) -> bytes:
    return (json.dumps(value, indent=1, ensure_ascii=False) + "\n").encode()


def _loaded(data: bytes, source: str, read: Callable[[Any], Any]) -> Any:
    try:
        return read(json.loads(data))
    except (ValueError, KeyError, TypeError, AttributeError) as fault:
        raise LlmbtError(
            Diagnostic(
                "E011",
                f"`{source}` is not what the stage before writes: {fault}",
                Span(source),
                help="run the stages before it again",
            )
        ) from None


def _read_reply(data: Mapping[str, Any]) -> Reply:
    """An edited reply is read for its words; where it came from stays what the file says."""
    names = set(Source.__dataclass_fields__)
    source = Source(**{k: v for k, v in data.items() if k in names})
    text = str(data["text"])
    return Reply(
        text,
        source,
        Path(str(data.get("cassette", ""))),
        str(data.get("prompt_sha256", "")),
        Completion(text),
    )


def _write_keywords(steps: tuple[LabelledStep, ...], _: Context) -> bytes:
    return _json(
        {
            "schema_version": 1,
            "steps": [
                {
                    "number": s.number,
                    "text": s.text,
                    "confidence": round(s.certainty, 4),
                    "reply": [s.reply.start, s.reply.end] if s.reply else None,
                    "spans": [
                        {
                            "start": k.start,
                            "end": k.end,
                            "label": k.label.value,
                            "text": k.text,
                            "confidence": round(k.confidence, 4),
                        }
                        for k in s.spans
                    ],
                    "probability": s.readings[0].probability if s.readings else 1.0,
                    "readings": [
                        {"probability": r.probability, "spans": [[k.start, k.end, k.label.value] for k in r.spans]}
                        for r in s.readings[1:]
                    ],
                }
                for s in steps
            ],
        }
    )


def _read_keywords(data: Mapping[str, Any]) -> tuple[LabelledStep, ...]:
    return tuple(
        LabelledStep(
            int(s["number"]),
            str(s["text"]),
            tuple(
                KeywordSpan(int(k["start"]), int(k["end"]), Kind(k["label"]), str(k["text"]), float(k["confidence"]))
                for k in s["spans"]
            ),
            float(s["confidence"]),
            Extent(*s["reply"]) if s.get("reply") else None,
            readings=_read_readings(s),
        )
        for s in data["steps"]
    )


def _read_readings(step: Mapping[str, Any]) -> tuple[Reading, ...]:
    """The likeliest ways to label a step, the one that its `spans` are first; none where the file has no others."""
    others = [(float(r["probability"]), r["spans"]) for r in step.get("readings", ())]
    if not others:
        return ()
    text = str(step["text"])
    first = [(int(k["start"]), int(k["end"]), str(k["label"])) for k in step["spans"]]
    told = [(float(step["probability"]), first), *others]
    return tuple(
        Reading(tuple(KeywordSpan(int(a), int(b), Kind(label), text[int(a) : int(b)]) for a, b, label in spans), p)
        for p, spans in told
    )


def _write_conditions(parsed: ParseResult | Question, context: Context) -> bytes:
    if isinstance(parsed, Question):
        return _json(parsed.as_json())
    return _json(
        {
            "schema_version": 1,
            "goals": [
                {
                    "name": g.condition.name,
                    "args": list(g.condition.args),
                    "negated": g.condition.negated,
                    "says": say(g.condition, context.library),
                    "step": g.step_number,
                    "words": g.words,
                    "span": [g.span.start, g.span.end],
                    "reply": [g.reply.start, g.reply.end] if g.reply else None,
                }
                for g in parsed.goals
            ],
            "notes": [{"step": n.step_number, "kind": n.kind.value, "text": n.text} for n in parsed.notes],
            "left_out": [d.title for d in parsed.diagnostics if d.severity is Severity.ERROR],
        }
    )


def _read_conditions(data: Mapping[str, Any]) -> ParseResult:
    return ParseResult(
        tuple(
            Goal(
                Condition(str(g["name"]), tuple(map(str, g["args"])), bool(g.get("negated"))),
                int(g.get("step", 0)),
                str(g.get("words", "")),
                Extent(*g.get("span", (0, 0))),
                Extent(*g["reply"]) if g.get("reply") else None,
            )
            for g in data["goals"]
        ),
        tuple(Note(int(n["step"]), NoteKind(n["kind"]), str(n["text"])) for n in data.get("notes", ())),
    )


def _steps_told(value: Steps | Question) -> str:
    if isinstance(value, Question):
        return f"the model asks: {value.text}"
    return f"{len(value.steps)} steps"


def _goals_told(value: ParseResult | Question) -> str:
    if isinstance(value, Question):
        return f"the model asks: {value.text}"
    return ", ".join(str(g.condition) for g in value.goals)


MAP = Stage(
    "map",
    "map.xml",
    lambda _, c: c.semantic_map,
    lambda m, _: write_map(m),
    parse_map,
    lambda m: f"{len(m.objects)} objects, {len(m.places)} places",
)
PROMPT = Stage(
    "prompt",
    "prompt.json",
    lambda m, c: build_prompt(c.request, m, c.library, reply_format=c.front_end.reply_format),
    lambda p, _: _json(p.as_json()),
    lambda data, source: _loaded(data, source, Prompt.from_json),
    lambda p: f"template {p.template_version}",
)
REASON = Stage(
    "reason",
    "reply.json",
    lambda p, c: ask(p.messages, c.settings, c.transport),
    lambda r, _: _json(r.as_json()),
    lambda data, source: _loaded(data, source, _read_reply),
    lambda r: r.provenance.words(),
)
FILTER = Stage(
    "filter",
    "steps.json",
    lambda r, _: filter_steps(r.text),
    lambda s, _: _json(s.as_json()),
    lambda data, source: _loaded(data, source, Steps.from_json),
    _steps_told,
)
KEYWORDS = Stage(
    "keywords",
    "keywords.json",
    _keywords,
    _write_keywords,
    lambda data, source: _loaded(data, source, _read_keywords),
    lambda s: ", ".join(sorted({k.text.lower() for step in s for k in step.spans if k.label is Kind.ACTION})),
)
PARSE = Stage(
    "parse",
    "conditions.json",
    _parse,
    _write_conditions,
    lambda data, source: _loaded(data, source, _read_conditions),
    _goals_told,
)
BUILD = Stage(
    "build",
    "tree.v000.xml",
    _build,
    lambda data, _: bytes(data),
    lambda data, _: data,
    lambda _: "tree.v000.xml",
)
GOALS_OF_REPLY = Stage("parse", "conditions.json", _goals_of_reply, _write_conditions, PARSE.read, PARSE.tell)
STATED = Stage("parse", "conditions.json", _stated, _write_conditions, PARSE.read, PARSE.tell)

FRONT_ENDS: Mapping[str, FrontEnd] = MappingProxyType(
    {STEPS: FrontEnd(STEPS, (FILTER, KEYWORDS, PARSE)), GOALS: FrontEnd(GOALS, (GOALS_OF_REPLY,))}
)
"""From the reply to the goals, by what the model is asked for."""

STAGES: tuple[Stage, ...] = (MAP, PROMPT, REASON, *FRONT_ENDS[STEPS].stages, BUILD)
"""Every stage of the usual way, in order (docs/architecture.md)."""
