"""A served console, over a folder with a run that is over and one that seems to be running."""

from __future__ import annotations

import http.client
import shutil
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import orjson
import pytest

pytest.importorskip("aiohttp", reason="the extra console isn't installed")

from benchmarks.campaigns.walk import walk
from handcart.evaluation.trials.running import run_task
from handcart.networks.operator.control import Control, Message
from handcart.networks.runs.run_options import RunOptions
from handcart.tools.console.server import Server

OVER, LIVE = "walk-0", "walk-1"


@pytest.fixture(scope="session")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run of two actions that reached its goal."""
    folder = tmp_path_factory.mktemp("console")
    summary, status = run_task(walk(folder), folder / "runs", RunOptions())
    assert status == 0
    return Path(summary["run_dir"])


class LiveRun:
    """Answers on a run's sockets, and keeps what it heard."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.heard: list[Message] = []
        self.stops = 0
        self.status: dict[str, Any] = {
            "state": "waiting for permission",
            "situation": "at_home",
            "actions": [],
            "sim_time_s": 1.5,
            "asks": {"index": 0, "do": "MOVE_TO", "from": "at_home", "to": "between", "with": {}, "ask": 1},
            "step": False,
            "breaks": [],
            "commands": [],
        }
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._listen)

    def __enter__(self) -> LiveRun:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _listen(self) -> None:
        with Control(self.folder, self._answer, self._stop) as control:
            while not self._over.is_set():
                control.poll(0.01)

    def _stop(self) -> None:
        self.stops += 1

    def _answer(self, message: Message) -> dict[str, Any]:
        if message["do"] != "status":
            self.heard.append(message)
            said = {
                "number": len(self.heard),
                "do": message["do"],
                "by": message.get("by"),
                "sim_time_s": 2.0,
            }
            self.status["commands"] = [*self.status["commands"], said]
        if message["do"] == "break":
            breaks = {*self.status["breaks"], message["at"]} if message["on"] else set()
            self.status["breaks"] = sorted(breaks)
        return {"ok": True, **self.status}


@dataclass
class Reply:
    """Answer of a console."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return orjson.loads(self.body)


@dataclass
class Served:
    """A console, and how to ask it."""

    server: Server
    runs: Path
    end: Callable[[], object]
    """Ends the server."""
    tab: str = "tab-1"

    @property
    def token(self) -> str:
        return self.server.address.partition("#token=")[2]

    @property
    def host(self) -> str:
        return f"127.0.0.1:{self.server.port}"

    def ask(self, method: str, path: str, content: Any = None, **headers: str | None) -> Reply:
        """With the page's own headers, unless others are given; None: without that one."""
        usual = {"Authorization": f"Bearer {self.token}", "X-Console-Tab": self.tab, "Host": self.host}
        if content is not None:
            usual["Content-Type"] = "application/json"
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        sent = {name: value for name, value in {**usual, **named}.items() if value is not None}
        line = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=20)
        try:
            body = (
                orjson.dumps(content) if content is not None and not isinstance(content, bytes) else content
            )
            line.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            for name, value in sent.items():
                line.putheader(name, value)
            line.putheader("Content-Length", str(len(body or b"")))
            line.endheaders(body)
            answer = line.getresponse()
            return Reply(answer.status, dict(answer.headers), answer.read())
        finally:
            line.close()

    def command(self, run: str = LIVE, **message: Any) -> Reply:
        """Say something to a run."""
        return self.ask("POST", f"/api/runs/{run}/command", message)

    def take(self, name: str = "Ada") -> None:
        """Have the command."""
        assert self.ask("POST", "/api/lease", {"take": True, "name": name}).status == 200

    def wait_for(self, path: str = f"/api/runs/{LIVE}") -> None:
        """Until the watcher has seen a run."""
        end = monotonic() + 20.0
        while self.ask("GET", path).status == 404:
            assert monotonic() < end
            sleep(0.05)


@pytest.fixture
def runs(ran: Path, tmp_path: Path) -> Path:
    """A folder with a run that is over."""
    shutil.copytree(ran, tmp_path / "runs" / OVER)
    return tmp_path / "runs"


@pytest.fixture
def live(ran: Path, runs: Path) -> Iterator[LiveRun]:
    """Yield a run that seems to be running: its journal has no end yet."""
    folder = runs / LIVE
    shutil.copytree(ran, folder, ignore=shutil.ignore_patterns("summary.json", "report.html"))
    lines = (folder / "journal.jsonl").read_bytes().splitlines(keepends=True)
    begun = next(number for number, line in enumerate(lines) if b'"kind":"START"' in line)
    (folder / "journal.jsonl").write_bytes(b"".join(lines[:begun]))
    with LiveRun(folder) as run:
        yield run


@pytest.fixture
def served(runs: Path) -> Iterator[Served]:
    """The console over that folder."""
    over = threading.Event()
    server = Server(runs, None, 0)
    thread = threading.Thread(target=server.serve, args=(over.is_set,))
    thread.start()
    try:

        def end() -> None:
            over.set()
            thread.join()

        found = Served(server, runs, end)
        found.wait_for(f"/api/runs/{OVER}")
        yield found
    finally:
        over.set()
        thread.join()
