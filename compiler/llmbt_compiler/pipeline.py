"""The stages of the compiler as one table: name, artifact, a pure `run`, and how its artifact is written and read.

`compile_request` runs them in order. What a stage gives is written before the next one starts, so that what is whole
stays after an error; callbacks between the stages observe and change nothing.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from llmbt_atl.library import Library
from llmbt_compiler.keywords.labels import KeywordSpan, Kind, Reading
from llmbt_compiler.parsing import Extent, Goal, LabelledStep, Note, NoteKind, ParseResult, parse, say
from llmbt_compiler.reasoning.chat import Completion, Reply, Settings, Transport
from llmbt_compiler.reasoning.dialogue import converse
from llmbt_compiler.reasoning.filter import filter_steps
from llmbt_compiler.reasoning.prompt import Prompt, build_prompt
from llmbt_compiler.reasoning.steps import Question, Steps
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Severity, Span
from llmbt_ir.semantic_map import SemanticMap, parse_map, write_map
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import GoalRecord, Provenance, write_tree

__all__ = ["STAGES", "Compiled", "Context", "Stage", "compile_request", "stage_names"]

DEFAULT_THRESHOLD = 0.5
"""Below it the tagger's word is not taken (docs/keywords.md has how it was chosen)."""


@dataclass(frozen=True, slots=True)
class Context:
    """What the stages need besides what flows through them."""

    request: str
    semantic_map: SemanticMap
    library: Library
    transport: Transport
    settings: Settings = field(default_factory=Settings)
    answers: tuple[str, ...] = ()
    tagger: str = "default"
    threshold: float = DEFAULT_THRESHOLD
    partial: bool = False


@dataclass(frozen=True, slots=True)
class Stage:
    """One stage: what it makes of the stage before it, and its artifact."""

    name: str
    artifact: str
    run: Callable[[Any, Context], Any]
    write: Callable[[Any, Context], bytes]
    read: Callable[[bytes, str], Any]
    tell: Callable[[Any], str]


@dataclass(frozen=True, slots=True)
class Compiled:
    """What a compilation came to: every stage's value, by name, as far as it went."""

    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def goals(self) -> tuple[Goal, ...]:
        """The goals, where the parser was reached."""
        found = self.values.get("parse")
        return found.goals if isinstance(found, ParseResult) else ()

    @property
    def notes(self) -> tuple[Note, ...]:
        """What the user should be told."""
        found = self.values.get("parse")
        return found.notes if isinstance(found, ParseResult) else ()

    @property
    def reply(self) -> Reply | None:
        """The reply, where it was asked for in this compilation."""
        found = self.values.get("reason")
        return found if isinstance(found, Reply) else None


def compile_request(
    context: Context,
    *,
    stop_after: str | None = None,
    start_from: str | None = None,
    stored: Callable[[str], bytes] | None = None,
    keep: Callable[[str, bytes], None] = lambda _name, _data: None,
    observe: Callable[[Stage, Any], None] = lambda _stage, _value: None,
) -> Compiled:
    """Run the stages up to and including `stop_after`.

    With `start_from`, what the stage before it had made is read through `stored` (artifact name -> bytes). `keep`
    gets each artifact once it is whole; the tree is not kept here, since the caller may still prove it impossible.
    LlmbtError where a stage finds the input wrong.
    """
    names = stage_names()
    first = names.index(start_from) if start_from else 0
    last = names.index(stop_after) if stop_after else len(names) - 1
    values: dict[str, Any] = {}
    value: Any = None
    if first > 0 and stored is not None:
        before = STAGES[first - 1]
        value = values[before.name] = before.read(stored(before.artifact), before.artifact)
    for stage in STAGES[first : last + 1]:
        value = values[stage.name] = stage.run(value, context)
        if not isinstance(value, ParseResult) or value.ok:
            observe(stage, value)
            if stage.name != "build":
                keep(stage.artifact, stage.write(value, context))
        _refuse(stage, value)
    return Compiled(values)


