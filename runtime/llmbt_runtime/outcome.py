"""How an execution ends, and what is told while it goes on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from llmbt_ir.condition import ActionCall, Condition

__all__ = ["Executed", "Happening", "Outcome", "Result"]


class Outcome(StrEnum):
    """SUCCESS: the goals hold by the truth, at rest. UNSOLVABLE: proved from the last observed state, by these
    templates. BUDGET: the search's budget, or the guard on ticks, is spent. ACTION_FAILED: what would lead on failed
    three times, and nothing else leads on. TREE_FAILED: a tree that was ticked as it stands returned FAILURE, or
    SUCCESS while a goal does not hold."""

    SUCCESS = "SUCCESS"
    UNSOLVABLE = "UNSOLVABLE"
    BUDGET = "BUDGET"
    ACTION_FAILED = "ACTION_FAILED"
    TREE_FAILED = "TREE_FAILED"
    INTERRUPTED = "INTERRUPTED"
    WORLD_LOST = "WORLD_LOST"


@dataclass(frozen=True, slots=True)
class Executed:
    """An action that was run: SUCCESS, FAILURE or HALTED, the reason, and when (simulated)."""

    call: ActionCall
    result: str
    reason: str
    started_s: float
    ended_s: float


@dataclass(frozen=True, slots=True)
class Happening:
    """One line of the story: `kind` is one of started, ended, deviation, update, waiting, disturbance, outcome."""

    kind: str
    time_s: float
    text: str
    details: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Result:
    """What an execution came to. `goals` are (literal, number of its alternative from 1, whether it holds);
    `updates` counts installed changes of the tree."""

    outcome: Outcome
    reason: str
    goals: tuple[tuple[Condition, int, bool], ...]
    actions: tuple[Executed, ...]
    updates: int
    ticks: int
    planner_calls: int
    expansions: int
    sim_time_s: float
    unsolvable: tuple[Condition, ...] = ()
