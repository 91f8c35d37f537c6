"""A phrase of a request, and what it may mean."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Meant"]


@dataclass(frozen=True, slots=True)
class Meant:
    """A phrase, words[start:end], and all the things that it fits. `count`: of how many of them it speaks (0: of all);
    `exactly`: it says that there are no more ("both", "all three"); `stop`: where a clause ends that tells more of it
    ("that's on the shelf"), or 0; `vague`: of how many it speaks is not said ("a few of the greens")."""

    start: int
    end: int
    ids: tuple[str, ...]
    count: int = 1
    exactly: bool = False
    stop: int = 0
    vague: bool = False

    @property
    def many(self) -> bool:
        """Whether it speaks of several things."""
        return self.count != 1
