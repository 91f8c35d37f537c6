"""Goals said back in plain words, from the library's own."""

from __future__ import annotations

from collections.abc import Iterable

from llmbt_atl.library import Library
from llmbt_compiler.parsing.model import Goal
from llmbt_ir.condition import Condition

__all__ = ["say", "say_goals", "say_outcome"]


def say(condition: Condition, library: Library) -> str:
    """``object_1 is on position_12``; the literal itself where the library has no words for it."""
    declared = library.conditions.get(condition.name)
    if declared is None or not declared.words or len(declared.params) != len(condition.args):
        return str(condition)
    words = declared.words
    for param, arg in zip(declared.params, condition.args, strict=True):
        words = words.replace(f"{{{param.name}}}", arg)
    return f"it is not so that {words}" if condition.negated else words


def say_goals(goals: Iterable[Goal], library: Library) -> tuple[str, ...]:
    """One line a goal, in order."""
    return tuple(say(g.condition, library) for g in goals)


def say_outcome(condition: Condition, library: Library, things: Iterable[str]) -> str:
    """What a person is asked to confirm: ``object 1 will be on position 12``; ids are written as words."""
    words = say(condition.fact, library)
    for now, then in ((" is ", " will be "), (" holds ", " will hold "), (" are ", " will be ")):
        if now in f" {words} ":
            words = f" {words} ".replace(now, then, 1).strip()
            break
    else:
        words = f"it will be so that {words}"
    words = f"it will not be so that {say(condition.fact, library)}" if condition.negated else words
    known = {t for t in things if t in condition.args}
    return " ".join(w.replace("_", " ") if w in known else w for w in words.split(" "))
