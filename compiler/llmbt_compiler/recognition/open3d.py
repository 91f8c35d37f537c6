"""Open3D, imported when it is first needed. Its wheel wants the system's libusb; a package of that name stands in."""

from __future__ import annotations

import ctypes
import os
from functools import cache
from typing import Any

from llmbt_ir.diagnostics import Diagnostic, LlmbtError

__all__ = ["SEED", "open3d"]

SEED = 0
"""Of Open3D's own chance, set anew before each use of it, so that the same cloud gives the same map."""


@cache
def open3d() -> Any:
    """The module; E450 where it cannot be loaded, with how to mend it."""
    os.environ.setdefault("OMP_NUM_THREADS", "1")  # with more, RANSAC's draws come in another order each time
    try:
        import libusb_package

        ctypes.CDLL(str(libusb_package.get_library_path()), ctypes.RTLD_GLOBAL)
        import open3d as module
    except (ImportError, OSError) as fault:
        raise LlmbtError(Diagnostic("E450", f"Open3D cannot be loaded: {fault}", help="see `llmbt doctor`")) from None
    module.utility.set_verbosity_level(module.utility.VerbosityLevel.Error)
    return module