def stage_names() -> tuple[str, ...]:
    """The stages, in order."""
    return tuple(s.name for s in STAGES)


def _refuse(stage: Stage, value: Any) -> None:
    """Stop where a stage's value is no basis for the next one."""
    if stage.name == "filter" and isinstance(value, Question):
        raise LlmbtError(
            Diagnostic(
                "E140",
                f"the request is unclear: {value.text}",
                Span("reply.json", value.line),
                help="answer with --answer TEXT",
            ),
            exit_code=ExitCode.UNCLEAR,
        )
    if stage.name == "parse" and isinstance(value, ParseResult) and not value.ok:
        raise LlmbtError(*value.errors(), exit_code=value.exit_code)


# -- the stages ----------------------------------------------------------------------------------------------------


def _reason(prompt: Prompt, context: Context) -> Reply:
    """The reply to the prompt; where it asks back, the user's answers continue the dialogue."""
    return converse(prompt, context.answers, context.settings, context.transport).reply


def _keywords(steps: Steps, context: Context) -> tuple[LabelledStep, ...]:
    from llmbt_compiler.keywords.tagger import UnknownTaggerError, load_tagger
    from llmbt_compiler.keywords.weights import WeightsError

    try:
        tagger = load_tagger(context.tagger)
    except UnknownTaggerError as fault:
        raise LlmbtError(Diagnostic("E201", str(fault)), exit_code=ExitCode.USAGE) from None
    except WeightsError as fault:
        raise LlmbtError(Diagnostic("E204", str(fault))) from None
    tagged = tagger.tag([s.text for s in steps.steps])
    return tuple(
        LabelledStep.of(s.number, t, Extent(s.start, s.end), s.runs) for s, t in zip(steps.steps, tagged, strict=True)
    )


def _parse(steps: tuple[LabelledStep, ...], context: Context) -> ParseResult:
    return parse(steps, context.semantic_map, context.library, threshold=context.threshold, partial=context.partial)


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
    from pathlib import Path

    from llmbt_compiler.reasoning.cassette import Provenance as Source

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
                    "probability": s.readings[0].probability if s.readings else 1.0,
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


def _write_conditions(parsed: ParseResult, context: Context) -> bytes:
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
    from llmbt_ir.condition import Condition

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


STAGES: tuple[Stage, ...] = (
    Stage(
        "map",
        "map.xml",
        lambda _, c: c.semantic_map,
        lambda m, _: write_map(m),
        parse_map,
        lambda m: f"{len(m.objects)} objects, {len(m.places)} places",
    ),
    Stage(
        "prompt",
        "prompt.json",
        lambda m, c: build_prompt(c.request, m, c.library),
        lambda p, _: _json(p.as_json()),
        lambda data, source: _loaded(data, source, Prompt.from_json),
        lambda p: f"template {p.template_version}",
    ),
    Stage(
        "reason",
        "reply.json",
        _reason,
        lambda r, _: _json(r.as_json()),
        lambda data, source: _loaded(data, source, _read_reply),
        lambda r: r.provenance.words(),
    ),
    Stage(
        "filter",
        "steps.json",
        lambda r, _: filter_steps(r.text),
        lambda s, _: _json(s.as_json()),
        lambda data, source: _loaded(data, source, Steps.from_json),
        _steps_told,
    ),
    Stage(
        "keywords",
        "keywords.json",
        _keywords,
        _write_keywords,
        lambda data, source: _loaded(data, source, _read_keywords),
        lambda s: ", ".join(sorted({k.text.lower() for step in s for k in step.spans if k.label is Kind.ACTION})),
    ),
    Stage(
        "parse",
        "conditions.json",
        _parse,
        _write_conditions,
        lambda data, source: _loaded(data, source, _read_conditions),
        lambda p: ", ".join(str(g.condition) for g in p.goals),
    ),
    Stage(
        "build",
        "tree.v000.xml",
        _build,
        lambda data, _: bytes(data),
        lambda data, _: data,
        lambda _: "tree.v000.xml",
    ),
)
"""Every stage, in order (docs/architecture.md)."""
