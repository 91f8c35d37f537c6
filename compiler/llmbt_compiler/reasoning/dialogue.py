"""All that was said until the goals were settled: request, replies, questions, answers, complaints, in their order."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from llmbt_compiler.reasoning.chat import Reply

__all__ = ["Dialogue", "Turn"]


@dataclass(frozen=True, slots=True)
class Turn:
    """One thing said: `by` the user, the model or the check; `kind` is request, reply, question, answer, complaint, or
    settled (how an answer was understood here, without the model)."""

    by: str
    kind: str
    text: str
    more: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Dialogue:
    """The turns so far. A value: each method gives the dialogue with one more turn."""

    turns: tuple[Turn, ...] = ()

    def _with(self, by: str, kind: str, text: str, **more: Any) -> Dialogue:
        return replace(self, turns=(*self.turns, Turn(by, kind, text, more)))

    def request(self, text: str) -> Dialogue:
        """What the user wants."""
        return self._with("user", "request", text)

    def reply(self, reply: Reply) -> Dialogue:
        """What the model said, and where that comes from."""
        source = {"provenance": reply.provenance.provenance, "cassette": reply.cassette.name, "sha256": reply.sha256}
        return self._with("model", "reply", reply.text, **source)

    def question(self, text: str, candidates: Sequence[str], *, by: str) -> Dialogue:
        """What was asked back."""
        return self._with(by, "question", text, candidates=list(candidates))

    def answer(self, text: str) -> Dialogue:
        """What the user answered."""
        return self._with("user", "answer", text)

    def settled(self, text: str) -> Dialogue:
        """How an answer was understood without the model: the step as it now reads."""
        return self._with("check", "settled", text)

    def complaint(self, complaints: Sequence[str]) -> Dialogue:
        """What was wrong with a reply."""
        return self._with("check", "complaint", "\n".join(complaints))

    @property
    def answers(self) -> tuple[str, ...]:
        """The user's answers, in order."""
        return tuple(t.text for t in self.turns if t.kind == "answer")

    @property
    def open(self) -> bool:
        """Whether it ends with a question."""
        return bool(self.turns) and self.turns[-1].kind == "question"

    def as_json(self) -> bytes:
        """The artifact `dialogue.json`."""
        document = {
            "schema_version": 1,
            "turns": [{"by": t.by, "kind": t.kind, "text": t.text, **t.more} for t in self.turns],
        }
        return (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode("utf-8", "replace")

    @staticmethod
    def from_json(data: bytes) -> Dialogue:
        """The inverse of `as_json`; ValueError, KeyError or TypeError where it is not one."""
        return Dialogue(
            tuple(
                Turn(
                    str(t["by"]),
                    str(t["kind"]),
                    str(t["text"]),
                    {k: v for k, v in t.items() if k not in {"by", "kind", "text"}},
                )
                for t in json.loads(data)["turns"]
            )
        )
