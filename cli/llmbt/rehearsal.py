"""The check between reasoning and execution: proved by search, then run through in the world of facts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from llmbt_atl.library import Library
from llmbt_atl.state import Domain
from llmbt_compiler.parsing import Goal, say
from llmbt_ir.condition import Facts, Goals
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span
from llmbt_ir.semantic_map import SemanticMap
from llmbt_ir.tree import goal_tree
from llmbt_runtime.chance import chance
from llmbt_runtime.executor import execute
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.outcome import Outcome, Result
from llmbt_runtime.search import OutOfBudget, Unsolvable
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.update.loop import update

__all__ = ["Rehearsal", "rehearse"]


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """How the tree did in the world of facts, undisturbed: the actions that it took."""

    actions: tuple[str, ...]
    updates: int

    def words(self) -> str:
        """In a line."""
        n = len(self.actions)
        return f"rehearsed in the world of facts: {n} action{'' if n == 1 else 's'} reach the goals"

    def as_json(self) -> dict[str, Any]:
        """For `--json`."""
        return {"outcome": Outcome.SUCCESS.value, "actions": list(self.actions), "updates": self.updates}


def rehearse(
    goals: Sequence[Goal], domain: Domain, semantic_map: SemanticMap, where: Callable[[Goal], Span]
) -> Rehearsal:
    """Show that the goals can be reached from what the map says, and that the tree reaches them, before anything moves.

    Errors, all with exit code 3 and the steps to blame: E341 it is proved that they cannot be reached, E342 nothing was
    found within the budget, E344 the run in the world of facts ends without them.
    """
    facts = facts_of_map(domain, semantic_map)
    wanted: Goals = (tuple(dict.fromkeys(g.condition for g in goals)),)
    found = update(goal_tree(wanted), domain.for_state(facts), facts, wanted)
    if isinstance(found, OutOfBudget):
        raise _error("E342", f"no plan was found within {found.expansions} expansions", goals, domain.library, where)
    if isinstance(found, Unsolvable):
        blamed = [g for g in goals if g.condition in found.goals]
        raise _error("E341", f"the goals cannot be reached: {found.reason}", blamed, domain.library, where)
    result = _run(domain, facts, wanted)
    if result.outcome is not Outcome.SUCCESS:
        missed = {c for c, _, holds in result.goals if not holds}
        blamed = [g for g in goals if g.condition in missed]
        raise _error("E344", f"the rehearsal ends as {result.outcome}: {result.reason}", blamed, domain.library, where)
    return Rehearsal(tuple(str(a.call) for a in result.actions if a.result == "SUCCESS"), result.updates)


def _run(domain: Domain, facts: Facts, goals: Goals) -> Result:
    world = SymbolicWorld(domain.for_state(facts), facts, chance(0, "rehearsal"), ticks=(1, 1))
    try:
        return execute(world, domain, goal_tree(goals), goals, keep=lambda _: "", tell=lambda _: None)
    finally:
        world.close()


def _error(
    code: str, title: str, blamed: Sequence[Goal], library: Library, where: Callable[[Goal], Span]
) -> LlmbtError:
    span = where(blamed[0]) if blamed else None
    notes = tuple(f"{say(g.condition, library)} (step {g.step_number}: {g.words})" for g in blamed)
    diagnostic = Diagnostic(code, title, span, help="change the request, or what stands where", notes=notes)
    return LlmbtError(diagnostic, exit_code=ExitCode.NO_SUCCESS)
