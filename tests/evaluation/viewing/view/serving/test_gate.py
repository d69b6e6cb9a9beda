"""Access to the three-dimensional page of a run, tried by foreign clients: rows U1 to U3, U5, U10 and U11."""

from __future__ import annotations

import gc
import logging
import socket
import time
import warnings
from collections.abc import Iterator
from contextlib import closing, nullcontext, suppress

import pytest

pytest.importorskip("viser", reason="the extra view isn't installed")

import viser
from websockets.asyncio import server as library
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

from handcart.evaluation.viewing.view.serving.gate import Gate
from handcart.evaluation.viewing.view.serving.server import LOOPBACK_HOST, NoView, Opened, open_server

SECRET = "what only the operator sees"
OURS = f"viser-v{viser.__version__}"


@pytest.fixture
def opened() -> Iterator[Opened]:
    with open_server(0, SECRET) as server:
        yield server


def token_of(opened: Opened) -> str:
    return opened.address.partition("#token=")[2]


def port_of(opened: Opened) -> int:
    return int(opened.server.get_port())


def entered(opened: Opened, *, token: str | None, origin: str | None, host: str = "") -> ClientConnection:
    """A raw socket as a program that calls itself viser's page."""
    protocols = [OURS] if token is None else [OURS, f"token.{token}"]
    name, _, port = (host or f"{LOOPBACK_HOST}:{port_of(opened)}").partition(":")
    return connect(
        f"ws://{name}:{port}/" if port else f"ws://{name}/",
        sock=socket.create_connection((LOOPBACK_HOST, port_of(opened)), timeout=20),
        origin=origin,  # type: ignore[arg-type]
        subprotocols=[Subprotocol(protocol) for protocol in protocols],
        open_timeout=20,
        max_size=None,
        proxy=None,
    )


def refused(opened: Opened, **given: str | None) -> int:
    with pytest.raises(InvalidStatus) as caught:
        entered(opened, **given).close()  # type: ignore[arg-type]
    return int(caught.value.response.status_code)


