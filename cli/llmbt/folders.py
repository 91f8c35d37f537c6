"""The folder a command writes into."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span

__all__ = ["fresh_folder"]

OURS = ("map.xml", "library.xml", "result.json", "plan.json", "capture.json")
"""What a run or an experiment of ours leaves behind even where it ends early."""


def fresh_folder(path: Path, *, force: bool) -> Path:
    """An empty folder to write into; missing parents are made. E010 (exit 2) where it cannot be written into, or holds
    something, unless forced.

    Forcing empties a folder that a run of ours has filled, and refuses any other.
    """
    if path.exists() and not path.is_dir():
        raise LlmbtError(Diagnostic("E010", f"`{path}` is a file", Span(str(path))), exit_code=ExitCode.USAGE)
    if path.is_dir() and any(path.iterdir()):
        ours = any(path.glob("tree.v*.xml")) or any((path / n).exists() for n in OURS)
        if not force or not ours:
            hint = "give another folder, or --force to replace what a run left in it"
            raise LlmbtError(
                Diagnostic("E010", f"the folder `{path}` is not empty", Span(str(path)), help=hint),
                exit_code=ExitCode.USAGE,
            )
        shutil.rmtree(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except OSError as fault:
        title = f"cannot write into `{path}`: {fault.strerror or fault}"
        raise LlmbtError(Diagnostic("E010", title, Span(str(path))), exit_code=ExitCode.USAGE) from None
    return path
