"""Access control of the console: rows U1 to U5, U11 and U14 of the faults."""

from __future__ import annotations

import http.client
import logging
import socket
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic, sleep

import orjson
import pytest

from handcart.tools.console import connections, server
from handcart.tools.console.guard import PAGE_POLICY
from handcart.tools.console.server import NoConsole, Server
from tests.tools.conftest import Said
from tests.tools.console.conftest import LIVE, OVER, LiveRun, Served


def test_u1_it_listens_on_this_machine_alone(served: Served) -> None:
    """It listens on both local addresses; another one needs `--host`, and the token as well."""
    assert served.ask("GET", "/").status == 200
    for elsewhere in ("127.0.0.2", socket.gethostbyname(socket.gethostname())):
        if elsewhere != "127.0.0.1":
            with pytest.raises(OSError):
                socket.create_connection((elsewhere, served.server.port), timeout=20).close()


def test_u1_another_address_needs_to_be_asked_for_and_the_token(runs: Path) -> None:
    other = Server(runs, "127.0.0.2", 0)
    assert other.address.startswith(f"http://127.0.0.2:{other.port}/#token=")
    with pytest.raises(NoConsole, match="can't be listened on"):
        Server(runs, "127.0.0.2", other.port)
    other.close()
    for every in ("0.0.0.0", "::", ""):
        with pytest.raises(NoConsole, match="allowed: one address of this machine"):
            Server(runs, every, 0)


@pytest.mark.parametrize("method", ["GET", "POST"])
def test_u2_a_foreign_origin_is_refused_before_any_upgrade(served: Served, method: str) -> None:
    for origin in ("http://evil.example", "null", f"https://{served.host}", "http://127.0.0.1:1"):
        asked = served.ask(method, "/api/lease", {} if method == "POST" else None, Origin=origin)
        assert (asked.status, asked.json["error"]) == (403, "another site asks for this")
        web_socket = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13"}
        assert served.ask("GET", f"/api/runs/{OVER}", Origin=origin, **web_socket).status == 403
    assert served.ask("GET", f"/api/runs/{OVER}", Upgrade="websocket", Connection="Upgrade").status == 403


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1:1", "", "127.0.0.1.evil:{port}"]
)
def test_u3_another_host_s_name_is_refused(served: Served, host: str) -> None:
    """DNS rebinding: the page of another name that leads to this machine."""
    for path in ("/", f"/api/runs/{OVER}"):
        assert served.ask("GET", path, Host=host.format(port=served.server.port)).status == 421


@pytest.mark.parametrize(
    "kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", None]
)
def test_u4_a_form_from_elsewhere_is_refused(live: LiveRun, served: Served, kind: str | None) -> None:
    served.wait_for()
    path = f"/api/runs/{LIVE}/stop"
    assert served.ask("POST", path, b'{"do":"stop"}', Content_Type=kind).status == 403
    assert served.ask("POST", path, {}, Sec_Fetch_Site="cross-site").status == 403
    assert served.ask("POST", path, {}, Authorization=None).status == 401
    assert live.stops == 0


@pytest.mark.parametrize(
    "token", [None, "", "Bearer", "Bearer ", "Bearer wrong", "Basic {token}", "Bearer {token}x"]
)
def test_u5_without_the_token_nothing_is_told(
    live: LiveRun, served: Served, token: str | None, caplog: pytest.LogCaptureFixture
) -> None:
    served.wait_for()
    caplog.set_level(logging.DEBUG)
    given = token and token.format(token=served.token)
    for path in (f"/api/runs/{OVER}", "/api/events", f"/api/runs/{LIVE}/files/evidence/x.png"):
        assert served.ask("GET", path, Authorization=given).status == 401
    assert served.ask("POST", f"/api/runs/{LIVE}/stop", {}, Authorization=given).status == 401
    assert live.stops == 0
    assert served.token not in caplog.text


def test_u5_the_token_is_never_in_what_a_browser_sends_as_address(served: Served) -> None:
    assert served.server.address.count("#token=") == 1
    assert served.ask("GET", f"/?token={served.token}", Authorization=None).status == 200
    assert served.ask("GET", f"/api/runs/{OVER}?token={served.token}", Authorization=None).status == 401


@pytest.mark.parametrize(
    "path", ["/", "/console.js", "/console.css", f"/api/runs/{OVER}", "/api/nothing", "/ticket/x"]
)
def test_every_answer_says_what_may_run_on_the_page(served: Served, path: str) -> None:
    """U10: nothing but what the console itself serves."""
    headers = served.ask("GET", path).headers
    assert headers["Content-Security-Policy"] == PAGE_POLICY
    assert "unsafe" not in PAGE_POLICY
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cache-Control"] == "no-store"


PATHS = [
    "..",
    "%2e%2e",
    "..%2f..%2fetc%2fpasswd",
    "latest",
    "walk-0%00",
    "%2fetc",
    "nothing",
    "walk-0/../walk-0%2f..",
]


