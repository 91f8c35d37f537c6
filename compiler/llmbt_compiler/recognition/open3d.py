"""Open3D, imported when it is first needed. Its wheel wants the system's libusb; a package of that name stands in."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from llmbt_ir.diagnostics import Diagnostic, LlmbtError

__all__ = ["SEED", "open3d"]

SEED = 0
"""Of Open3D's own chance, set anew before each use of it, so that the same cloud gives the same map."""


@cache
def open3d() -> Any:
    """The module, at work on one thread; E450 where it cannot be loaded, with how to mend it.

    Sums over several threads differ in their last bits from run to run, and ICP makes more of that: a cylinder's turn
    about its axis is free, so two runs ended a hundredth of a millimetre apart.
    """
    try:
        import libusb_package

        ctypes.CDLL(str(libusb_package.get_library_path()), ctypes.RTLD_GLOBAL)
        with _one_core():
            import open3d as module
    except (ImportError, OSError) as fault:
        raise LlmbtError(Diagnostic("E450", f"Open3D cannot be loaded: {fault}", help="see `llmbt doctor`")) from None
    module.utility.set_verbosity_level(module.utility.VerbosityLevel.Error)
    return module


@contextmanager
def _one_core() -> Iterator[None]:
    """Open3D has no setting for its threads: its TBB takes, when loaded, one for each core it may use."""
    if not hasattr(os, "sched_setaffinity"):  # pragma: no cover
        yield
        return
    process = os.getpid()
    cores = os.sched_getaffinity(process)
    os.sched_setaffinity(process, {min(cores)})
    try:
        yield
    finally:
        os.sched_setaffinity(process, cores)
