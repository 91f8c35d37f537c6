"""The user at the terminal: questions are put, goals are confirmed; where nobody is there, nothing waits."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import click

from llmbt.compilation import not_confirmed
from llmbt_compiler.asking import Asked

__all__ = ["confirmation", "consultation"]

_SHOWN = 20


def _there() -> bool:
    return sys.stdin.isatty() and sys.stderr.isatty()


def _safe(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text)


def consultation(*, quiet: bool) -> Callable[[Asked], str | None]:
    """Asks on a terminal; None (and so exit code 5) where there is none, or no answer."""

    def consult(asked: Asked) -> str | None:
        if quiet or not _there():
            return None
        click.echo(f"? {_safe(asked.text)}", err=True)
        for candidate in asked.candidates[:_SHOWN]:
            click.echo(f"    {_safe(candidate)}", err=True)
        if len(asked.candidates) > _SHOWN:
            click.echo(f"    and {len(asked.candidates) - _SHOWN} more", err=True)
        return _line("answer (nothing to leave it open): ") or None

    return consult


def confirmation(*, wanted: bool, yes: bool, quiet: bool) -> Callable[[Sequence[str]], None]:
    """Says the goals back in plain words and goes on if they are confirmed: by --yes, or at the terminal. E145."""

    def confirm(outcomes: Sequence[str]) -> None:
        if not wanted:
            return
        for line in outcomes:
            click.echo(f"  {_safe(line)}", err=True)
        if yes:
            return
        if quiet or not _there():
            raise not_confirmed(outcomes, "nobody is there to be asked")
        if _line("is this what is wanted? [y/N] ").lower() not in {"y", "yes"}:
            raise not_confirmed(outcomes, "the answer was no")

    return confirm


def _line(prompt: str) -> str:
    click.echo(prompt, err=True, nl=False)
    try:
        return sys.stdin.readline().strip()
    except UnicodeDecodeError:
        return ""
