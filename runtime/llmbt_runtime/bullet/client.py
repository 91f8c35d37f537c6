"""A quiet connection to pybullet: it prints to C's stdout on import and on connecting, where only JSON may go."""

from __future__ import annotations

import ctypes
import functools
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

__all__ = ["BulletClient", "quiet_stdout"]


@contextmanager
def quiet_stdout() -> Iterator[None]:
    """C's stdout and stderr lead nowhere inside; what Python and C have buffered is flushed where it belongs."""
    flush = ctypes.CDLL(None).fflush
    saved: list[tuple[int, int]] = []
    for stream, fd in ((sys.stdout, 1), (sys.stderr, 2)):
        if stream is not None and not stream.closed:
            stream.flush()
        with suppress(OSError):  # the descriptor is closed
            saved.append((fd, os.dup(fd)))
    flush(None)
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        for fd, _ in saved:
            os.dup2(null, fd)
        yield
    finally:
        flush(None)
        for fd, copy in saved:
            os.dup2(copy, fd)
            os.close(copy)
        os.close(null)


with quiet_stdout():
    import pybullet
    import pybullet_data

PhysicsError: type[Exception] = pybullet.error
"""What pybullet raises, as when its server is gone."""

DATA_PATH: str = pybullet_data.getDataPath()


class BulletClient:
    """One physics server. Every function of pybullet is a method that knows its server; constants are attributes.

    Close it: a server never disconnected costs 29 MB.
    """

    def __init__(self, *, window: bool = False) -> None:
        with quiet_stdout():
            self.id: int = pybullet.connect(pybullet.GUI if window else pybullet.DIRECT)

    def __getattr__(self, name: str) -> Any:
        value = getattr(pybullet, name)
        if callable(value):
            value = functools.partial(value, physicsClientId=self.id)
        setattr(self, name, value)
        return value

    def close(self) -> None:
        """Disconnect; a second call does nothing."""
        if self.id >= 0:
            with quiet_stdout():
                pybullet.disconnect(self.id)
            self.id = -1
