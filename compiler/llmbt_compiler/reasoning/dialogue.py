"""A whole dialogue: the prompt, the reply, and for each question the model asks the user's answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from llmbt_compiler.reasoning.chat import Reply, Settings, Transport, ask
from llmbt_compiler.reasoning.filter import filter_steps
from llmbt_compiler.reasoning.prompt import Prompt, continue_prompt
from llmbt_compiler.reasoning.steps import Question, Steps

__all__ = ["Conversation", "converse"]


@dataclass(frozen=True, slots=True)
class Conversation:
    """Every turn, and what the last reply comes to. `unused` are answers to which there was no question."""

    turns: tuple[tuple[Prompt, Reply], ...]
    result: Steps | Question
    unused: tuple[str, ...] = ()

    @property
    def prompt(self) -> Prompt:
        """The last prompt: the whole dialogue up to the last reply."""
        return self.turns[-1][0]

    @property
    def reply(self) -> Reply:
        """The last reply."""
        return self.turns[-1][1]


def converse(prompt: Prompt, answers: Sequence[str], settings: Settings, transport: Transport) -> Conversation:
    """Ask, and answer the model's questions as long as there are answers. Errors as `ask` and
    `filter_steps`."""
    turns: list[tuple[Prompt, Reply]] = []
    left = list(answers)
    while True:
        reply = ask(prompt.messages, settings, transport)
        turns.append((prompt, reply))
        result = filter_steps(reply.text)
        if isinstance(result, Steps) or not left:
            return Conversation(tuple(turns), result, tuple(left))
        prompt = continue_prompt(prompt, reply.text, left.pop(0))