@pytest.mark.parametrize("name", PATHS)
def test_u14_only_runs_that_are_listed_have_names(served: Served, name: str) -> None:
    (served.runs / "latest").symlink_to("/etc")
    for rest in ("", "/files/evidence/x.png"):
        assert served.ask("GET", f"/api/runs/{name}{rest}").status in (400, 404)
    assert served.ask("POST", f"/api/runs/{name}/ticket", {"page": "report.html"}).status in (400, 404)


@pytest.mark.parametrize(
    "file",
    [
        "journal.jsonl",
        "evidence/../journal.jsonl",
        "evidence/%2e%2e/journal.jsonl",
        "evidence/..%2fjournal.jsonl",
        "evidence/link.png",
        "evidence/sub/x.png",
        "/etc/passwd",
        "evidence/passwd",
        "evidence/003_MOVE_TO_Fail.npz",
    ],
)
def test_u14_only_pictures_are_files(served: Served, file: str, tmp_path: Path) -> None:
    there, secret = served.runs / OVER / "evidence", tmp_path / "secret.png"
    for item in (secret, there / "passwd", there / "003_MOVE_TO_Fail.npz"):
        item.write_bytes(b"for nobody's eyes")
    (there / "link.png").symlink_to(secret)
    asked = served.ask("GET", f"/api/runs/{OVER}/files/{file}")
    assert asked.status in (403, 404, 409)
    assert b"for nobody's eyes" not in asked.body


def test_u14_nothing_can_be_sent_there(served: Served) -> None:
    before = sorted(path for path in served.runs.rglob("*"))
    for method in ("PUT", "DELETE", "PATCH"):
        assert served.ask(method, f"/api/runs/{OVER}", {}).status == 405
    assert served.ask("POST", f"/api/runs/{OVER}", {"task": "x"}).status == 405
    assert served.ask("POST", f"/api/runs/{OVER}/ticket", {"page": "../secret"}).status == 404
    assert sorted(path for path in served.runs.rglob("*")) == before


def test_a_page_is_opened_once_and_reaches_nothing(served: Served) -> None:
    url = served.ask("POST", f"/api/runs/{OVER}/ticket", {"page": "report.html"}).json
    if not url["ok"] or not (served.runs / OVER / "report.html").exists():
        (served.runs / OVER / "report.html").write_text("<!doctype html><p>report</p>", encoding="utf-8")
        url = served.ask("POST", f"/api/runs/{OVER}/ticket", {"page": "report.html"}).json
    page = served.ask("GET", url["url"], Authorization=None)
    assert page.status == 200
    assert "sandbox" in page.headers["Content-Security-Policy"]
    assert served.ask("GET", url["url"], Authorization=None).status == 403


def test_u11_a_huge_command_is_refused(live: LiveRun, served: Served) -> None:
    served.wait_for()
    served.take()
    assert served.command(do="pause", by="x" * 20_000).status == 413
    assert served.ask("POST", f"/api/runs/{LIVE}/command", b"[" * 5000).status == 400
    assert live.heard == []


@pytest.mark.parametrize("given", ["Authorization", "X-Console-Tab", "Origin", "Host"])
def test_u11_bytes_that_are_no_text_are_refused(served: Served, given: str) -> None:
    """As a tab's identifier such bytes would be sent to all pages, and no page could decode the message."""
    head = {
        "Host": served.host.encode(),
        "Authorization": f"Bearer {served.token}".encode(),
        "X-Console-Tab": b"tab-1",
    }
    head[given] = {"Authorization": b"Bearer "}.get(given, b"") + b"\xff\xfe"
    body = b'{"take":true,"name":"Eve"}'
    lines = [b"POST /api/lease HTTP/1.1", b"Content-Type: application/json", b"Connection: close"]
    lines += [name.encode() + b": " + value for name, value in head.items()]
    lines.append(f"Content-Length: {len(body)}".encode())
    answer = said_by(served, b"\r\n".join(lines) + b"\r\n\r\n" + body)
    assert answer.split()[1] in (b"400", b"401", b"403", b"421")
    assert served.ask("POST", "/api/lease", {"take": True, "name": "Ada"}).json["lease"]["name"] == "Ada"


NONSENSE = {
    "no request": b"\x16\x03\x01\x02\x00 garbage \x00\xff\r\n\r\n",
    "two hosts": b"GET / HTTP/1.1\r\nHost: {host}\r\nHost: evil.example\r\n\r\n",
    "two lengths": b"POST /api/lease HTTP/1.1\r\nHost: {host}\r\nContent-Length: 4\r\n"
    b"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
    "another protocol": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    "endless name": b"GET /" + b"a" * 20_000 + b" HTTP/1.1\r\nHost: {host}\r\n\r\n",
    "not packed so": b"POST /api/lease HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\n"
    b"Content-Type: application/json\r\nContent-Encoding: deflate\r\nContent-Length: 7\r\n"
    b"Connection: close\r\n\r\ngarbage",
}


