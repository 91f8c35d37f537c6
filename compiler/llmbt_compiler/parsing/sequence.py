"""Clauses in the order in which they are to be done: "hand it over after picking up the coke" picks up first."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.parsing.clauses import Clause, extents
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["in_time"]

Placed = tuple[Clause, tuple[int, int]]
_ENDS = frozenset({".", ";", "!", "?"})


def in_time(said: Sequence[Clause], text: str, *, spoken_of: bool) -> tuple[Placed, ...]:
    """Clauses and where they are, those behind "after" before what is done after them.

    A pronoun in what would come later means something named before where something was (`spoken_of`): then the order
    stays.
    """
    found = tuple(zip(said, extents(said, len(text)), strict=True))
    out: list[Placed] = []
    begin = 0  # where the sentence begins among them
    for i, (clause, extent) in enumerate(found):
        words = [t.text for t in tokens(text, found[i - 1][0].extent.end if i else 0, clause.extent.start)]
        if i and _ENDS & set(words):
            begin = len(out)
        earlier = out[begin:]
        points = any(p.about("pronouns") or p.about("plural_pronouns") for c, _ in earlier for p in c.phrases)
        first = words[-1:] == ["after"] and clause.action.casefold().endswith("ing")
        if earlier and first and not (points and spoken_of) and not _aside(earlier):
            out.insert(begin, (clause, extent))
        else:
            out.append((clause, extent))
    return tuple(out)


def _aside(earlier: Sequence[Placed]) -> bool:
    """Whether what stands before is no order itself, or one that stands under a condition."""
    return any(c.conditional or c.negated or lexicon().is_(c.action.casefold(), "negation") for c, _ in earlier)
