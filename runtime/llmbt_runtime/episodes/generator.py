"""Episodes by kind, number of events and seed: the same call gives the same episode in every process."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from zlib import crc32

import numpy as np

from llmbt_ir.condition import all_hold, satisfied
from llmbt_runtime.episodes.model import Draft, Episode
from llmbt_runtime.episodes.propositional import random_strips, threats
from llmbt_runtime.episodes.things import blocks, cargo, coins, cycles, rooms
from llmbt_runtime.episodes.truth import Label, label, path, shortest
from llmbt_runtime.symbolic import Event

__all__ = ["EVENTS", "KINDS", "episode"]

EVENTS = (0, 1, 3, 10)
_TRIES = 400

Maker = Callable[[np.random.Generator], Draft]


def _alternatives(rng: np.random.Generator) -> Draft:
    """A problem with one, two or three further goals, of which any will do; some of them cannot be reached."""
    makers: tuple[Maker, ...] = (coins, cycles, cargo, random_strips, rooms)
    draft = makers[int(rng.integers(len(makers)))](rng)
    goals = draft.goals[0]
    facts = sorted({f for a in draft.domain.actions for f in a.adds})
    alternatives = [goals]
    for _ in range(int(rng.integers(1, 3))):
        chosen = [facts[int(rng.integers(len(facts)))] for _ in range(2)]
        alternatives.append(tuple(dict.fromkeys(chosen)))
    return replace(draft, goals=tuple(dict.fromkeys(alternatives)), expected=None)


KINDS: dict[str, tuple[Maker, str]] = {
    "strips": (random_strips, "random STRIPS without dead ends"),
    "dead-ends": (lambda rng: random_strips(rng, costly=True), "random STRIPS with dead ends"),
    "coins": (coins, "coins that can be spent wrongly"),
    "cargo": (cargo, "pick and place, objects are moved and fall"),
    "obstacles": (lambda rng: cargo(rng, obstacles=True), "the same with things in the way that turn up"),
    "rooms": (rooms, "a household: walking, locations as parameters, obstacles"),
    "threats": (threats, "goals made with one tool at a time that undo each other"),
    "blocks": (blocks, "towers of blocks"),
    "cycles": (cycles, "objects that change places"),
    "negation": (lambda rng: random_strips(rng, negation=True), "negative preconditions and goals"),
    "alternatives": (_alternatives, "goals of which one of several will do"),
}


def episode(kind: str, seed: int, *, events: int = 0, rough: bool = False) -> Episode:
    """The episode of a kind (KeyError for another word). `events` of them are dated; `rough`: actions last a random
    number of ticks and one in ten fails."""
    maker, _ = KINDS[kind]
    rng = np.random.default_rng([crc32(kind.encode()), seed, events, rough])
    for attempt in range(_TRIES):
        draft = maker(rng)
        if satisfied(draft.goals, draft.facts):
            continue
        happening = _dated(rng, draft, events, rough)
        truth = label(draft.domain, draft.facts, draft.goals, happening)
        if truth is None:
            if draft.expected is None:
                continue
        elif not _wanted(kind, seed, truth, draft, last=attempt > _TRIES // 2):
            continue
        solvable = draft.expected if truth is None else truth.solvable
        return Episode(
            kind,
            seed,
            draft.domain,
            draft.facts,
            draft.goals,
            happening,
            (1, 8) if rough else (1, 1),
            0.1 if rough else 0.0,
            solvable,
            truth is not None,
        )
    raise AssertionError(f"no {kind} problem with {events} events among {_TRIES} for seed {seed}")


def _wanted(kind: str, seed: int, truth: Label, draft: Draft, *, last: bool) -> bool:
    """Whether a draft is of its kind: no dead ends in `strips`; three in five of the kinds that have them can be
    solved; nothing that takes only a step or two."""
    if kind == "strips" and (truth.dead_ends or not truth.solvable):
        return False
    if kind in ("dead-ends", "coins") and not truth.dead_ends:
        return False
    far = shortest(draft.domain, draft.facts, draft.goals)
    if far is not None and 0 <= far < (2 if last else 3):
        return False
    if kind in ("dead-ends", "coins", "threats", "negation") and not last:
        return (truth.solvable is True) == (seed % 5 < 3)
    return True


_VARIETY = 4
"""Different events in one episode: few, so that every state can be looked at."""


def _dated(rng: np.random.Generator, draft: Draft, n: int, rough: bool) -> tuple[Event, ...]:
    """Events at random times, as many as are asked for, chosen so that they could happen if all went well until then;
    the same thing may happen several times."""
    if not n or not draft.moves:
        return ()
    way = path(draft.domain, draft.facts, draft.goals) or (draft.facts,)
    pace = 4.5 if rough else 1.0
    end = 4 + int(pace * max(3, len(way) - 1) * (1 if n < 10 else 2))
    dates = sorted(int(t) for t in rng.integers(1, end, n))
    chosen: list[Event] = []
    for date in dates:
        there = way[min(len(way) - 1, max(0, int((date - 3) / pace)))]
        several = len({e.name + e.target + str(e.when) for e in chosen}) < _VARIETY
        pool = [e for e in (draft.moves if several else chosen) if all_hold(e.when, there)] or list(draft.moves[:1])
        chosen.append(replace(pool[int(rng.integers(len(pool)))], tick=0))
    return tuple(replace(e, tick=t) for e, t in zip(chosen, dates, strict=True))
