"""What an episode is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from llmbt_atl.state import Domain
from llmbt_atl.template import ConditionType
from llmbt_ir.condition import Condition, Facts, Goals
from llmbt_runtime.symbolic import Event, SymbolicWorld

__all__ = ["Draft", "Episode", "flag", "legal", "pick_some"]


@dataclass(frozen=True, slots=True)
class Draft:
    """A problem before its events are dated. `moves` are the events that may happen; `expected` is what the maker
    knows of whether the goals can be reached, whatever is done and happens (None: not known)."""

    domain: Domain
    facts: Facts
    goals: Goals
    moves: tuple[Event, ...] = ()
    expected: bool | None = None


@dataclass(frozen=True, slots=True)
class Episode:
    """A problem in the symbolic world.

    `solvable`: True where whoever keeps clear of dead ends of his own making reaches the goals, whatever the events do
    and whenever they fire; False where no actions and events together reach them; None where it depends. `verified`:
    shown by looking at every state, otherwise known from the way the episode was made.
    """

    kind: str
    seed: int
    domain: Domain
    facts: Facts
    goals: Goals
    events: tuple[Event, ...]
    ticks: tuple[int, int]
    failure_rate: float
    solvable: bool | None
    verified: bool

    def world(self) -> SymbolicWorld:
        """A new world with the episode's own chance: durations and failures are the same for the same actions."""
        rng = np.random.default_rng([self.seed, 7])
        return SymbolicWorld(
            self.domain, self.facts, rng, ticks=self.ticks, failure_rate=self.failure_rate, events=self.events
        )

    def fresh(self) -> Domain:
        """The domain with nothing ground yet, so that whoever is timed pays for it."""
        return replace(self.domain)


def flag(name: str) -> ConditionType:
    """A condition without arguments."""
    return ConditionType(name, (), goal=True)


def legal(
    domain: Domain, name: str, when: tuple[Condition, ...], removes: set[Condition], adds: set[Condition]
) -> Event:
    """What somebody else does: where `when` holds, facts end and begin, with all that containment implies."""
    up_removes = frozenset(u for f in removes for u in domain.upward(f))
    up_adds = frozenset(u for f in adds for u in domain.upward(f))
    return Event(0, up_removes - up_adds, up_adds, when, name, next((a for c in when for a in c.args), ""))


def pick_some(rng: np.random.Generator, items: list[str], low: int, high: int) -> list[str]:
    """Between `low` and `high` different items, in a random order."""
    n = min(len(items), int(rng.integers(low, high + 1)))
    return [items[i] for i in rng.permutation(len(items))[:n]]
