"""A run as a film, and in a window: both look at snapshots in a client of their own, and change nothing."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError
from llmbt_ir.scene import Camera, Scene
from llmbt_runtime.bullet.camera import DEFAULT_CAMERA, Renderer, Snapshot, Window

if TYPE_CHECKING:
    from llmbt_runtime.bullet.world import BulletWorld

__all__ = ["Film", "Viewer", "can_write"]

_EVERY_S, _FASTER = 0.4, 2.0
"""A picture for so much simulated time, shown so many times faster."""
_WIDTH, _HEIGHT = 480, 320
_KINDS = (".gif", ".mp4")


def can_write(path: Path) -> None:
    """E067 where a film of this kind cannot be written here."""
    kind = path.suffix.lower()
    if kind not in _KINDS:
        hint = "name it .gif, or .mp4 with the extra `video`"
        fault = Diagnostic("E067", f"`{path}` is neither a .gif nor an .mp4", help=hint)
        raise LlmbtError(fault, exit_code=ExitCode.USAGE)
    if kind == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError:
            hint = "pip install 'llm-bt[video]', or write a .gif"
            raise LlmbtError(
                Diagnostic("E067", "no encoder for MP4 is installed", help=hint), exit_code=ExitCode.USAGE
            ) from None


class Film:
    """Takes snapshots while a world goes on, and draws them afterwards."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._taken: list[Snapshot] = []
        self._due_s = 0.0

    def take(self, world: BulletWorld) -> None:
        """Look at the world; to be called after every tick."""
        if world.time_s >= self._due_s:
            self._taken.append(world.snapshot())
            self._due_s = world.time_s + _EVERY_S

    def __len__(self) -> int:
        return len(self._taken)

    def frames(self, camera: Camera | None = None) -> Iterator[NDArray[np.uint8]]:
        """The pictures, height x width x 3, in order."""
        renderer = Renderer(self._scene)
        seen = camera or next(iter(self._scene.cameras), DEFAULT_CAMERA)
        try:
            for snapshot in self._taken:
                yield renderer.draw(snapshot, seen, _WIDTH, _HEIGHT)
        finally:
            renderer.close()

    def write(self, path: Path, camera: Camera | None = None) -> None:
        """Write the film, by the ending of its name. E067 as `can_write`."""
        can_write(path)
        per_second = _FASTER / _EVERY_S
        if path.suffix.lower() == ".mp4":
            import imageio.v3

            imageio.v3.imwrite(path, list(self.frames(camera)), fps=per_second, macro_block_size=16)
            return
        from PIL import Image

        pictures = [Image.fromarray(f).quantize(64) for f in self.frames(camera)]
        first, *rest = pictures
        first.save(path, save_all=True, append_images=rest, duration=round(1000 / per_second), loop=0)


class Viewer:
    """Bullet's window, showing a world as it goes on. E068 where there is no screen."""

    def __init__(self, scene: Scene) -> None:
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            hint = "without one, --picture and --video FILE show a run"
            raise LlmbtError(Diagnostic("E068", "there is no screen for --gui", help=hint), exit_code=ExitCode.USAGE)
        self._window = Window(scene)

    def take(self, world: BulletWorld) -> None:
        """Show the world; to be called after every tick."""
        self._window.show(world.snapshot())

    def close(self) -> None:
        """Close the window."""
        self._window.close()
