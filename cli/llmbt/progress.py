"""What a person sees while a command works: one line for each stage, action, update and disturbance, on stderr."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from llmbt_runtime.outcome import Happening

if TYPE_CHECKING:
    from llmbt_compiler.keywords.train import Progress as TrainingProgress

__all__ = ["Progress", "training_bar"]

MAX_EDITS = 12
STYLES = {
    "started": ("dim", "  "),
    "ended": ("", "  "),
    "update": ("bold cyan", "^ "),
    "disturbance": ("bold yellow", "! "),
    "deviation": ("yellow", "~ "),
    "outcome": ("bold", "= "),
}


class Progress:
    """Writes the story of a run; silent where it is told to be."""

    def __init__(self, *, quiet: bool) -> None:
        self._print: Callable[..., None] | None = None
        if not quiet:
            self._print = _styled() if sys.stderr.isatty() else _plain

    def stage(self, name: str, text: str) -> None:
        """A stage of the compiler has finished."""
        if self._print is not None:
            self._print(f"{name:>9}  {text}", markup=False)

    def tell(self, happening: Happening) -> None:
        """A line of the execution's story."""
        if self._print is None or happening.kind == "started":
            return
        style, mark = STYLES.get(happening.kind, ("", "  "))
        if happening.kind == "ended" and happening.details.get("result") != "SUCCESS":
            style = "red"
        self._print(f"{happening.time_s:7.1f} s  {mark}{happening.text}", style=style or None, markup=False)
        edits = happening.details.get("edits", ())
        for edit in edits[:MAX_EDITS]:
            self._print(f"{'':12}  {edit}", style="cyan", markup=False)
        if len(edits) > MAX_EDITS:
            self._print(f"{'':12}  and {len(edits) - MAX_EDITS} more", style="cyan", markup=False)

    def line(self, text: str) -> None:
        """Any other line."""
        if self._print is not None:
            self._print(text, markup=False)


def _styled() -> Callable[..., None]:
    from rich.console import Console

    return Console(file=sys.stderr, highlight=False, soft_wrap=True).print


def _plain(text: str, **_: object) -> None:
    """A line of a log that nobody looks at in colour: without the import of what draws it."""
    print(text, file=sys.stderr, flush=True)


@contextmanager
def training_bar(*, quiet: bool) -> Iterator[Callable[[TrainingProgress], None]]:
    """A bar over the batches of each stage of a training, with the loss and, after an epoch, the figures outside."""
    if quiet:
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import Progress as Bar
    from rich.progress import TaskID

    with Bar(console=Console(file=sys.stderr)) as bar:
        tasks: dict[str, TaskID] = {}

        def show(at: TrainingProgress) -> None:
            where = f"{at.stage}, epoch {at.epoch}" if at.stage else f"epoch {at.epoch}"
            if at.stage not in tasks:
                tasks[at.stage] = bar.add_task(where, total=at.total)
            if at.dev is not None:
                bar.console.print(f"{where}: F1 outside {at.dev.scores.f1:.3f}")
            bar.update(tasks[at.stage], completed=at.done, total=at.total, description=f"{where}, loss {at.loss:.3f}")

        yield show
