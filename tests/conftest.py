"""Shared fixtures. The suite cannot reach the network, and hypothesis repeats itself."""

from __future__ import annotations

import ipaddress
import os
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

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


class StrayRequestError(OSError):
    """A test tried to leave this machine."""


def _refuse_elsewhere(address: Any) -> None:
    host = address[0] if isinstance(address, tuple) else "127.0.0.1"  # a unix socket's address is a path
    try:
        local = ipaddress.ip_address(host).is_loopback
    except ValueError:
        local = host in ("localhost", "")
    if not local:
        raise StrayRequestError(f"a test may not connect to {host}")


@pytest.fixture(autouse=True, scope="session")
def _no_network() -> Iterator[None]:
    """Only the loopback can be connected to, and no other name is looked up."""
    patch = pytest.MonkeyPatch()
    connect, connect_ex, look_up = socket.socket.connect, socket.socket.connect_ex, socket.getaddrinfo

    def guarded(inner: Callable[..., Any]) -> Callable[..., Any]:
        def call(self: socket.socket, address: Any) -> Any:
            _refuse_elsewhere(address)
            return inner(self, address)

        return call

    def guarded_look_up(host: Any, *args: Any, **kwargs: Any) -> Any:
        _refuse_elsewhere((host.decode() if isinstance(host, bytes) else host or "",))
        return look_up(host, *args, **kwargs)

    patch.setattr(socket.socket, "connect", guarded(connect))
    patch.setattr(socket.socket, "connect_ex", guarded(connect_ex))
    patch.setattr(socket, "getaddrinfo", guarded_look_up)
    yield
    patch.undo()


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
