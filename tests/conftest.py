"""Shared fixtures. The suite cannot reach the network, and hypothesis repeats itself."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "ours",
    max_examples=50,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
)
settings.register_profile("explore", parent=settings.get_profile("ours"), derandomize=False, max_examples=1_000)
settings.load_profile(os.environ.get("LLMBT_HYPOTHESIS", "ours"))


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[[str, str], None]:
    """`golden(name, text)` compares with golden/name beside the test; LLMBT_UPDATE_GOLDEN=1 writes it instead."""
    folder = Path(request.path).parent / "golden"

    def check(name: str, text: str) -> None:
        path = folder / name
        if os.environ.get("LLMBT_UPDATE_GOLDEN"):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        assert path.is_file(), f"no golden file {path}: run with LLMBT_UPDATE_GOLDEN=1 and look at what it writes"
        assert text == path.read_text(encoding="utf-8"), f"differs from {path}; LLMBT_UPDATE_GOLDEN=1 rewrites it"

    return check
