"""The operator's line to a run that is alive: a socket in the run's folder."""

from __future__ import annotations

import os
import selectors
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import orjson

from files.errors import InputError

NAME = "control"
LONGEST = 4096  # of a message [bytes]
MOST = 8  # who may be connected at once
PATIENCE = 5.0  # [s] that the other end gets for an answer

Message = Mapping[str, Any]
Answer = Callable[[Message], Message]


class NotAlive(InputError):
    """No run listens in that folder."""


class Control:
    """Listens on `FOLDER/control`, a Unix socket that only its owner may use; asked once a period, no thread.

    A message is a JSON object in a line, such as `{"do": "stop"}`; each gets one back, in a line. Whoever
    hangs up changes nothing. A context manager: leaving it removes the socket.
    """

    def __init__(self, folder: Path, answer: Answer) -> None:
        """Listen; `answer` is called with each message, and gives what is sent back.

        Raises:
            InputError: the folder can't hold a socket.
        """
        self._path, self._answer = folder / NAME, answer
        self._waiting: dict[socket.socket, bytes] = {}
        self._selector = selectors.DefaultSelector()
        self._listening = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._listening.setblocking(False)
        before = os.umask(0o177)
        try:
            self._path.unlink(missing_ok=True)  # of a run that was killed: its journal is ours now
            with _short(self._path) as path:
                self._listening.bind(path)
        except OSError as error:
            raise InputError(f"{self._path} can't be made: {error.strerror}") from None
        finally:
            os.umask(before)
        self._listening.listen(MOST)
        self._selector.register(self._listening, selectors.EVENT_READ)

    def poll(self, patience: float = 0.0) -> None:
        """Answer what has come in; with `patience`, in [s] of the wall clock, wait so long for the first."""
        for key, _ in self._selector.select(patience):
            if key.fileobj is self._listening:
                self._accept()
            else:
                self._read(key.fileobj)  # type: ignore[arg-type]

    def close(self) -> None:
        """Hang up; a second call does nothing."""
        for each in list(self._waiting):
            self._drop(each)
        self._selector.close()
        self._listening.close()
        self._path.unlink(missing_ok=True)

    def __enter__(self) -> Control:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _accept(self) -> None:
        try:
            other, _ = self._listening.accept()
        except OSError:
            return
        if len(self._waiting) >= MOST:
            other.close()
            return
        other.setblocking(False)
        self._waiting[other] = b""
        self._selector.register(other, selectors.EVENT_READ)

    def _read(self, other: socket.socket) -> None:
        try:
            new = other.recv(LONGEST)
        except OSError:
            new = b""
        *lines, rest = (self._waiting[other] + new).split(b"\n")
        if not new or len(rest) >= LONGEST:
            self._drop(other)
            return
        self._waiting[other] = rest
        for line in lines:
            try:
                other.send(orjson.dumps(self._reply(line)) + b"\n")
            except OSError:
                self._drop(other)
                return

    def _reply(self, line: bytes) -> Message:
        try:
            message = orjson.loads(line)
        except orjson.JSONDecodeError:
            message = None
        if not isinstance(message, dict):
            return {"ok": False, "error": 'no JSON object; allowed: {"do": "status"} and so on'}
        return self._answer(message)

    def _drop(self, other: socket.socket) -> None:
        self._selector.unregister(other)
        self._waiting.pop(other, None)
        other.close()


def ask(folder: Path, message: Message, patience: float = PATIENCE) -> dict[str, Any]:
    """Send a message to the run that is alive in a folder; its answer.

    Raises:
        NotAlive: nobody listens there, or nobody answered within `patience` [s].
    """
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as line:
        line.settimeout(patience)
        try:
            with _short(folder / NAME) as path:
                line.connect(path)
            line.sendall(orjson.dumps(message) + b"\n")
            answer = b""
            while not answer.endswith(b"\n"):
                new = line.recv(LONGEST)
                if not new:
                    raise NotAlive(f"the run in {folder} hung up before it answered")
                answer += new
        except TimeoutError:
            raise NotAlive(f"the run in {folder} doesn't answer within {patience:g} s") from None
        except OSError:
            raise NotAlive(f"no run is alive in {folder}; allowed: the folder of one that goes on") from None
    told: dict[str, Any] = orjson.loads(answer)
    return told


@contextmanager
def _short(path: Path) -> Iterator[str]:
    """A name of at most 108 bytes for a socket's path, which may be longer."""
    folder = os.open(path.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)
