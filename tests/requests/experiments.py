"""The requests of experiments/ as a second opinion: others wrote them, for another purpose, without these decisions in
mind. Clear ones are to compile to what the case wants; those marked as unclear or wrong are not to compile."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from llmbt.compilation import Request, compile_into
from llmbt.experiment.cases import Case, cassette_of, experiment_names, load_experiment
from llmbt.progress import Progress
from llmbt_atl.state import domain_of
from llmbt_ir.condition import Facts, satisfied
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.scene import to_semantic_map
from llmbt_ir.tree import goal_tree
from llmbt_runtime.chance import chance
from llmbt_runtime.executor import execute
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.symbolic import SymbolicWorld

__all__ = ["Row", "counted", "decided"]


@dataclass(frozen=True, slots=True)
class Row:
    """One request of a case: whether it is clear, and what came of it."""

    experiment: str
    case: str
    id: str
    clear: bool
    text: str
    outcome: str

    @property
    def right(self) -> bool:
        """Clear ones are fulfilled, the others not carried out."""
        return self.outcome == "fulfilled" if self.clear else self.outcome.startswith("exit")


def decided(folder: Path) -> Iterator[Row]:
    """Every request that has a recording."""
    for name in experiment_names():
        for case in load_experiment(name).cases:
            for request in case.requests:
                tape = cassette_of(case, request)
                if tape.exists():
                    into = folder / name / case.name / request.id
                    outcome = _outcome(case, request.text, tape, into)
                    yield Row(name, case.name, request.id, request.clear, request.text, outcome)


def _outcome(case: Case, text: str, tape: Path, into: Path) -> str:
    order = Request(text, case.scene.source if Path(case.scene.source).exists() else case.scene.name, cassette=tape)
    try:
        done = compile_into(order, into, Progress(quiet=True))
    except LlmbtError as fault:
        return f"exit {int(fault.exit_code)}: {fault.diagnostics[0].code} {fault.diagnostics[0].title}"
    semantic_map = to_semantic_map(case.scene)
    domain = domain_of(case.library, semantic_map)
    start: Facts = facts_of_map(domain, semantic_map)
    goals = (tuple(dict.fromkeys(g.condition for g in done.compiled.goals)),)
    world = SymbolicWorld(domain.for_state(start), start, chance(0, "check"), ticks=(1, 1))
    execute(world, domain, goal_tree(goals), goals, keep=lambda _: "", tell=lambda _: None)
    return "fulfilled" if satisfied(case.success, world.truth()) else f"other goals: {'; '.join(map(str, goals[0]))}"


def counted(*, verbose: bool = False) -> str:
    """Markdown: a row for each experiment and kind; what is not right is told on stderr."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as scratch:
        for row in decided(Path(scratch)):
            rows.append(row)
            if verbose or not row.right:
                kind = "clear" if row.clear else "unclear or wrong"
                print(f"{row.case} {row.id} ({kind}): {row.text}\n    {row.outcome}", file=sys.stderr)
    lines = ["| experiment | requests | number | right |", "|---|---|---|---|"]
    for name in dict.fromkeys(r.experiment for r in rows):
        for clear, told in ((True, "clear: fulfilled in the world of facts"), (False, "unclear or wrong: no tree")):
            found = [r for r in rows if (r.experiment, r.clear) == (name, clear)]
            n = sum(r.right for r in found)
            lines.append(f"| {name} | {told} | {len(found)} | {n} ({100 * n / max(1, len(found)):.0f} %) |")
    return "\n".join(lines)
