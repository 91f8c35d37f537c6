"""Episodes as JSON, one a line: everything that a referee needs, so that a set of them stays what it is, whatever
becomes of the generator (docs/benchmark.md has the format)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from llmbt_atl.library import parse_library
from llmbt_atl.pddl.write import write_library
from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import Condition, Facts, Goals, parse_condition
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
from llmbt_runtime.episodes.model import Episode
from llmbt_runtime.symbolic import Event

__all__ = ["FORMAT", "actions_json", "episode_id", "read_episodes", "write_episode"]

FORMAT = 1


def episode_id(episode: Episode) -> str:
    """Its name: kind, seed, events, and whether actions last and fail."""
    rough = "rough" if episode.failure_rate else "exact"
    return f"{episode.kind}.{episode.seed}.{len(episode.events)}.{rough}"


def write_episode(episode: Episode) -> str:
    """One line of JSON, without the line's end. The same episode gives the same text."""
    domain = episode.domain
    document = {
        "format": FORMAT,
        "id": episode_id(episode),
        "kind": episode.kind,
        "seed": episode.seed,
        "library": write_library(domain.library).decode(),
        "things": dict(sorted(domain.types.items())),
        "within": dict(sorted(domain.parents.items())),
        "facts": _texts(episode.facts),
        "goals": [list(map(str, alternative)) for alternative in episode.goals],
        "ticks": list(episode.ticks),
        "failure_rate": episode.failure_rate,
        "events": [
            {
                "tick": e.tick,
                "when": list(map(str, e.when)),
                "removes": _texts(e.removes),
                "adds": _texts(e.adds),
                "name": e.name,
                "target": e.target,
            }
            for e in episode.events
        ],
        "solvable": episode.solvable,
        "verified": episode.verified,
    }
    return json.dumps(document, ensure_ascii=False, separators=(",", ":"))


def read_episodes(data: bytes, source: str) -> tuple[Episode, ...]:
    """The episodes of a file. E410 with the line where one is none, or is of another format."""
    found = []
    for number, line in enumerate(data.splitlines(), 1):
        if not line.strip():
            continue
        try:
            found.append(_episode(json.loads(line)))
        except (ValueError, KeyError, TypeError) as fault:
            title = f"not an episode of format {FORMAT}: {fault}"
            raise LlmbtError(Diagnostic("E410", title, Span(source, number))) from None
    return tuple(found)


def actions_json(actions: Iterable[GroundAction]) -> dict[str, dict[str, list[str]]]:
    """Actions for somebody who knows nothing of libraries: what has to hold when one starts, what all the while, and
    exactly what holds and no longer holds afterwards."""
    return {
        str(a): {
            "start": list(map(str, a.start)),
            "hold": list(map(str, a.hold)),
            "adds": _texts(a.adds),
            "deletes": _texts(a.deletes),
        }
        for a in actions
    }


def _texts(facts: Facts) -> list[str]:
    return [str(f) for f in sorted(facts)]


def _episode(raw: Mapping[str, Any]) -> Episode:
    if raw["format"] != FORMAT:
        raise ValueError(f"format {raw['format']}")
    facts = frozenset(_conditions(raw["facts"]))
    library = parse_library(str(raw["library"]).encode(), f"{raw['id']}: library")
    domain = Domain(library, dict(raw["things"]), dict(raw["within"])).for_state(facts)
    goals: Goals = tuple(_conditions(alternative) for alternative in raw["goals"])
    low, high = raw["ticks"]
    events = tuple(
        Event(
            int(e["tick"]),
            frozenset(_conditions(e["removes"])),
            frozenset(_conditions(e["adds"])),
            _conditions(e["when"]),
            str(e["name"]),
            str(e["target"]),
        )
        for e in raw["events"]
    )
    solvable = raw["solvable"]
    return Episode(
        str(raw["kind"]),
        int(raw["seed"]),
        domain,
        facts,
        goals,
        events,
        (int(low), int(high)),
        float(raw["failure_rate"]),
        None if solvable is None else bool(solvable),
        bool(raw["verified"]),
    )


def _conditions(texts: Iterable[str]) -> tuple[Condition, ...]:
    found = []
    for text in texts:
        condition = parse_condition(text)
        if condition is None:
            raise ValueError(f"no condition: {text}")
        found.append(condition)
    return tuple(found)
