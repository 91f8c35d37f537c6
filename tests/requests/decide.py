"""What is decided about a request: compiled through a recording made of its replies, from the words to the proof."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from llmbt.compilation import Request, compile_into
from llmbt.progress import Progress
from llmbt_atl.library import load_library
from llmbt_compiler.reasoning.author import author
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import ExitCode, LlmbtError
from llmbt_ir.scene import Scene, load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap
from tests.requests.cases import Case, Goals

__all__ = ["Decision", "Judged", "decide", "judge", "same_goals"]

QUIET = Progress(quiet=True)
_LACKING = ("E142", "E301", "E302")
_MAYBE = ("E140", "E309")
"""The model's own question, and a relation that no position is in: by their words."""
_NEGATION = re.compile(
    r"\b(?:no|not|none|nothing|nobody|neither|cannot|lacks?|only|without|missing|absent|unable|unavailable|impossible)\b"
    r"|n['\u2019]t\b",
    re.IGNORECASE,
)


@dataclass(frozen=True, slots=True)
class Decision:
    """An exit code; with 0 the goals, with 5 the candidates, and else the code and the words of the reason."""

    exit_code: int
    goals: frozenset[Condition] = frozenset()
    candidates: tuple[str, ...] = ()
    reason: str = ""

    def __str__(self) -> str:
        if self.exit_code == 0:
            return "compiles: " + "; ".join(sorted(map(str, self.goals)))
        return f"exit {self.exit_code}: {self.reason}" + (f" [{', '.join(self.candidates)}]" if self.candidates else "")


@dataclass(frozen=True, slots=True)
class Judged:
    """A case, what was decided first and, where it was asked about, after the answers; and what is wrong with it."""

    case: Case
    first: Decision
    then: Decision | None = None
    wrong: str = ""

    @property
    def right(self) -> bool:
        """Whether all of it is as it should be."""
        return not self.wrong


def decide(case: Case, folder: Path, answers: Sequence[str] = ()) -> Decision:
    """Compile a case's request, replaying a recording of its replies, with these answers."""
    folder.mkdir(parents=True, exist_ok=True)
    tape = folder / "tape.yaml"
    scene = load_scene(case.scene)
    request = Request(case.text, case.scene, cassette=tape, answers=tuple(answers))
    try:
        if not tape.exists():
            _record(case, scene, tape)
        done = compile_into(request, folder / f"run{len(answers)}", QUIET)
    except LlmbtError as fault:
        first = fault.diagnostics[0]
        return Decision(int(fault.exit_code), frozenset(), first.candidates, f"{first.code} {first.title}")
    return Decision(0, frozenset(g.condition for g in done.compiled.goals))


def _record(case: Case, scene: Scene, tape: Path) -> None:
    """All replies of a case, with the answers between them; the first alone where no other one is asked for."""
    library = load_library(scene.library, beside=Path(scene.source).parent)

    def made_of(replies: Sequence[str]) -> None:
        said = case.answers if len(replies) > 1 else ()
        author(case.text, to_semantic_map(scene), library, replies, tape, answers=said, scene=case.scene)

    try:
        made_of(case.replies)
    except LlmbtError as fault:
        if fault.diagnostics[0].code != "E131":
            raise
        made_of(case.replies[:1])


def judge(case: Case, folder: Path) -> Judged:
    """Hold what is decided against what is right."""
    first = decide(case, folder)
    if case.kind == "complete":
        return Judged(case, first, wrong=_compiled_wrong(case, first))
    if case.kind == "impossible":
        return Judged(case, first, wrong=_refused_wrong(first))
    if first.exit_code != ExitCode.UNCLEAR:
        return Judged(case, first, wrong="nothing is asked")
    if case.candidates is not None and set(first.candidates) != case.candidates:
        return Judged(case, first, wrong="other candidates")
    then = decide(case, folder, case.answers)
    return Judged(case, first, then, _compiled_wrong(case, then))


def _refused_wrong(decision: Decision) -> str:
    """A question is a refusal only where it says what is lacking."""
    if decision.exit_code == ExitCode.UNCLEAR:
        code, _, question = decision.reason.partition(" ")
        lacking = code in _LACKING or (code in _MAYBE and _NEGATION.search(question) is not None)
        return "" if lacking else "a question that does not say what is lacking"
    return "" if decision.exit_code in {ExitCode.BAD_INPUT, ExitCode.NO_SUCCESS} else "it is not refused"


def _compiled_wrong(case: Case, decision: Decision) -> str:
    if decision.exit_code != 0:
        return "it is asked about" if decision.exit_code == ExitCode.UNCLEAR else "it is refused"
    semantic_map = to_semantic_map(load_scene(case.scene))
    right = any(same_goals(decision.goals, wanted, semantic_map) for wanted in case.goals)
    return "" if right or not case.goals else "other goals"


def same_goals(decided: Goals, wanted: Goals, semantic_map: SemanticMap) -> bool:
    """Whether goals are those that are wanted.

    A place that contains others stands for any of them. What the map has already may be said or left out, unless the
    goals move it.
    """
    there = {o.id: o.place for o in semantic_map.objects}

    def holds(goal: Condition) -> bool:
        if goal.name == "HandEmpty" and not goal.negated:
            return not any(g.name == "Holding" for g in decided)
        place = there.get(goal.args[0]) if goal.name == "On" and not goal.negated else None
        return place is not None and (goal.args[1] == place or goal.args[1] in semantic_map.containers(place))

    moved = {g.args[0] for g in decided if g.name == "On"}
    more = [d for d in decided if not any(_meets(d, w, semantic_map) for w in wanted)]
    less = [w for w in wanted if not any(_meets(d, w, semantic_map) for d in decided)]
    return all(map(holds, more)) and all(holds(w) and w.args[0] not in moved for w in less)


def _meets(goal: Condition, wanted: Condition, semantic_map: SemanticMap) -> bool:
    """Whether a goal is what is wanted, or puts the same thing on a place within the one that is wanted."""
    if goal == wanted:
        return True
    both = goal.name == wanted.name == "On" and goal.negated == wanted.negated and goal.args[0] == wanted.args[0]
    return both and wanted.args[1] in semantic_map.containers(goal.args[1])
