"""One edit of a tree and why it was made."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Step"]


@dataclass(frozen=True, slots=True)
class Step:
    """One edit and why: what a version's record lists."""

    kind: str
    node: str
    condition: str
    action: str = ""
    alternatives: tuple[str, ...] = ()
    before: str = ""
    reason: str = ""

    def told(self) -> str:
        """The edit in one line."""
        if self.kind == "move":
            return f"moved up: {self.reason}"
        if self.kind in ("expand", "re-expand"):
            return f"{self.condition} <- {self.action}"
        return f"{self.kind}: {self.reason}"
