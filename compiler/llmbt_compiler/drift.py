"""What recorded replies come to, and whether that has changed since: by prompt, parser, scene or model.

Identical: the same prompts and the same goals. Harmless: other prompts or other words, the same goals.
Meaning-changing: other goals, or another refusal.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import zip_longest

from llmbt_atl.library import Library
from llmbt_compiler.asking import Asked
from llmbt_compiler.pipeline import FRONT_ENDS, Context, compile_request
from llmbt_compiler.reasoning.cassette import Cassette
from llmbt_compiler.reasoning.chat import Script, parse_completion
from llmbt_compiler.reasoning.prompt import STEPS, Messages
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["Drift", "Played", "Verdict", "answers_of", "compare", "play", "replies_of", "verify"]

SceneOf = Callable[[str], tuple[SemanticMap, Library]]
_ANSWER = re.compile(r'^Answer: (?P<answer>".*")$', re.MULTILINE)


class Drift(StrEnum):
    """How much has changed."""

    IDENTICAL = "identical"
    HARMLESS = "harmless"
    MEANING = "meaning-changing"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Played:
    """A dialogue gone through: its outcome (the goals in alphabetical order, or the exit code with the diagnostic's),
    the prompts that were asked, and the answers to which there was no question."""

    outcome: str
    prompts: tuple[Messages, ...] = ()
    unused: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Verdict:
    """A recording held against today. `stale`: today's prompt is another one, so that it is not found any more;
    `turn` is the first turn of which that is so. `fault`: why it could not be held against anything."""

    drift: Drift
    stale: bool
    before: str = ""
    now: str = ""
    turn: int = 0
    fault: str = ""

    @property
    def good(self) -> bool:
        """Found by today's prompts, with the meaning that it had."""
        return not (self.stale or self.fault or self.drift is Drift.MEANING)


def play(
    request: str,
    semantic_map: SemanticMap,
    library: Library,
    replies: Sequence[str],
    answers: Sequence[str] = (),
    *,
    reply_format: str = STEPS,
) -> Played:
    """What replies come to today, with the user's answers between them: of the replies beyond the first and one for
    each answer, each is a correction."""
    left = list(answers)
    heard: list[Messages] = []

    def consult(_: Asked) -> str | None:
        return left.pop(0) if left else None

    context = Context(
        request,
        semantic_map,
        library,
        Script(tuple(replies), heard=heard.append),
        corrections=max(0, len(replies) - 1 - len(answers)),
        front_end=FRONT_ENDS[reply_format],
    )
    try:
        compiled = compile_request(context, consult=consult)
    except LlmbtError as fault:
        return Played(f"exit {int(fault.exit_code)}: {fault.diagnostics[0].code}", tuple(heard), tuple(left))
    return Played("; ".join(sorted(str(g.condition) for g in compiled.goals)), tuple(heard), tuple(left))


def compare(before: str, now: str, *, same_words: bool) -> Drift:
    """How far two outcomes are apart; `same_words`: nothing else has changed either."""
    if not before:
        return Drift.UNKNOWN
    if before != now:
        return Drift.MEANING
    return Drift.IDENTICAL if same_words else Drift.HARMLESS


def verify(cassette: Cassette, scene_of: SceneOf) -> Verdict:
    """Hold a recording against today's prompts, parser and scene."""
    source = cassette.provenance
    try:
        semantic_map, library = scene_of(source.scene)
        replies = replies_of(cassette)
        played = play(
            source.request,
            semantic_map,
            library,
            replies,
            answers_of(cassette),
            reply_format=source.reply_format or STEPS,
        )
    except LlmbtError as fault:
        first = fault.diagnostics[0]
        return Verdict(Drift.UNKNOWN, True, source.outcome, fault=f"{first.code}: {first.title}")
    turn = next((n for n, (t, p) in enumerate(_paired(cassette, played), 1) if t != p), 0)
    drift = compare(source.outcome, played.outcome, same_words=turn == 0)
    return Verdict(drift, turn > 0, source.outcome, played.outcome, turn)


def _paired(cassette: Cassette, played: Played) -> Iterator[tuple[Messages, Messages]]:
    """What was asked then, and what is asked today, turn by turn."""
    return zip_longest((t.messages for t in cassette.turns), played.prompts, fillvalue=())


def replies_of(cassette: Cassette) -> tuple[str, ...]:
    """What the model said, turn by turn. E102-E105, E109 where a turn holds no reply."""
    return tuple(
        parse_completion(str(t.response["body"]["string"]).encode(), str(cassette.path)).text for t in cassette.turns
    )


def answers_of(cassette: Cassette) -> tuple[str, ...]:
    """The user's answers between the turns."""
    said = (t.messages[-1][1] for t in cassette.turns[1:] if t.messages)
    return tuple(str(json.loads(found["answer"])) for text in said if (found := _ANSWER.search(text)) is not None)
