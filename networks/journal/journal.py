"""The journal: one JSON line for everything decided, written before it is acted on."""

from __future__ import annotations

import errno
import fcntl
import math
import os
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import orjson
from pydantic import BaseModel

from handcart.files.errors import InputError
from handcart.files.printable import printable
from handcart.files.whole_file import sync_folder

from .journal_record import FIRST_CHECKSUM, JournalContents, JournalError, seal
from .syncing import DiskSync, Sync

JOURNAL_SCHEMA = "handcart-journal/2"

_FLAGS = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC | os.O_NOFOLLOW
_AGAIN = os.O_WRONLY | os.O_APPEND | os.O_CLOEXEC | os.O_NOFOLLOW
_OPTIONS = orjson.OPT_SERIALIZE_NUMPY
_NOTHING: Mapping[str, Any] = {}


class RunAlive(InputError):
    """Error, because a run cannot be resumed while it is still running."""

    def __init__(self, folder: Path) -> None:
        how = f"wait for its end, or handcart stop {folder}"
        super().__init__(
            printable(f"the run in {folder} is alive: another process writes it; allowed: {how}")
        )


class Journal:
    """Writer of a run's journal, a file with one line for each record.

    Each record contains the checksum of the record before it, so that later changes are detected. After a
    record that could not be written completely, every further one raises `JournalError`. Times of the wall
    clock are kept under the key `wall`, outside these checksums, so that two runs with one seed have equal
    checksums. It is a context manager, which closes the file at its end.
    """

    _time_s, _rounded_s = math.nan, math.nan
    """Time of the last record, and the same as it is written, in [s]."""

    def __init__(self, path: Path, sync: Sync = "never", clock: Callable[[], float] = time.time) -> None:
        """Create `path`, which must not exist, readable by its owner alone.

        Args:
            path: the journal.
            sync: when records are forced onto the disk.
            clock: source of the wall clock, in [s] since 1970.

        Raises:
            JournalError: it cannot be created, or is locked by another process.
        """
        self.path, self._name = path, str(path)
        self._clock = clock
        self._next = 0
        self._last = FIRST_CHECKSUM
        self._poisoned: str | None = None
        try:
            self._file = os.open(path, _FLAGS, 0o600)
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._note_identity()
            sync_folder(path.parent)
        except OSError as error:
            raise JournalError(path, f"can't be created: {error.strerror}") from None
        self._size = 0
        self._disk = None if sync == "never" else DiskSync(self._file, sync)

    @classmethod
    def go_on(
        cls,
        path: Path,
        contents: JournalContents,
        sync: Sync = "never",
        clock: Callable[[], float] = time.time,
    ) -> Journal:
        """Open an existing journal to append records, after it was read.

        An incomplete last record is moved into the file `PATH.torn-OFFSET`.

        Args:
            path: the journal.
            contents: its records read so far.
            sync: when records are forced onto the disk.
            clock: source of the wall clock, in [s] since 1970.

        Raises:
            JournalError: it cannot be opened, or has changed since it was read.
            RunAlive: another process writes it.
        """
        self = cls.__new__(cls)
        self.path, self._name = path, str(path)
        self._clock, self._poisoned = clock, None
        self._next = len(contents.records)
        self._last = contents.records[-1]["h"] if contents.records else FIRST_CHECKSUM
        try:
            self._file = os.open(path, _AGAIN)
        except OSError as error:
            raise JournalError(path, f"can't be opened: {error.strerror}") from None
        try:
            _lock(self._file, path.parent)
            self._note_identity()
            if os.fstat(self._file).st_size != contents.size:
                raise JournalError(path, "has changed since it was read")
            if contents.torn_at is not None:
                self._quarantine(contents.torn_at)
        except OSError as error:
            os.close(self._file)
            raise JournalError(path, f"can't be continued: {error.strerror}") from None
        except (JournalError, RunAlive):
            os.close(self._file)
            raise
        self._size = os.fstat(self._file).st_size
        self._disk = None if sync == "never" else DiskSync(self._file, sync)
        return self

    def _quarantine(self, offset: int) -> None:
        """Move an incomplete last record into a file next to the journal."""
        torn = self.path.with_name(f"{self.path.name}.torn-{offset}")
        torn.unlink(missing_ok=True)  # of a resume that didn't come to cut it off
        with os.fdopen(os.open(torn, _FLAGS, 0o600), "wb") as kept:
            kept.write(self.path.read_bytes()[offset:])
        os.ftruncate(self._file, offset)
        os.fsync(self._file)

    def append(
        self,
        kind: str,
        time_s: float,
        fields: Mapping[str, Any],
        wall: Mapping[str, Any] = _NOTHING,
        is_followed: bool = False,
    ) -> int:
        """Write one record.

        On return the operating system has it, so that it survives a crash of the program. It survives a power
        cut once it is on the disk (`durable`).

        Args:
            kind: kind of the record, such as RUN, PLAN, START or RESULT.
            time_s: the robot's time, in [s].
            fields: the other fields: JSON values, numpy arrays, paths and models.
            wall: further fields that differ between runs of one seed, kept outside the chain of checksums.
            is_followed: True if nothing is acted on before another record is written. Whether the file was
                replaced is then checked with that record alone.

        Returns:
            The record's number, from 0.

        Raises:
            JournalError: the disk is full, the file is gone, or an earlier record could not be written.
        """
        if self._poisoned:
            raise JournalError(self.path, self._poisoned)
        number = self._next
        try:
            if time_s != self._time_s:
                self._time_s, self._rounded_s = time_s, round(time_s, 6)
            record = {"q": number, "p": self._last, "t": self._rounded_s, "kind": kind, **fields}
            body = orjson.dumps(record, _plain, _OPTIONS)
        except TypeError as error:
            raise self._poison(f"record {number} ({kind}) is not valid JSON: {error}") from None
        # `round(..., 6)` takes several times as long for numbers of this size.
        unix_s = round(self._clock() * 1e6) / 1e6
        when = orjson.dumps({"unix_s": unix_s, **wall})[:-1] if wall else b'{"unix_s":' + orjson.dumps(unix_s)
        line, checksum = seal(body, when)
        try:
            if not is_followed:
                self._check_not_replaced()
            size = len(line)
            if os.write(self._file, line) != size:
                self._write_again(line)
            if self._disk is not None:
                self._disk.ask()
        except OSError as error:
            raise self._poison(f"can't be written: {error.strerror}") from None
        self._size += size
        self._next, self._last = number + 1, checksum
        return number

    @property
    def last(self) -> str:
        """Checksum of the record that was written last; empty before the first."""
        return self._last

    @property
    def durable(self) -> bool:
        """True if all records are on the disk, as far as the journal's setting `sync` demands it.

        With the setting `never` it is always True. With `beside`, another thread writes the records to the
        disk, so that it becomes True with a short delay.

        Raises:
            JournalError: the records cannot be brought to the disk; every further record raises it, too.
        """
        try:
            return self._disk is None or self._disk.done
        except OSError as error:
            raise self._poison(f"can't be written: {error.strerror}") from None

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        if self._file >= 0:
            if self._disk is not None:
                self._disk.close()
            os.close(self._file)
            self._file = -1

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _note_identity(self) -> None:
        """Keep device and inode of the file, by which it is recognized later."""
        stat = os.fstat(self._file)
        self._device, self._inode = stat.st_dev, stat.st_ino

    def _check_not_replaced(self) -> None:
        """Raise `JournalError` if another file has the journal's name now, `OSError` if none has."""
        stat = os.stat(self._name)
        if stat.st_ino != self._inode or stat.st_dev != self._device:
            raise self._poison("was replaced while it was written")

    def _write_again(self, line: bytes) -> None:
        """Write a record once more, of which only a part was written."""
        # Left as it is, the torn record would end up inside.
        os.ftruncate(self._file, self._size)
        if os.write(self._file, line) != len(line):
            os.ftruncate(self._file, self._size)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def _poison(self, reason: str) -> JournalError:
        self._poisoned = reason
        return JournalError(self.path, reason)


def check_not_alive(folder: Path, name: str = "journal.jsonl") -> None:
    """Raise `RunAlive` if another process is writing the journal in a run's folder.

    Args:
        folder: folder of the run.
        name: name of the journal's file in it.
    """
    try:
        file = os.open(folder / name, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return  # the reader of the journal reports it
    try:
        _lock(file, folder, fcntl.LOCK_SH)
    finally:
        os.close(file)


def _lock(file: int, folder: Path, kind: int = fcntl.LOCK_EX) -> None:
    try:
        fcntl.flock(file, kind | fcntl.LOCK_NB)
    except BlockingIOError:
        raise RunAlive(folder) from None


def plain_json(value: Any) -> Any:
    """Convert the fields of a journal's record to the plain values that reading the record's JSON would
    give.
    """
    return orjson.loads(orjson.dumps(value, default=_plain, option=_OPTIONS))


def _plain(value: object) -> Any:
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, tuple):  # named tuples
        return list(value)
    raise TypeError(f"{type(value).__name__} is not JSON serializable")
