"""What is decided about a request: compiled through a recording made of its replies, from the words to the proof."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from llmbt.compilation import Request, compile_into
from llmbt.progress import Progress
from llmbt_atl.library import load_library
from llmbt_compiler.reasoning.author import author
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import ExitCode, LlmbtError
from llmbt_ir.scene import load_scene, to_semantic_map
from tests.requests.cases import Case

__all__ = ["Decision", "Judged", "decide", "judge"]

QUIET = Progress(quiet=True)


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
    if not tape.exists():
        library = load_library(scene.library, beside=Path(scene.source).parent)
        said = case.answers if len(case.replies) > 1 else ()
        author(case.text, to_semantic_map(scene), library, case.replies, tape, answers=said, scene=case.scene)
    request = Request(case.text, case.scene, cassette=tape, answers=tuple(answers))
    try:
        done = compile_into(request, folder / f"run{len(answers)}", QUIET)
    except LlmbtError as fault:
        first = fault.diagnostics[0]
        return Decision(int(fault.exit_code), frozenset(), first.candidates, f"{first.code} {first.title}")
    return Decision(0, frozenset(g.condition for g in done.compiled.goals))


def judge(case: Case, folder: Path) -> Judged:
    """Hold what is decided against what is right."""
    first = decide(case, folder)
    if case.kind == "complete":
        return Judged(case, first, wrong=_compiled_wrong(case, first))
    if case.kind == "impossible":
        refused = first.exit_code in {ExitCode.BAD_INPUT, ExitCode.NO_SUCCESS, ExitCode.UNCLEAR}
        return Judged(case, first, wrong="" if refused else "it is not refused")
    if first.exit_code != ExitCode.UNCLEAR:
        return Judged(case, first, wrong="nothing is asked")
    if case.candidates is not None and set(first.candidates) != case.candidates:
        return Judged(case, first, wrong="other candidates")
    then = decide(case, folder, case.answers)
    return Judged(case, first, then, _compiled_wrong(case, then))


def _compiled_wrong(case: Case, decision: Decision) -> str:
    if decision.exit_code != 0:
        return "it is asked about" if decision.exit_code == ExitCode.UNCLEAR else "it is refused"
    return "" if decision.goals in case.goals else "other goals"
