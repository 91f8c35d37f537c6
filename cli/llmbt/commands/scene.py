"""`llmbt scene`: scenes, and what their cameras see."""

from __future__ import annotations

import click

from llmbt.commands.scene_clouds import capture, map_

__all__ = ["scene"]


@click.group()
def scene() -> None:
    """Scenes, and what their cameras see."""


scene.add_command(capture)
scene.add_command(map_)
