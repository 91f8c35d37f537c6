"""Runs that the tests of this folder read: the paper's request with disturbances, in the symbolic world."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt.main import main

REQUEST = "Please sort the cargo by colour: green on shelf level 1, yellow on level 2, red on level 3."


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of runs: `drop` of the first object, and `obstacle_at_place`, which needs a move."""
    folder = tmp_path_factory.mktemp("runs")
    for disturb in ("drop", "obstacle_at_place"):
        arguments = ["run", REQUEST, "--scene", "cargo_sorting", "-o", str(folder / disturb)]
        assert main([*arguments, "--world", "symbolic", "--disturb", disturb, "--seed", "14", "-q"]) == 0
    return folder


@pytest.fixture
def kept() -> Path:
    """The same runs as they were on 22 November 2026, for what is compared to the letter: how trees grow may change."""
    return Path(__file__).parent / "runs"
