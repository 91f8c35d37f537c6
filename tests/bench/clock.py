"""Timing: whole processes over several runs, and where one process spends its time."""

from __future__ import annotations

import functools
import statistics
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Figure:
    """Seconds of wall time over several runs."""

    low: float
    median: float
    high: float
    runs: int

    def __str__(self) -> str:
        return f"{self.median:.2f} s ({self.low:.2f}-{self.high:.2f}, {self.runs} runs)"


def process(command: Sequence[str], runs: int = 5, *, warm: int = 1, code: int = 0) -> Figure:
    """Whole-process wall time of a command that must end with `code`."""
    times = []
    for i in range(runs + warm):
        start = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        elapsed = time.perf_counter() - start
        assert done.returncode == code, (command, done.returncode, done.stderr[-500:])
        if i >= warm:
            times.append(elapsed)
    return Figure(min(times), statistics.median(times), max(times), runs)


def python(code: str, runs: int = 5) -> Figure:
    """Whole-process wall time of a Python program."""
    return process([sys.executable, "-c", code], runs)


@contextmanager
def section(title: str) -> Iterator[None]:
    """A heading and a block of figures, as Markdown."""
    print(f"\n## {title}\n\n```text", flush=True)
    yield
    print("```", flush=True)


@dataclass
class Ledger:
    """Seconds spent in named parts of a program, each second counted once: for the innermost part."""

    spent: Counter[str] = field(default_factory=Counter)
    _stack: list[list[Any]] = field(default_factory=list)

    def wrap(self, owner: Any, name: str, part: str) -> None:
        """Count the time in `owner.name` for `part`."""
        inner: Callable[..., Any] = getattr(owner, name)

        @functools.wraps(inner)
        def timed(*args: Any, **kwargs: Any) -> Any:
            start = time.perf_counter()
            self._stack.append([0.0])
            try:
                return inner(*args, **kwargs)
            finally:
                total = time.perf_counter() - start
                below = self._stack.pop()[0]
                self.spent[part] += total - below
                if self._stack:
                    self._stack[-1][0] += total

        setattr(owner, name, timed)
