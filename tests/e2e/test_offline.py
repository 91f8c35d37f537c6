"""Nothing here reaches the network: a stray request fails, in the suite and in the product."""

from __future__ import annotations

import http.client
import socket
import urllib.request

import pytest

from tests.e2e.conftest import CANONICAL


@pytest.mark.parametrize("host", ["192.0.2.1", "example.org", "2001:db8::1"])
def test_a_stray_connection_fails(host):
    with pytest.raises(OSError, match="a test may not connect"):
        socket.create_connection((host, 80), timeout=1)


def test_a_stray_request_fails():
    with pytest.raises(OSError, match="a test may not connect"):
        urllib.request.urlopen("http://example.org", timeout=1)
    with pytest.raises(OSError, match="a test may not connect"):
        http.client.HTTPSConnection("example.org", timeout=1).request("GET", "/")


def test_a_run_opens_no_socket_at_all(llmbt, tmp_path, monkeypatch):
    """The whole compiler and the symbolic world, with sockets that cannot even be made."""

    def forbidden(*args, **kwargs):
        raise AssertionError("a socket was opened")

    monkeypatch.setattr(socket.socket, "connect", forbidden)
    monkeypatch.setattr(socket, "getaddrinfo", forbidden)
    order = ["--scene", "cargo_sorting", "-o", tmp_path / "out", "--world", "symbolic"]
    assert llmbt("run", CANONICAL, *order).code == 0
