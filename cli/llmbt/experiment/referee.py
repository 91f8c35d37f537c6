"""A referee between an episode's world and somebody's executor: a process that answers each line of JSON with one.

The world goes on by one tick for each answer, however long that takes; what an executor sees are the facts, the actions
there are, and how the last one ended. docs/benchmark.md has the protocol.
"""

from __future__ import annotations

import json
import selectors
import shlex
import subprocess
import time
from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from llmbt_ir.condition import ActionCall, Facts, parse_condition, satisfied
from llmbt_ir.diagnostics import Diagnostic, LlmbtError
from llmbt_runtime.episodes import Episode
from llmbt_runtime.episodes.written import actions_json, episode_id
from llmbt_runtime.world import Status

__all__ = ["PROTOCOL", "Executor", "Played", "play"]

PROTOCOL = 1
MAX_LINE = 4 * 1024 * 1024
VERDICTS = ("SUCCESS", "UNSOLVABLE", "GIVE_UP")


@dataclass(frozen=True, slots=True)
class Played:
    """How an episode went: the executor's verdict, or what it did against the rules (`fault`), the facts as they then
    were, and what it took. `answer_s`: the longest answer, by the clock."""

    verdict: str
    fault: str
    facts: Facts
    ticks: int
    actions: int
    answer_s: float


class ExecutorFaultError(RuntimeError):
    """An executor that does not keep to the protocol: it is silent, gone, or says what cannot be understood."""


class Executor:
    """Somebody's executor as a process. It is started anew where it was lost."""

    def __init__(self, command: str, patience_s: float) -> None:
        self.command, self.patience_s = command, patience_s
        self._process: subprocess.Popen[bytes] | None = None
        self._rest = b""

    def __enter__(self) -> Executor:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, at: TracebackType | None) -> None:
        self.stop()

    def ask(self, message: Mapping[str, Any]) -> Mapping[str, Any]:
        """Send a message, and wait for the answer. ExecutorFaultError where none comes in time."""
        self.tell(message)
        until = time.monotonic() + self.patience_s
        process = self._running()
        assert process.stdout is not None
        with selectors.DefaultSelector() as selector:
            selector.register(process.stdout, selectors.EVENT_READ)
            while b"\n" not in self._rest:
                if not selector.select(max(0.0, until - time.monotonic())):
                    raise ExecutorFaultError(f"no answer within {self.patience_s:g} s")
                data = process.stdout.read1(65_536)  # type: ignore[attr-defined]
                if not data:
                    raise ExecutorFaultError("the executor ended")
                self._rest += data
                if len(self._rest) > MAX_LINE:
                    raise ExecutorFaultError("an answer of several megabytes")
        line, _, self._rest = self._rest.partition(b"\n")
        try:
            answer = json.loads(line)
        except ValueError:
            answer = None
        if not isinstance(answer, dict):
            raise ExecutorFaultError(f"no JSON object: {line[:80].decode('utf-8', 'replace')}")
        return answer

    def tell(self, message: Mapping[str, Any]) -> None:
        """Send a message that asks for no answer."""
        process = self._running()
        assert process.stdin is not None
        try:
            process.stdin.write(json.dumps(message, ensure_ascii=False).encode() + b"\n")
            process.stdin.flush()
        except OSError:
            raise ExecutorFaultError("the executor ended") from None

    def _running(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            try:
                self._process = subprocess.Popen(
                    shlex.split(self.command), stdin=subprocess.PIPE, stdout=subprocess.PIPE
                )
            except (OSError, ValueError) as fault:
                title = f"the executor cannot be started: {fault}"
                raise LlmbtError(Diagnostic("E412", title, help="give a command, as: python my_executor.py")) from None
            self._rest = b""
        return self._process

    def stop(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None


def play(episode: Episode, executor: Executor, max_ticks: int) -> Played:
    """One episode from its first message to its result."""
    return _Game(episode, executor, max_ticks).play()


def _verdict(answer: Mapping[str, Any]) -> str:
    verdict = str(answer.get("verdict", ""))
    if verdict not in VERDICTS:
        raise ExecutorFaultError(f"no verdict: {verdict[:40]}")
    return verdict


class _Game:
    """The mutable state of one episode."""

    def __init__(self, episode: Episode, executor: Executor, max_ticks: int) -> None:
        self.episode, self.executor, self.max_ticks = episode, executor, max_ticks
        self.world = episode.world()
        self.domain = episode.domain.for_state(episode.facts)
        self.told: set[str] = set()
        self.running: str | None = None
        self.ended: dict[str, str] | None = None
        self.ticks = self.actions = 0
        self.slowest = 0.0

    def play(self) -> Played:
        verdict, fault = "", ""
        try:
            answer = self.ask(
                {
                    "type": "episode",
                    "protocol": PROTOCOL,
                    "id": episode_id(self.episode),
                    "goals": [list(map(str, a)) for a in self.episode.goals],
                    "max_ticks": self.max_ticks,
                    **self.seen(),
                }
            )
            while self.ticks < self.max_ticks:
                if answer.get("do") == "end":
                    verdict = _verdict(answer)
                    break
                self.obey(answer)
                answer = self.ask({"type": "tick", "tick": self.ticks, **self.seen()})
        except ExecutorFaultError as broken:
            fault = str(broken)
        self.world.halt()
        facts = self.world.truth()
        if not fault:
            try:
                success = satisfied(self.episode.goals, facts)
                self.executor.tell({"type": "result", "id": episode_id(self.episode), "success": success})
            except ExecutorFaultError as broken:
                fault = str(broken)
        if fault:
            self.executor.stop()
        return Played(verdict, fault, facts, self.ticks, self.actions, self.slowest)

    def ask(self, message: Mapping[str, Any]) -> Mapping[str, Any]:
        began = time.monotonic()
        answer = self.executor.ask(message)
        self.slowest = max(self.slowest, time.monotonic() - began)
        return answer

    def seen(self) -> dict[str, Any]:
        """What an executor is shown: all facts, and the actions that it has not been told of."""
        facts = self.world.observe()
        self.domain = self.domain.for_state(facts)
        new = [a for a in self.domain.actions if str(a) not in self.told]
        self.told.update(map(str, new))
        shown = {"facts": [str(f) for f in sorted(facts)], "running": self.running, "ended": self.ended}
        return {**shown, "actions": actions_json(new)} if new else shown

    def obey(self, answer: Mapping[str, Any]) -> None:
        """Do what is asked for, and let one tick go by."""
        match answer.get("do"):
            case "start":
                self.start(str(answer.get("action", "")))
            case "halt":
                self.stop()
            case "wait":
                pass
            case other:
                raise ExecutorFaultError(f"unknown: do {str(other)[:40]}")
        self.ended = None
        report = self.world.advance()
        self.ticks += 1
        if self.running is not None and report.status in (Status.SUCCESS, Status.FAILURE):
            self.ended = {"action": self.running, "result": report.status.value, "reason": report.reason}
            self.running = None

    def start(self, name: str) -> None:
        literal = parse_condition(name)
        call = ActionCall(literal.name, literal.args) if literal is not None else None
        if call is None or name not in self.told or self.domain.action(call) is None:
            raise ExecutorFaultError(f"no such action: {name[:80]}")
        if name == self.running:
            return
        self.stop()
        self.world.start(call)
        self.actions += 1
        self.running = name

    def stop(self) -> None:
        if self.running is not None:
            self.world.halt()
            self.running = None
