"""Keywords to goals: the paper's if-else walk, names held against the map, pick-then-place folded into one
goal.
"""

from llmbt_compiler.parsing.model import (
    Extent,
    Goal,
    LabelledStep,
    Move,
    Note,
    NoteKind,
    ParseResult,
    exit_code_of,
)
from llmbt_compiler.parsing.say import say, say_goals, say_outcome
from llmbt_compiler.parsing.walk import parse

__all__ = [
    "Extent",
    "Goal",
    "LabelledStep",
    "Move",
    "Note",
    "NoteKind",
    "ParseResult",
    "exit_code_of",
    "parse",
    "say",
    "say_goals",
    "say_outcome",
]
