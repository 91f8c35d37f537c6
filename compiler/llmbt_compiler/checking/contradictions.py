"""Goals that cannot hold together, and steps that put one thing in two places; with the steps to blame."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

from llmbt_atl.state import Domain
from llmbt_compiler.parsing import Goal, Move, ParseResult, say
from llmbt_ir.diagnostics import Diagnostic, Span
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["contradictions"]

_MOST = 10
_WAITS = re.compile(r"\b(?:wait|pause|until|afterwards|later|hold on|stand by)\b")


def contradictions(
    parsed: ParseResult,
    domain: Domain,
    semantic_map: SemanticMap,
    where: Callable[[Goal], Span],
    texts: Sequence[tuple[int, str]] = (),
) -> tuple[Diagnostic, ...]:
    """E343 for every two goals that exclude each other by the library's state variables, and for an object that the
    steps put into one place and, for no reason that they show, into another.

    `where` says where a goal is written, `texts` are the steps by their
    numbers. What the templates make unreachable beyond that is the search's to prove.
    """
    found = [
        _diagnostic(a, b, f"{say(a.condition, domain.library)}, and {say(b.condition, domain.library)}", where)
        for a, b in combinations(parsed.goals, 2)
        if domain.mutex(a.condition, b.condition)
    ]
    found += [
        _diagnostic(a.goal, b.goal, f"{a.target} would be in two places: {a.place} and {b.place}", where)
        for a, b in _twice(parsed.moves, semantic_map)
        if not _one_after_the_other(a, b, texts)
    ]
    return tuple(found[:_MOST])


def _diagnostic(a: Goal, b: Goal, what: str, where: Callable[[Goal], Span]) -> Diagnostic:
    return Diagnostic(
        "E343",
        f"the steps contradict each other: {what}",
        where(b),
        f"step {b.step_number}: {b.words}"[:200],
        "change one of the two",
        notes=(f"step {a.step_number}: {a.words}"[:200], f"step {b.step_number}: {b.words}"[:200]),
    )


def _twice(moves: Sequence[Move], semantic_map: SemanticMap) -> Iterator[tuple[Move, Move]]:
    """Moves of one object to two places, where nothing that is done between them needs it out of its way.

    A buffer is a stop on the way, so is where it is carried right before; a place that the words left open is no claim,
    and that another object goes meanwhile to where it stood is a reason.
    """
    where = {o.id: o.place for o in semantic_map.objects}
    last: dict[str, tuple[int, str | None]] = {}
    for k, move in enumerate(moves):
        before = last.get(move.target)
        last[move.target] = (k, where.get(move.target))
        if before is not None:
            earlier, origin = moves[before[0]], before[1]
            gone_to = {m.place for m in moves[before[0] + 1 : k] if m.target != move.target}
            carried = before[0] == k - 1 and _is_carried(earlier)
            stop = carried or earlier.chosen or origin in gone_to or _is_stop(earlier.place, semantic_map)
            if not stop and not _one_place(earlier.place, move.place, semantic_map):
                yield earlier, move
        where[move.target] = move.place


def _one_after_the_other(a: Move, b: Move, texts: Sequence[tuple[int, str]]) -> bool:
    """Whether the steps between two moves of an object say that it is to be first here and then there: they wait, or
    take it up again from where the first has put it."""
    between = " ".join(t for n, t in texts if a.goal.step_number < n <= b.goal.step_number).casefold()
    place = a.place.replace("_", " ")
    again = re.search(rf"\b(?:from|off)\s+(?:the\s+)?{re.escape(place)}\b", between.replace("_", " "))
    return again is not None or _WAITS.search(between) is not None


def _is_carried(move: Move) -> bool:
    """ "Carry it to the desk", and then "hand it to the user": the first only tells the way."""
    words = move.goal.words.lower().split()
    return bool(words) and words[0] in {"carry", "take", "transport", "convey", "haul"}


def _is_stop(place: str, semantic_map: SemanticMap) -> bool:
    found = semantic_map.place(place)
    return found is None or found.buffer


def _one_place(a: str, b: str, semantic_map: SemanticMap) -> bool:
    return a == b or a in semantic_map.containers(b) or b in semantic_map.containers(a)
