"""Going back to the start of a trial: what the physics holds and what Python holds, restored together.

Bullet's saved state has positions, velocities and contacts, not what motors were asked for, and knows nothing of ours.
"""

from __future__ import annotations

from typing import Any

__all__ = ["Memory"]


class Memory:
    """Remembers the attributes of objects, containers copied one level deep; what they refer to is shared."""

    def __init__(self, *objects: object) -> None:
        self._saved = [(o, {k: _copied(v) for k, v in vars(o).items()}) for o in objects]

    def recall(self) -> None:
        """Give every object the attributes that it had."""
        for o, attributes in self._saved:
            vars(o).update((k, _copied(v)) for k, v in attributes.items())


def _copied(value: Any) -> Any:
    return value.copy() if isinstance(value, (dict, list, set)) else value