@pytest.mark.parametrize("sent", NONSENSE.values(), ids=NONSENSE)
def test_u11_nonsense_is_refused_and_prints_nothing(
    served: Served, sent: bytes, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture
) -> None:
    """Without this, requests from outside could fill the operator's terminal with tracebacks."""
    named = sent.replace(b"{host}", served.host.encode()).replace(b"{token}", served.token.encode())
    assert said_by(served, named).split()[1] == b"400"
    assert served.ask("GET", "/").status == 200
    printed = capfd.readouterr()
    assert printed.out + printed.err + caplog.text == ""


@pytest.mark.usefixtures("few")
def test_u11_a_stop_arrives_beside_a_hostile_crowd(
    live: LiveRun, served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before each stop, more sockets that ask half a question than are kept; the places are taken by them."""
    monkeypatch.setattr(connections, "MOST_UNKNOWN", 100)
    served.wait_for(f"/api/runs/{LIVE}")
    crowd: deque[socket.socket] = deque()
    for _ in range(10):
        for _ in range(120):
            line = socket.create_connection(("127.0.0.1", served.server.port), timeout=20)
            crowd.append(line)
            with suppress(OSError):
                line.sendall(b"GET")
        begun = monotonic()
        assert served.ask("POST", f"/api/runs/{LIVE}/stop", {}).status == 200
        assert monotonic() - begun < 1.0
        while len(crowd) > 100:
            crowd.popleft().close()
    for line in crowd:
        line.close()
    assert live.stops


@pytest.mark.slow
@pytest.mark.usefixtures("few")
def test_u11_a_page_with_the_token_is_kept_in_a_crowd(served: Served) -> None:
    line = http.client.HTTPConnection("127.0.0.1", served.server.port, timeout=20)
    headers = {"Authorization": f"Bearer {served.token}", "Host": served.host}
    line.request("GET", "/api/events", headers=headers)
    answer = line.getresponse()
    assert answer.status == 200
    many = [socket.create_connection(("127.0.0.1", served.server.port), timeout=20) for _ in range(60)]
    _until_closed(40, many)
    for _ in range(2):  # it gets a message every two seconds
        assert orjson.loads(answer.readline())["runs"]
    line.close()


def said_by(served: Served, sent: bytes) -> bytes:
    """All that comes back until the line is closed."""
    answer = b""
    with socket.create_connection(("127.0.0.1", served.server.port), timeout=20) as line:
        line.sendall(sent)
        while got := line.recv(65_536):
            answer += got
    return answer


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """A console that lets in 20, and waits for them."""
    monkeypatch.setattr(connections, "MOST_UNKNOWN", 20)
    monkeypatch.setattr(connections, "SILENT_S", 300.0)
    monkeypatch.setattr(server, "KEPT_S", 300.0)


@pytest.mark.usefixtures("few")
def test_u11_of_a_crowd_that_comes_at_once_few_are_let_in(served: Served) -> None:
    """They are counted when they are connected, not when they knock."""
    many = []
    for _ in range(100):
        line = socket.create_connection(("127.0.0.1", served.server.port), timeout=20)
        with suppress(OSError):
            line.sendall(b"GET / HTTP/1.1\r\nHost: ")
        many.append(line)
    _until_closed(80, many)
    assert served.ask("GET", "/").status == 200


@pytest.mark.usefixtures("few")
def test_u11_who_says_nothing_is_hung_up_on(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    """Slow heads, too; and of very many connections the first ones."""
    monkeypatch.setattr(connections, "SILENT_S", 0.3)
    slow = [socket.create_connection(("127.0.0.1", served.server.port), timeout=20) for _ in range(10)]
    for item in slow:
        item.sendall(b"GET / HTTP/1.1\r\nHost: ")
    for item in slow:
        with item, suppress(ConnectionResetError):
            assert item.recv(100) == b""
    monkeypatch.setattr(connections, "SILENT_S", 30.0)
    many = [socket.create_connection(("127.0.0.1", served.server.port), timeout=20) for _ in range(60)]
    _until_closed(40, many)
    assert served.ask("GET", "/").status == 200


def _until_closed(count: int, many: Sequence[socket.socket]) -> None:
    """Until so many of them are hung up on; then hang up on the others."""
    for socket_ in many:
        socket_.setblocking(False)
    end = monotonic() + 20.0
    while sum(_closed(socket_) for socket_ in many) < count:
        assert monotonic() < end
        sleep(0.05)
    for socket_ in many:
        socket_.close()


def _closed(line: socket.socket) -> bool:
    try:
        return line.recv(1) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True


@pytest.mark.slow
def test_what_cannot_be_is_told_in_words(handcart: Callable[..., Said], tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        said = handcart("console", tmp_path, "--port", taken.getsockname()[1])
    assert (said.status, said.out) == (2, "")
    assert "can't be listened on: Address already in use; allowed: a free one, or 0 for any" in said.err
    said = handcart("console", tmp_path, "--host", "no.such.host.invalid")
    assert said.status == 2
    assert "can't be listened on" in said.err
