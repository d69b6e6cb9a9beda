"""The operator's connection to a run that is alive: two sockets in the run's folder."""

from __future__ import annotations

import os
import selectors
import socket
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import orjson

from handcart.files.errors import InputError
from handcart.networks.run_files.socket_path import CONTROL_SOCKET, STOP_SOCKET, socket_path

from .asking import NotAlive as NotAlive
from .asking import ask as ask
from .control_line import MAX_MESSAGE_BYTES, ControlLine

MAX_CONNECTIONS = 64
MOST_NEW = 16  # maximum requests read in a period
SILENCE_TIMEOUT_S = 60.0  # after which an idle connection is closed

Message = Mapping[str, Any]
Answer = Callable[[Message], Message]


class Control:
    """Server of commands to a run, on two Unix sockets in its folder that only their owner can use.

    They are polled once a period. On the socket `control`, a message is a line with a JSON object, such as
    `{"do": "status"}`. Each message gets an answer in one line, invalid ones included, and each connection
    at most one answer a period. A connection that hangs up, sends half a line or floods does not affect the
    others. When there are too many connections, the one that was silent longest is closed.

    On the socket `control.stop`, any datagram stops the run; it gets no answer.

    It is a context manager, which removes the sockets at its end.
    """

    def __init__(
        self,
        folder: Path,
        answer: Answer,
        stop: Callable[[], object],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Listen on the sockets in a run's folder.

        Args:
            folder: the run's folder.
            answer: called with each message, returns the answer.
            stop: stops the run.
            clock: clock for connections, in [s].

        Raises:
            InputError: the folder cannot hold a socket.
        """
        self._answer, self._stop, self._clock = answer, stop, clock
        self._lines: dict[socket.socket, ControlLine] = {}
        self._paths = (folder / CONTROL_SOCKET, folder / STOP_SOCKET)
        self._selector = selectors.DefaultSelector()
        self._listening = _bound(self._paths[0], socket.SOCK_STREAM)
        try:
            self._stopping = _bound(self._paths[1], socket.SOCK_DGRAM)
        except InputError:
            self._listening.close()
            raise
        self._listening.listen(MAX_CONNECTIONS)
        self._selector.register(self._listening, selectors.EVENT_READ)
        self._selector.register(self._stopping, selectors.EVENT_READ)

    def poll(self, patience: float = 0.0) -> None:
        """Answer the commands that were received since the last call.

        Args:
            patience: time to wait for a command if there is none, in [s] of the wall clock.
        """
        busy = any(line.waits for line in self._lines.values())
        ready = [key.fileobj for key, _ in self._selector.select(0.0 if busy else patience)]
        if self._stopping in ready:
            self._hear_stop()
        if self._listening in ready:
            self._take()
        now = self._clock()
        for line in list(self._lines.values()):
            self._serve(line, now)

    def close(self) -> None:
        """Close all connections; a second call does nothing."""
        for line in list(self._lines.values()):
            self._drop(line)
        self._selector.close()
        for item, path in zip((self._listening, self._stopping), self._paths, strict=True):
            item.close()
            path.unlink(missing_ok=True)

    def __enter__(self) -> Control:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _hear_stop(self) -> None:
        self._stop()
        with suppress(OSError):
            for _ in range(MAX_CONNECTIONS):
                self._stopping.recv(1)

    def _take(self) -> None:
        for _ in range(MOST_NEW):
            try:
                other, _address = self._listening.accept()
            except OSError:  # no more of them, or no descriptor left for one
                return
            if len(self._lines) >= MAX_CONNECTIONS:
                self._drop(min(self._lines.values(), key=lambda line: line.moved))
            line = ControlLine(other, self._clock())
            self._lines[other] = line
            self._selector.register(other, line.interest)

    def _serve(self, line: ControlLine, now: float) -> None:
        line.exchange(now)
        if line.waits:
            line.answer(self._reply(line.message()), now)
        if line.over or now - line.moved > SILENCE_TIMEOUT_S:
            self._drop(line)
        else:
            self._selector.modify(line.socket, line.interest)

    def _reply(self, message: bytes | None) -> bytes:
        if message is None:
            return _refusal(f"a message of more than {MAX_MESSAGE_BYTES} bytes")
        try:
            request = orjson.loads(message)
        except orjson.JSONDecodeError as error:
            return _refusal(f"this is not JSON ({error})")
        if not isinstance(request, dict):
            return _refusal("this is not a JSON object")
        try:
            return orjson.dumps(self._answer(request))
        except Exception as error:  # a fault of a request must not end the run
            return orjson.dumps(
                {"ok": False, "error": f"a fault in handcart: {type(error).__name__}: {error}"}
            )

    def _drop(self, line: ControlLine) -> None:
        self._selector.unregister(line.socket)
        del self._lines[line.socket]
        line.socket.close()


def _refusal(wrong: str) -> bytes:
    allowed = 'an object in a line of at most 4096 bytes, such as {"do": "status"}'
    return orjson.dumps({"ok": False, "error": f"{wrong}; allowed: {allowed}"})


def _bound(path: Path, kind: socket.SocketKind) -> socket.socket:
    """Return a socket that hears what is sent to `path`; one that a killed run left there is removed."""
    listening = socket.socket(socket.AF_UNIX, kind)
    listening.setblocking(False)
    before = os.umask(0o177)
    try:
        path.unlink(missing_ok=True)  # this process owns the journal, so no other one listens there
        with socket_path(path) as name:
            listening.bind(name)
    except OSError as error:
        listening.close()
        raise InputError(f"{path} can't be made: {error.strerror}") from None
    finally:
        os.umask(before)
    return listening
