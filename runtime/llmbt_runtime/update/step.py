"""One edit of a tree and why it was made."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Step"]


@dataclass(frozen=True, slots=True)
class Step:
    """One edit and why: what a version's record lists. Of the alternatives the first `at_once` could have started in
    the state in which the tree failed; the others need other actions before them."""

    kind: str
    node: str
    condition: str
    action: str = ""
    alternatives: tuple[str, ...] = ()
    at_once: int = 0
    before: str = ""
    reason: str = ""

    def told(self) -> str:
        """The edit in one line."""
        if self.kind == "move":
            return f"moved up: {self.reason}"
        if self.kind in ("expand", "re-expand"):
            return f"{self.condition} <- {self.action}"
        return f"{self.kind}: {self.reason}"
