"""From a request to a tree: the stages in order, the dialogue with the model and the user around them.

What a stage gives is written before the next one starts, so that what is whole stays after an error; callbacks between
the stages observe and change nothing. A reply that fails a check goes back to the model with the complaints, as often
as the context allows and an endpoint or a recording answers; what is then still open is asked of the user, or told.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from typing import Any

from llmbt_atl.state import domain_of
from llmbt_compiler.asking import Asked, Slot, edit_for, edited, from_diagnostics, from_model, from_request, restated
from llmbt_compiler.asking.answer import choose
from llmbt_compiler.checking import (
    contradictions,
    lacking,
    moved_all_the_same,
    obstacles,
    open_points,
    too_many,
    unable,
    ungrounded,
    unknown_names,
    witnessed,
)
from llmbt_compiler.parsing import Goal, LabelledStep, Note, ParseResult, parse
from llmbt_compiler.reasoning.chat import Reply, answerable
from llmbt_compiler.reasoning.dialogue import Dialogue
from llmbt_compiler.reasoning.prompt import Prompt, continue_prompt, correct_prompt
from llmbt_compiler.reasoning.steps import Question, Steps
from llmbt_compiler.stages import FRONT_ENDS, STAGES, Context, FrontEnd, Stage, stages_of, tagged
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Severity

__all__ = [
    "FRONT_ENDS",
    "STAGES",
    "Compiled",
    "Context",
    "FrontEnd",
    "Stage",
    "compile_request",
    "stage_names",
]

DIALOGUE = "dialogue.json"
_SENTENCES = re.compile(r"[^.;!?]+[.;!?]*")
_LONGEST = 2000
_HOLDING = re.compile(r"\b(?:hold|holding|pick|lift|grasp|grip|hand)\b", re.IGNORECASE)
"""Words of a request that wants a thing in the hand, and brought nowhere."""
_OF_THE_REPLY = ("E103", "E104", "E105", "E106", "E107", "E108", "E109", "E101", "E102", "E130", "E133")
"""Faults of the asking itself: nothing was said that could be corrected."""


@dataclass(frozen=True, slots=True)
class Compiled:
    """What a compilation came to: every stage's value, by name, as far as it went, and all that was said."""

    values: Mapping[str, Any] = field(default_factory=dict)
    dialogue: Dialogue = field(default_factory=Dialogue)

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
        """The last reply, where it was asked for in this compilation."""
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
    check: Callable[[Compiled], None] = lambda _compiled: None,
    consult: Callable[[Asked], str | None] = lambda _asked: None,
) -> Compiled:
    """Run the stages up to and including `stop_after`.

    With `start_from`, what the stage before it had made is read through `stored` (artifact name -> bytes). `keep` gets
    each artifact once it is whole; the tree is not kept here, since the caller may still refuse it. `check` is the
    caller's own check of what was built, an LlmbtError where it fails; `consult` gives the user's answer to a question,
    or None. LlmbtError where a stage finds the input wrong, or a question stays open (exit code 5).
    """
    run = _Run(context, stop_after, keep, observe, check, consult)
    return run.go(start_from, stored)


def stage_names(context: Context | None = None) -> tuple[str, ...]:
    """The stages, in order."""
    return tuple(s.name for s in (STAGES if context is None else stages_of(context)))


class _Unsettled(Exception):  # noqa: N818 - no error: the model is to read the answer
    def __init__(self, asked: Asked, answer: str) -> None:
        super().__init__(asked.text)
        self.asked, self.answer = asked, answer


class _ModelAsks(Exception):  # noqa: N818 - no error: the user is to be asked
    def __init__(self, question: Question) -> None:
        super().__init__(question.text)
        self.question = question


