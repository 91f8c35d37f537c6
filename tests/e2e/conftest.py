"""The command line as a user meets it, in this process: exit code, stdout, stderr."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from llmbt.main import main

CANONICAL = "Please sort the cargo by colour: green on shelf level 1, yellow on level 2, red on level 3."


@dataclass(frozen=True)
class Answer:
    """What a command answered."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> dict[str, Any]:
        """The one document of --json."""
        found = json.loads(self.out)
        assert isinstance(found, dict)
        return found


@pytest.fixture
def llmbt(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[..., Answer]:
    """Run `llmbt ARGUMENTS`; a traceback anywhere fails the test."""
    monkeypatch.delenv("LLMBT_CASSETTES", raising=False)
    monkeypatch.setenv("NO_COLOR", "1")

    def run(*arguments: str | Path) -> Answer:
        capfd.readouterr()
        code = main([str(a) for a in arguments])
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err, err
        return Answer(code, out, err)

    return run
