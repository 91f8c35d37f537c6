"""Looking at a physical run while it goes on: a film of it, Bullet's window."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError
from llmbt_runtime.world import World

if TYPE_CHECKING:
    from llmbt.progress import Progress
    from llmbt_runtime.bullet.world import BulletWorld

__all__ = ["check_watchers", "watched"]


def check_watchers(video: Path | None, gui: bool, world: str) -> None:
    """E067, E068 before anything runs: a film that cannot be written, no screen, nothing to be seen."""
    if video is None and not gui:
        return
    if world != "bullet":
        hint = "a world of facts shows nothing: --world bullet"
        raise LlmbtError(Diagnostic("E067", "there is nothing to film", help=hint), exit_code=ExitCode.USAGE)
    if video is not None:
        from llmbt_runtime.bullet.filming import can_write

        can_write(video)


@contextmanager
def watched(world: World, video: Path | None, gui: bool, progress: Progress) -> Iterator[None]:
    """Watch a world for as long as the context lasts; the film is written at its end."""
    if video is None and not gui:
        yield
        return
    from llmbt_runtime.bullet.filming import Film, Viewer
    from llmbt_runtime.bullet.world import BulletWorld

    assert isinstance(world, BulletWorld)
    viewer = Viewer(world.scene) if gui else None
    film = Film(world.scene) if video is not None else None

    def look(at: BulletWorld) -> None:
        for watcher in (film, viewer):
            if watcher is not None:
                watcher.take(at)

    world.watch = look
    try:
        yield
    finally:
        if viewer is not None:
            viewer.close()
    if film is not None and video is not None:
        progress.line(f"drawing {len(film)} pictures into {video}")
        film.write(video)