class _Run:
    """One compilation: the values of its stages, and what has been said."""

    def __init__(
        self,
        context: Context,
        stop_after: str | None,
        keep: Callable[[str, bytes], None],
        observe: Callable[[Stage, Any], None],
        check: Callable[[Compiled], None],
        consult: Callable[[Asked], str | None],
    ) -> None:
        self.context = context
        self.keep, self.observe, self.check, self.consult = keep, observe, check, consult
        self.table = stages_of(context)
        names = [s.name for s in self.table]
        self.last = names.index(stop_after) if stop_after in names else len(names) - 1
        self.values: dict[str, Any] = {}
        self.said = Dialogue().request(context.request)
        self.settled = False
        self.stuck: tuple[Any, int] = (None, 0)

    def go(self, start_from: str | None, stored: Callable[[str], bytes] | None) -> Compiled:
        names = [s.name for s in self.table]
        first = names.index(start_from) if start_from in names else 0
        value: Any = None
        if first > 0 and stored is not None:
            before = self.table[first - 1]
            value = self.values[before.name] = before.read(stored(before.artifact), before.artifact)
        for i, stage in enumerate(self.table[: self.last + 1]):
            if i < first:
                continue
            if stage.name == "reason":
                try:
                    self.converse(value)
                finally:
                    self.keep(DIALOGUE, self.said.as_json())
                break
            value = self.made_alone(stage, value)
        else:
            self.finish()
        return Compiled(self.values, self.said)

    def made_alone(self, stage: Stage, value: Any) -> Any:
        """A stage outside of a dialogue: there is no model to read an answer, or to answer its question."""
        try:
            return self.make(stage, value, asking=True)
        except _Unsettled as open_:
            raise open_.asked.error() from None
        except _ModelAsks as asks:
            raise from_model(asks.question, self.context.semantic_map, self.context.library).error() from None

    # -- stages ----------------------------------------------------------------------------------------------------

    def make(self, stage: Stage, value: Any, *, asking: bool) -> Any:
        """Run a stage and keep what it made. A question of the model's is raised, and so is what forbids to go on."""
        made = stage.run(value, self.context)
        if isinstance(made, ParseResult):
            if made.ok:
                self.keep(stage.artifact, stage.write(made, self.context))
            made = self.checked(stage, value, made, asking=asking)
        self.values[stage.name] = made
        self.observe(stage, made)
        if stage.name != "build":
            self.keep(stage.artifact, stage.write(made, self.context))
        if isinstance(made, Question):
            raise _ModelAsks(made)
        return made

    def checked(self, stage: Stage, steps: Any, parsed: ParseResult, *, asking: bool) -> ParseResult:
        """Goals that are right as far as this side can tell. With `asking`, open questions go to the user; the answers
        change the steps, which are read anew."""
        context = self.context
        while True:
            asked: Asked | None = None
            if not parsed.ok:
                asked = from_diagnostics(parsed.diagnostics, context.semantic_map, context.library)
                if asked is None:
                    raise LlmbtError(*parsed.errors(), exit_code=parsed.exit_code)
                self.refuse_the_impossible()
                asked = self.what_the_map_lacks() or asked
            else:
                self.refuse_contradictions(parsed)
                self.refuse_inability()
                asked = self.open_point(parsed)
            if asked is None:
                return parsed
            answer = self.answer(asked) if asking else None
            if answer is None:
                first = asked.diagnostic
                rest = [d for d in parsed.errors() if (d.code, d.span) != (first.code, first.span)]
                raise LlmbtError(first, *rest, exit_code=ExitCode.UNCLEAR)
            if asked.slot is Slot.REQUEST:
                parsed = self.taken(asked, answer, parsed)
                continue
            steps = self.reworded(asked, answer, steps)
            parsed = stage.run(steps, context)
            restated = self.request_as_step(asked, answer) if not parsed.ok else None
            if restated is not None:
                steps = restated
                parsed = stage.run(steps, context)

    def refuse_contradictions(self, parsed: ParseResult) -> None:
        semantic_map = self.context.semantic_map
        steps = self.values.get("filter")
        texts = tuple((s.number, s.text) for s in steps.steps) if isinstance(steps, Steps) else ()
        domain = domain_of(self.context.library, semantic_map)
        found = contradictions(parsed, domain, semantic_map, self.context.where, texts)
        if self.context.stated is None:
            request, library = self.context.request, self.context.library
            kept = moved_all_the_same(request, parsed.goals, semantic_map, library)
            found = (*found, *kept, *too_many(request, parsed.goals, semantic_map, library))
        if found:
            raise LlmbtError(*found, exit_code=ExitCode.NO_SUCCESS)

    @property
    def of_a_reply(self) -> bool:
        """Whether what is checked is a reply, to which the user has not said anything yet."""
        return self.context.stated is None and not self.settled and "reason" in self.values

    def refuse_the_impossible(self) -> None:
        """A request that cannot be carried out is no matter for a question about the steps."""
        if not self.of_a_reply:
            return
        self.refuse_inability()
        semantic_map, library = self.context.semantic_map, self.context.library
        goals = self.own_reading.goals
        found = (
            *too_many(self.context.request, goals, semantic_map, library),
            *moved_all_the_same(self.context.request, goals, semantic_map, library),
        )
        if found:
            raise LlmbtError(*found, exit_code=ExitCode.NO_SUCCESS)

    def what_the_map_lacks(self) -> Asked | None:
        """What the request names and the map has not is asked about before what the steps leave open for that."""
        if not self.of_a_reply:
            return None
        point = lacking(self.context.request, self.context.semantic_map, self.context.library)
        return from_request(point, self.context.semantic_map, self.context.library) if point is not None else None

    def refuse_inability(self) -> None:
        """What the request asks for, and the robot cannot do: a reply that leaves it out does not fulfil it."""
        at = self.context
        found = tuple(unable(at.request, at.semantic_map, at.library)) if at.stated is None else ()
        if found:
            raise LlmbtError(*found, exit_code=ExitCode.BAD_INPUT)

    def open_point(self, parsed: ParseResult) -> Asked | None:
        """What the reply decided without asking: only of a reply, and only until the user has said something."""
        if not self.of_a_reply:
            return None
        context = self.context
        semantic_map, library = context.semantic_map, context.library
        steps = self.values.get("filter")
        said = "\n".join(s.text for s in steps.steps) if isinstance(steps, Steps) else ""
        for point in open_points(context.request, parsed, semantic_map, library, said):
            return from_request(point, semantic_map, library)
        sentences = self.sentences
        points = chain(
            witnessed(context.request, sentences, self.own_reading, parsed.goals, semantic_map, library),
            unknown_names(sentences, parsed.goals, semantic_map, library),
            ungrounded(context.request, parsed.goals, semantic_map, library),
        )
        return next((from_request(p, semantic_map, library) for p in points), None)

    @cached_property
    def own_reading(self) -> ParseResult:
        """What the request comes to by itself."""
        return parse(self.sentences, self.context.semantic_map, self.context.library)

    @cached_property
    def sentences(self) -> tuple[LabelledStep, ...]:
        """The request's sentences, labelled as if each were a step."""
        return tagged(_SENTENCES.findall(" ".join(self.context.request.split())[:_LONGEST]), self.context.tagger)

    def answer(self, asked: Asked) -> str | None:
        """The user's answer, entered into what was said; None where there is none."""
        self.said = self.said.question(asked.text, asked.candidates, by="check")
        answer = self.consult(asked)
        if answer is not None:
            self.said = self.said.answer(answer)
        return answer

    def taken(self, asked: Asked, answer: str, parsed: ParseResult) -> ParseResult:
        """The object that the user means in place of the one that the reply took."""
        ids = choose(answer, asked, self.context.semantic_map, self.context.library)
        if len(ids) != 1 or asked.taken is None or (ids[0] != asked.taken and self.hangs_on(asked.taken, parsed)):
            raise _Unsettled(asked, answer)
        swap = {asked.taken: ids[0], ids[0]: asked.taken}

        def meant(condition: Condition) -> Condition:
            return replace(condition, args=tuple(swap.get(a, a) for a in condition.args))

        self.settled = True
        self.said = self.said.settled(f"{asked.taken} is {ids[0]}")
        goals = tuple(replace(g, condition=meant(g.condition)) for g in parsed.goals)
        moves = tuple(replace(m, target=swap.get(m.target, m.target)) for m in parsed.moves)
        return replace(parsed, goals=goals, moves=moves)

    def hangs_on(self, taken: str, parsed: ParseResult) -> bool:
        """Whether other goals follow from where an object stands: something else comes to its place."""
        place = next((o.place for o in self.context.semantic_map.objects if o.id == taken), None)
        return any(place in g.condition.args and taken not in g.condition.args for g in parsed.goals)

    def reworded(self, asked: Asked, answer: str, steps: Any) -> Any:
        """The labelled steps with the answer in them."""
        if not (isinstance(steps, tuple) and all(isinstance(s, LabelledStep) for s in steps)):
            raise _Unsettled(asked, answer)
        edit = edit_for(asked, answer, steps, self.context.semantic_map, self.context.library)
        if edit is None:
            raise _Unsettled(asked, answer)
        changed = edited(steps, edit, lambda texts: tagged(texts, self.context.tagger))
        self.settled = True
        self.said = self.said.settled(next(b.text for a, b in zip(steps, changed, strict=True) if a is edit.step))
        return changed

    def finish(self) -> None:
        if self.table[self.last].name == "build":
            self.check(Compiled(self.values, self.said))

    # -- the dialogue ----------------------------------------------------------------------------------------------

    def converse(self, prompt: Prompt) -> None:
        """Ask, and read the reply; correct it and answer its questions as long as there is something to say."""
        corrections = self.context.corrections
        index = [s.name for s in self.table].index("reason")
        while True:
            reply = self.ask(self.table[index], prompt)
            try:
                self.understand(reply, index + 1)
            except _ModelAsks as asks:
                following = self.asked_by_the_model(prompt, reply, asks.question)
                if following is None:
                    return
                prompt = following
                continue
            except LlmbtError as fault:
                better = correct_prompt(prompt, reply.text, _complaints(fault)) if corrections else None
                if better is not None and self.can_ask(better) and _is_correctable(fault):
                    self.said = self.said.complaint(_complaints(fault))
                    prompt, corrections = better, corrections - 1
                    continue
                if fault.exit_code is not ExitCode.UNCLEAR:
                    raise
            else:
                return
            try:
                self.understand(*self.stuck, asking=True)
            except _Unsettled as open_:
                prompt = continue_prompt(prompt, reply.text, open_.answer, question=open_.asked.text)
                self.settled = True
                if not self.can_ask(prompt) and self.settled_here(open_.asked, open_.answer):
                    return
                continue
            return

    def ask(self, stage: Stage, prompt: Prompt) -> Reply:
        """The reply to a prompt, kept as the artifact."""
        reply: Reply = stage.run(prompt, self.context)
        self.values[stage.name] = reply
        self.said = self.said.reply(reply)
        self.observe(stage, reply)
        self.keep(stage.artifact, stage.write(reply, self.context))
        return reply

    def can_ask(self, prompt: Prompt) -> bool:
        """Whether somebody answers: an endpoint, or a recording."""
        return answerable(prompt.messages, self.context.settings, self.context.transport)

    def understand(self, value: Any, first: int, *, asking: bool = False) -> None:
        """The stages after a reply, as far as they are wanted, and the check of what they built."""
        for i, stage in enumerate(self.table[first : self.last + 1], first):
            self.stuck = (value, i)
            value = self.make(stage, value, asking=asking)
        if self.last < first:
            self.read_ahead(value)
        self.finish()

    def read_ahead(self, reply: Reply) -> None:
        """Where the reply is all that is wanted, it is still looked at for a question, which an answer continues."""
        try:
            found = self.table[self.last + 1].run(reply, self.context)
        except LlmbtError:
            return
        if isinstance(found, Question):
            raise _ModelAsks(found)

    def asked_by_the_model(self, prompt: Prompt, reply: Reply, question: Question) -> Prompt | None:
        """The prompt that goes on after the model's question; None where the answer settles it here.

        An answer that names one of the candidates needs no model where the request itself reads as the step.
        """
        context = self.context
        asked = self.told_what_lacks(from_model(question, context.semantic_map, context.library))
        self.said = self.said.question(question.text, asked.candidates, by="model")
        answer = self.consult(asked)
        if answer is None and self.table[self.last].name == "reason":
            return None
        if answer is None:
            raise asked.error()
        self.said = self.said.answer(answer)
        self.settled = True
        following = continue_prompt(prompt, reply.text, answer)
        if self.can_ask(following):
            return following
        return None if self.settled_here(asked, answer) else following

    def told_what_lacks(self, asked: Asked) -> Asked:
        """The model's question, with the reason why the request cannot be carried out as it stands, if there is one."""
        context = self.context
        found = obstacles(context.request, self.sentences, self.own_reading, context.semantic_map, context.library)
        obstacle = next(found, None)
        if obstacle is None:
            return asked
        told = replace(
            asked.diagnostic, title=f"{asked.diagnostic.title} (it cannot be done as it stands: {obstacle.title})"
        )
        return replace(asked, diagnostic=told)

    def settled_here(self, asked: Asked, answer: str) -> bool:
        """Go on with the request itself as the steps, the answer in it, where it comes to goals that way."""
        steps = self.request_as_step(asked, answer)
        if steps is None:
            return False
        self.values["filter"] = Steps(())
        self.values["keywords"] = steps
        names = [s.name for s in self.table]
        value: Any = steps
        for stage in self.table[names.index("parse") : self.last + 1]:
            value = self.make(stage, value, asking=True)
        self.finish()
        return True

    def request_as_step(self, asked: Asked, answer: str) -> tuple[LabelledStep, ...] | None:
        """The request read as the steps, with the answer in it; None where it does not come to goals that way."""
        context = self.context
        reached = [s.name for s in self.table[: self.last + 1]]
        if "keywords" not in reached or "parse" not in reached:
            return None
        semantic_map, library = context.semantic_map, context.library
        ids = choose(answer, asked, semantic_map, library)
        if not ids:
            return None
        stage = next(s for s in self.table if s.name == "parse")
        for steps in self.readings(asked, answer, ids):
            parsed = stage.run(steps, context)
            about = {a for g in parsed.goals for a in g.condition.args}
            brought = any(len(g.condition.args) > 1 for g in parsed.goals) or _HOLDING.search(context.request)
            if parsed.ok and brought and all(about & {i, *(p.id for p in semantic_map.inside(i))} for i in ids):
                self.said = self.said.settled(" ".join(s.text for s in steps))
                return steps
        return None

    def readings(self, asked: Asked, answer: str, ids: Sequence[str]) -> Iterator[tuple[LabelledStep, ...]]:
        """Ways to read the request once the answer is known: as one step with the parser's own question answered, or
        said again with what was chosen."""
        context = self.context
        semantic_map, library = context.semantic_map, context.library
        stage = next(s for s in self.table if s.name == "parse")
        steps = tagged([" ".join(context.request.split())], context.tagger)
        own = from_diagnostics(stage.run(steps, context).diagnostics, semantic_map, library)
        if own is not None and set(own.candidates) & set(asked.candidates):
            edit = edit_for(own, answer, steps, semantic_map, library)
            if edit is not None:
                yield edited(steps, edit, lambda texts: tagged(texts, context.tagger))
        for text in restated(context.request, asked, ids, semantic_map, library):
            yield tagged(_SENTENCES.findall(text), context.tagger)


def _is_correctable(fault: LlmbtError) -> bool:
    return not any(d.code in _OF_THE_REPLY for d in fault.diagnostics)


def _complaints(fault: LlmbtError) -> tuple[str, ...]:
    """What was wrong, for the model: the titles, with the suggestions."""
    errors: list[Diagnostic] = [d for d in fault.diagnostics if d.severity is Severity.ERROR]
    return tuple(f"{d.title}{f' ({d.label})' if d.label else ''}{f': {d.help}' if d.help else ''}" for d in errors)
