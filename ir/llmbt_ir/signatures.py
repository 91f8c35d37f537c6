"""The names of leaves and their ports: what a reader needs to tell a condition from an action."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["Signatures"]


@dataclass(frozen=True, slots=True)
class Signatures:
    """Parameter names, in order, of every condition and every action."""

    conditions: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    actions: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
