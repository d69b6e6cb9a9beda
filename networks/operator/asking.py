"""Messages to a run that is alive in another process, and the reason if it does not answer."""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import stat
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import orjson

from handcart.files.errors import HandcartError, InputError
from handcart.files.printable import clipped, printable
from handcart.networks.journal.journal_record import JournalError, read_journal
from handcart.networks.run_files.socket_path import CONTROL_SOCKET, STOP_SOCKET, socket_path

ANSWER_TIMEOUT_S = 5.0
LONGEST_ANSWER = 65_536  # [bytes]
_PAUSE = 0.02  # [s] between two tries
_JOURNAL = "journal.jsonl"


class NotAlive(InputError):
    """Error, because no program is running the run of a folder, so that nothing answers a command."""


class ClosedToYou(InputError):
    """Error: a folder of runs, or the run in it, belongs to another user of the computer."""


class NotAnswering(HandcartError):
    """Error, because a run in a folder is alive but does not answer its operator; its state is unknown."""


def ask(folder: Path, message: Mapping[str, Any], patience: float = ANSWER_TIMEOUT_S) -> dict[str, Any]:
    """Send a message to the run that is alive in a folder, and return its answer.

    Args:
        folder: folder of the run.
        message: command with its arguments, such as `{"do": "status"}`.
        patience: maximum time to wait for the answer, in [s].

    Raises:
        NotAlive: no run is alive there.
        ClosedToYou: the folder may not be used.
        NotAnswering: the run is alive, but did not answer within `patience` [s].
    """
    end = time.monotonic() + patience
    try:
        answer = _answer(folder, orjson.dumps(message) + b"\n", end)
    except TimeoutError:
        raise _unanswered(folder, f"within {patience:g} s") from None
    except OSError as error:
        raise _unreached(folder, error) from None
    try:
        reply = orjson.loads(answer)
    except orjson.JSONDecodeError:
        reply = None
    if not isinstance(reply, dict) or "ok" not in reply:
        raise NotAnswering(f"the answer in {folder} is not that of a run: {printable(clipped(repr(answer)))}")
    return reply


def tell_to_stop(folder: Path) -> None:
    """Ask the program that executes the run in a folder to stop the robot at once; do not wait for the end.

    Raises:
        NotAlive: no run is alive there.
        ClosedToYou: the folder may not be used.
        NotAnswering: the run is alive, but its socket cannot be reached.
    """
    try:
        with (
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as line,
            socket_path(folder / STOP_SOCKET) as name,
        ):
            line.setblocking(False)
            line.sendto(b"stop", name)
    except BlockingIOError:
        pass  # the socket's queue is full of the same request, so the run will read one
    except OSError as error:
        raise _unreached(folder, error) from None


def goes_on(folder: Path) -> bool:
    """Return whether a run is still going on in a folder, because a process has its journal open for writing.

    Raises:
        OSError: the journal cannot be opened.
    """
    journal = os.open(folder / _JOURNAL, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | os.O_NOFOLLOW)
    try:
        if not stat.S_ISREG(os.fstat(journal).st_mode):
            raise OSError(errno.EINVAL, "it is not a file")
        fcntl.flock(journal, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(journal)
    return False


def _answer(folder: Path, message: bytes, end: float) -> bytes:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as line:
        _connect(line, folder, end)
        line.settimeout(_left(end))
        line.sendall(message)
        answer = b""
        while not answer.endswith(b"\n") and len(answer) < LONGEST_ANSWER:
            line.settimeout(_left(end))
            new = line.recv(LONGEST_ANSWER)
            if not new:
                raise ConnectionResetError
            answer += new
    return answer


def _connect(line: socket.socket, folder: Path, end: float) -> None:
    """Connect; wait for a place in the socket's queue if many clients connect."""
    with socket_path(folder / CONTROL_SOCKET) as name:
        while True:
            line.settimeout(_left(end))
            try:
                return line.connect(name)
            except BlockingIOError:
                time.sleep(min(_PAUSE, _left(end)))


def _left(end: float) -> float:
    left = end - time.monotonic()
    if left <= 0.0:
        raise TimeoutError
    return left


def _unanswered(folder: Path, when: str) -> HandcartError:
    how = f"handcart stop {folder} stops it all the same"
    return NotAnswering(f"the run in {folder} is alive, but doesn't answer {when}; {how}")


def _unreached(folder: Path, error: OSError) -> HandcartError:
    """Return the most specific error for a run that could not be reached."""
    if isinstance(error, PermissionError):
        return _closed(folder, error)
    if not folder.is_dir():
        what = f"{folder} is not a folder" if folder.exists() else f"there is no folder {folder}"
        return NotAlive(f"no run is alive there: {what}; allowed: the folder of a running run")
    try:
        if goes_on(folder):
            return _unanswered(folder, f"({error.strerror or 'it hung up'}): it begins, or comes to its end")
        records = read_journal(folder / _JOURNAL).records
    except PermissionError as closed:
        return _closed(folder, closed)
    except (OSError, JournalError):
        said = f"no run is alive in {folder}: no journal can be read there"
        return NotAlive(f"{said}; allowed: the folder of a running run")
    if records and records[-1]["kind"] == "END":
        how = f"{records[-1].get('outcome')} in situation {records[-1].get('situation')}"
        return NotAlive(printable(f"no run is alive in {folder}: it is over, {how}"))
    return NotAlive(f"no run is alive in {folder}: it broke off; handcart resume {folder} continues it")


def _closed(folder: Path, error: OSError) -> ClosedToYou:
    return ClosedToYou(f"{folder} is closed to you: {error.strerror}; allowed: the user who started the run")
