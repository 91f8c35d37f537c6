"""Chance, handed in: the few draws that a world of facts needs, from a seed.

`numpy.random.Generator` is one too; the standard library's generator spares a symbolic run the import of numpy.
"""

from __future__ import annotations

import random
from typing import Protocol

__all__ = ["Chance", "chance"]


class Chance(Protocol):
    """Where random numbers come from."""

    def random(self) -> float:
        """From 0 to 1, 1 excluded."""

    def integers(self, low: int, high: int | None = None) -> int:
        """From `low` to `high`, excluded; from 0 to `low`, excluded, where there is no `high`."""


class _Standard(random.Random):
    def integers(self, low: int, high: int | None = None) -> int:
        return self.randrange(low) if high is None else self.randrange(low, high)


def chance(seed: int, purpose: str) -> Chance:
    """A generator for one purpose: the same seed and purpose give the same numbers, on every machine."""
    return _Standard(f"{seed}/{purpose}")
