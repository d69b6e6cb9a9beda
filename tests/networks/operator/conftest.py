"""Connections to a run, and a run that listens."""

from __future__ import annotations

import json
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.operator.control import Control
from handcart.networks.operator.operation import Operation
from handcart.networks.operator.permits import Permits
from tests.conftest import Clock
from tests.networks.conftest import Stand


class Line:
    """The other end of a line."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.setblocking(False)  # otherwise connecting waits while the queue is full
        self.came = b""

    def connect(self, folder: Path) -> None:
        self.socket.connect(str(folder / "control"))

    def send(self, message: bytes) -> None:
        self.socket.sendall(message)

    def answers(self) -> list[dict[str, Any]]:
        """Return the complete answers so far."""
        while self._more():
            pass
        *whole, self.came = self.came.split(b"\n")
        return [json.loads(item) for item in whole]

    def _more(self) -> bool:
        try:
            new = self.socket.recv(1 << 16)
        except BlockingIOError:
            return False
        self.came += new
        return bool(new)

    @property
    def hung_up(self) -> bool:
        try:
            return self.socket.recv(1) == b""
        except BlockingIOError:
            return False
        except ConnectionResetError:
            return True


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return Path()


@pytest.fixture
def lines(folder: Path) -> Iterator[Callable[[], Line]]:
    """Opens lines; all are closed in the end."""
    opened: list[Line] = []

    def open_one() -> Line:
        opened.append(Line())
        opened[-1].connect(folder)
        return opened[-1]

    yield open_one
    for line in opened:
        line.socket.close()


@pytest.fixture
def run(stand: Stand, folder: Path) -> Iterator[Any]:
    """A run before its first period, that listens."""
    coordinator = Coordinator(stand.network("a z go 1"), stand.robot, stand.model)
    with Operation(folder, coordinator, Permits(), stand.robot) as operation:
        double: Any = operation
        double.coordinator, double.stand = coordinator, stand
        yield double


@pytest.fixture
def control(folder: Path, clock: Clock) -> Iterator[Any]:
    """Answers each message with itself."""
    stops: list[None] = []
    with Control(folder, dict, lambda: stops.append(None), clock) as listening:
        double: Any = listening
        double.stops = stops
        yield double
