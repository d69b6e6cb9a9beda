"""Ports that the console's server binds and releases."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from handcart.tools.console import server as module
from handcart.tools.console.server import PORT, NoConsole, Server


def can_be_had(host: str, port: int) -> bool:
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as tried:
        tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            tried.bind((host, port))
        except OSError:
            return False
    return True


def test_a_port_that_one_address_lacks_is_let_go_of_on_the_other(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET6) as taken:
        taken.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        taken.bind(("::1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(NoConsole, match=f"port {port} of 127.0.0.1 can't be listened on: .*in use"):
            Server(tmp_path, None, port)
        assert can_be_had("127.0.0.1", port)


def test_both_addresses_have_the_same_port_until_it_is_closed(tmp_path: Path) -> None:
    server = Server(tmp_path, None, 0)
    hosts = ("127.0.0.1", "::1")
    assert not any(can_be_had(host, server.port) for host in hosts)
    server.close()
    server.close()
    assert all(can_be_had(host, server.port) for host in hosts)


def test_without_a_port_the_next_free_one_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[int]()

    def opened(host: str, port: int) -> socket.socket:
        asked.append(port)
        if port < PORT + 2:
            raise OSError(98, "in use")
        return socket.socket()

    monkeypatch.setattr(module, "_opened", opened)
    with pytest.raises(NoConsole, match=r"port 7 .*can't be listened on: in use"):
        Server(tmp_path, "127.0.0.1", 7)
    asked.clear()
    sockets = module._sockets(("127.0.0.1",), None)
    assert asked == [8090, 8091, 8092]
    for socket_ in sockets:
        socket_.close()
    monkeypatch.setattr(module, "TRIES", 2)
    with pytest.raises(NoConsole, match="any port from 8090 to 8091 of 127"):
        Server(tmp_path, "127.0.0.1", None)
