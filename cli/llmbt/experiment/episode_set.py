"""The sets of episodes that executors are measured on: an open one by its seeds, and one whose seeds nobody knows who
has not the key."""

from __future__ import annotations

import hashlib
import hmac
import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from llmbt_atl.library import Library, parse_library
from llmbt_atl.state import Domain
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span
from llmbt_ir.shipped import shipped
from llmbt_ir.xml import read_bytes
from llmbt_runtime.episodes import EVENTS, KINDS, Episode, episode

__all__ = ["committed", "open_seed", "read_key", "sealed_seed", "set_of"]

CARGO = "cargo_sorting"


def committed() -> dict[str, Any]:
    """What is settled beforehand: how many episodes a cell, the open set's hash, the hash of the sealed set's key."""
    found = json.loads((shipped("experiments") / "benchmark.json").read_bytes())
    assert isinstance(found, dict)
    return found


def read_key(path: Path) -> bytes:
    """The key of the sealed set. E411 where it is not the one whose hash was committed."""
    key = read_bytes(path, "key").strip()
    if hashlib.sha256(key).hexdigest() != committed()["sealed"]["key_sha256"]:
        raise LlmbtError(
            Diagnostic("E411", "this is not the key of the sealed set", Span(str(path)), help="ask the maintainers"),
            exit_code=ExitCode.BAD_INPUT,
        )
    return key


def open_seed(_cell: str, number: int) -> int:
    """The seeds of the open set count from 0."""
    return number


def sealed_seed(key: bytes, cell: str, number: int) -> int:
    """A seed that follows from the key alone."""
    digest = hmac.new(key, f"{cell}/{number}".encode(), hashlib.sha256).digest()
    return int.from_bytes(digest[:4]) % 2**31


def set_of(per_cell: int, key: bytes | None, kinds: tuple[str, ...] = tuple(KINDS)) -> Iterator[Episode]:
    """The episodes: each kind with 0, 1, 3 and 10 events, exact and rough, so many of each; sealed with a key."""
    for kind in kinds:
        for events in EVENTS:
            for rough in (False, True):
                cell = f"{kind}/{events}/{rough}"
                for number in range(per_cell):
                    seed = open_seed(cell, number) if key is None else sealed_seed(key, cell, number)
                    yield _settled(episode(kind, seed, events=events, rough=rough))


def _settled(made: Episode) -> Episode:
    """The episode with the library of the benchmark: what the shipped one of that name learns changes no episode."""
    if made.domain.library.name != CARGO:
        return made
    domain = Domain(_library(), made.domain.types, made.domain.parents)
    return replace(made, domain=domain.for_state(made.facts))


@cache
def _library() -> Library:
    path = shipped("experiments") / "benchmark" / f"{CARGO}.xml"
    return parse_library(path.read_bytes(), str(path))
