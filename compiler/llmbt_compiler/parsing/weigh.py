"""Which of several ways to read a step is taken: by their probabilities, and by what they come to on the map."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

__all__ = ["Trial", "shares", "weigh"]

V = TypeVar("V")

_RIVAL = 0.3
"""A reading that comes to something else may be at most this probable beside the one that is taken."""
_LEAST = 0.35
"""However little else makes sense, what is taken has to be at least this probable."""
_RESCUE = 0.2
"""Where the likeliest reading makes no sense on the map, one that does has to be at least this probable."""


@dataclass(frozen=True, slots=True)
class Trial(Generic[V]):
    """A way to read a step: what the parser was left with, how probable the reading is, whether it was `clean` of
    complaints, and what it comes to."""

    value: V
    probability: float
    clean: bool
    outcome: Hashable


def shares(trials: Sequence[Trial[V]], words: Callable[[V], str]) -> list[tuple[str, float]]:
    """What the readings come to, in words, with the probabilities of those that say the same together; most first."""
    found: dict[str, float] = {}
    for t in trials:
        told = words(t.value) if t.clean else "what the map does not bear out"
        found[told] = found.get(told, 0.0) + t.probability
    return sorted(found.items(), key=lambda item: -item[1])


def weigh(
    trials: Sequence[Trial[V]], before: Hashable, threshold: float, less: Callable[[V, V], bool] = lambda _a, _b: False
) -> Trial[V] | None:
    """The trial to go on with, likeliest first among those of one outcome; None where none is sure enough.

    Readings that come to the same count together, and their share is that of the readings that make sense on the map.
    One with complaints is taken, complaints and all, only where no other does; one that changes nothing (`before`)
    never makes up for one that does. What is `less` than another, a part of it, is no rival to it.
    """
    mass: dict[Hashable, float] = {}
    for t in trials:
        if t.clean:
            mass[t.outcome] = mass.get(t.outcome, 0.0) + t.probability
    top = trials[0]
    ranked = sorted(mass.items(), key=lambda item: -item[1])
    first = next((t for t in trials if t.clean and t.outcome == ranked[0][0]), top) if ranked else top
    if not ranked:
        return top if sum(t.probability for t in trials) >= threshold else None
    others = (next(t for t in trials if t.clean and t.outcome == o) for o, _ in ranked[1:])
    rival = max((mass[t.outcome] for t in others if not less(t.value, first.value)), default=0.0)
    share = ranked[0][1]
    if top.clean:
        sure = share >= threshold * sum(mass.values()) and share >= min(threshold, _LEAST)
        return first if sure and rival <= _RIVAL else None
    if first.outcome == before:
        return top
    return first if share >= _RESCUE and rival <= _RIVAL * share else top