def page_of(opened: Opened, **headers: str) -> bytes:
    """All that comes back when the page is asked for, until the line is closed."""
    lines = [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
    return said_by(opened, "\r\n".join(["GET / HTTP/1.1", *lines, "", ""]).encode())


def said_by(opened: Opened, sent: bytes) -> bytes:
    answer = b""
    with socket.create_connection((LOOPBACK_HOST, port_of(opened)), timeout=20) as line:
        line.sendall(sent)
        with suppress(ConnectionResetError):
            while got := line.recv(65_536):
                answer += got
    return answer


def test_who_has_the_token_sees_the_run(opened: Opened) -> None:
    own = f"http://{LOOPBACK_HOST}:{port_of(opened)}"
    with closing(entered(opened, token=token_of(opened), origin=own)) as line:
        assert line.subprotocol == OURS
        assert line.recv(timeout=20)


def test_u1_it_listens_on_this_machine_s_one_address(opened: Opened) -> None:
    """A server that listens on all addresses would be reached through another loopback address as well."""
    socket.create_connection((LOOPBACK_HOST, port_of(opened)), timeout=20).close()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", port_of(opened)), timeout=20)


def test_u2_a_foreign_origin_gets_no_socket(opened: Opened) -> None:
    """The token does not help; browsers always send the origin, so a request without one is not from a
    page.
    """
    for origin in (
        "http://evil.example",
        "null",
        f"https://{LOOPBACK_HOST}:{port_of(opened)}",
        f"http://{LOOPBACK_HOST}:1",
        None,
    ):
        assert refused(opened, token=token_of(opened), origin=origin) == 403


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1:1", "localhost:{port}", "127.0.0.1.evil:{port}"])
def test_u3_another_host_s_name_is_refused(opened: Opened, host: str) -> None:
    """DNS rebinding: the page of another name that leads to this machine, and its socket."""
    named = host.format(port=port_of(opened))
    assert refused(opened, token=token_of(opened), origin=f"http://{named}", host=named) == 421
    assert page_of(opened, Host=named).split()[1] == b"421"


def test_u3_two_hosts_are_none(opened: Opened) -> None:
    own = f"{LOOPBACK_HOST}:{port_of(opened)}"
    sent = f"GET / HTTP/1.1\r\nHost: {own}\r\nHost: evil.example\r\n\r\n"
    assert said_by(opened, sent.encode()).split()[1] in (b"400", b"421")


@pytest.mark.parametrize("token", [None, "", "wrong", "{token}x", "token.{token}"])
def test_u5_without_the_token_there_is_no_socket(opened: Opened, token: str | None) -> None:
    """Other people on this machine can forge all the rest."""
    given = token and token.format(token=token_of(opened))
    own = f"http://{LOOPBACK_HOST}:{port_of(opened)}"
    if given == "":
        answer = page_of(
            opened,
            Host=f"{LOOPBACK_HOST}:{port_of(opened)}",
            Origin=own,
            Connection="Upgrade",
            Upgrade="websocket",
            Sec_WebSocket_Version="13",
            Sec_WebSocket_Key="AAAAAAAAAAAAAAAAAAAAAA==",
            Sec_WebSocket_Protocol=f"{OURS}, token.",
        )
        assert answer.split()[1] == b"401"
    else:
        assert refused(opened, token=given, origin=own) == 401


def test_u5_the_token_is_neither_in_addresses_nor_in_pages_nor_logged(
    opened: Opened, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    caplog.set_level(logging.DEBUG)
    assert opened.address.startswith(f"http://{LOOPBACK_HOST}:{port_of(opened)}/#token=")
    page = page_of(opened, Host=f"{LOOPBACK_HOST}:{port_of(opened)}")
    assert page.split()[1] == b"200"
    assert token_of(opened).encode() not in page
    own = f"http://{LOOPBACK_HOST}:{port_of(opened)}"
    entered(opened, token=token_of(opened), origin=own).close()
    refused(opened, token=token_of(opened), origin="http://evil.example")
    heard = capfd.readouterr()
    logged = [
        record.getMessage() for record in caplog.records if record.name != "websockets.client"
    ]  # that is us
    assert token_of(opened) not in " ".join(logged) + heard.out + heard.err


def test_the_page_may_reach_nothing_else_and_is_in_no_frame(opened: Opened) -> None:
    """U10: also what would get into it could send nothing away."""
    head, _, page = page_of(opened, Host=f"{LOOPBACK_HOST}:{port_of(opened)}").partition(b"\r\n\r\n")
    policy = next(line for line in head.decode().split("\r\n") if line.startswith("Content-Security-Policy"))
    assert "default-src 'self'" in policy
    assert f"connect-src 'self' ws://{LOOPBACK_HOST}:{port_of(opened)} data: blob:;" in policy
    assert "frame-ancestors 'none'" in policy
    assert "*" not in policy
    assert b"<head><script>// Runs before viser's own script" in page
    assert f"Content-Length: {len(page)}" in head.decode()


def test_the_console_may_lead_there(opened: Opened) -> None:
    """Its page is another site; a socket from there is refused."""
    own = f"{LOOPBACK_HOST}:{port_of(opened)}"
    assert page_of(opened, Host=own, Sec_Fetch_Site="same-site").split()[1] == b"200"
    upgrade = {"Upgrade": "websocket", "Connection": "Upgrade", "Origin": f"http://{own}"}
    assert page_of(opened, Host=own, Sec_Fetch_Site="same-site", **upgrade).split()[1] == b"403"


NONSENSE = {
    "no request": b"\x16\x03\x01\x02\x00 garbage \x00\xff\r\n\r\n",
    "a form": b"POST / HTTP/1.1\r\nHost: {host}\r\nContent-Length: 4\r\n\r\nab=c",
    "another protocol": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    "endless name": b"GET /" + b"a" * 20_000 + b" HTTP/1.1\r\nHost: {host}\r\n\r\n",
    "no text": b"GET / HTTP/1.1\r\nHost: {host}\r\nOrigin: \xff\xfe\r\n\r\n",
    "another folder": b"GET /..%2f..%2f..%2fetc/passwd HTTP/1.1\r\nHost: {host}\r\n\r\n",
}


@pytest.mark.parametrize("sent", NONSENSE.values(), ids=NONSENSE)
def test_u11_nonsense_is_refused_and_prints_nothing(
    opened: Opened, sent: bytes, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    own = f"{LOOPBACK_HOST}:{port_of(opened)}"
    assert said_by(opened, sent.replace(b"{host}", own.encode()))[:13].split()[1:2] != [b"200"]
    assert page_of(opened, Host=own).split()[1] == b"200"
    heard = capfd.readouterr()
    assert heard.out + heard.err + caplog.text == ""


def test_a_library_that_lets_nobody_guard_it_serves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its server is made from elsewhere, say, in another version."""
    monkeypatch.setattr(Gate, "before_servers", lambda self: nullcontext())
    with pytest.raises(NoView, match="can't be guarded against strangers"), open_server(0, "test"):
        pass


def test_other_servers_of_this_process_keep_their_library() -> None:
    own = library.serve
    with Gate(LOOPBACK_HOST).before_servers():
        assert library.serve is own


def test_no_socket_is_left_open_that_comes_while_the_server_ends() -> None:
    """Its end, and three that say nothing, wait for the loop at the same time."""
    with open_server(0, SECRET) as opened:
        inside = opened.server._websock_server
        loop, ends = inside._background_event_loop, inside._stop_event
        assert loop is not None
        assert ends is not None
        loop.call_soon_threadsafe(time.sleep, 0.1)
        loop.call_soon_threadsafe(ends.set)
        lines = [socket.create_connection((LOOPBACK_HOST, port_of(opened)), timeout=20) for _ in range(3)]
        begun = time.monotonic()
    thread = inside._server_thread
    assert thread is not None
    assert not thread.is_alive()
    assert time.monotonic() - begun < 5.0
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        del opened, inside, loop, ends
        gc.collect()
    assert not [str(item.message) for item in caught if item.category is ResourceWarning]
    for line in lines:
        with line, suppress(ConnectionResetError):
            assert line.recv(1) == b""


def test_other_servers_are_made_as_always(opened: Opened) -> None:
    assert library.serve.__module__ == "websockets.asyncio.server"
