"""Log of a campaign's trials: one line for each, with a checksum, appended when the trial has ended."""

from __future__ import annotations

import fcntl
import os
import zlib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, BinaryIO, NamedTuple, overload

import orjson

from handcart.files.errors import HandcartError, InputError
from handcart.files.printable import printable
from handcart.files.regular_file import check_regular, open_regular
from handcart.files.whole_file import sync_folder

from .trial import ActionEnd, Trial

_FLAGS = os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC | os.O_NOFOLLOW | os.O_NONBLOCK
_TAIL = 18  # bytes of `,"crc":"01234567"}`
MAX_LINE = 64 * 2**20


class TrialLogError(HandcartError):
    """Error for a log of trials that cannot be written or has a damaged line; exit status 5."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(printable(f"{path}: {reason}"))


class CampaignAlive(InputError):
    """Error for a campaign folder whose campaign is being run by another process."""

    def __init__(self, path: Path) -> None:
        words = (
            f"the campaign in {path.parent} is alive: another process writes it; allowed: wait for its end"
        )
        super().__init__(printable(words))


class TrialFile(Sequence[Trial]):
    """Sequence of the trials in a log file, ordered by seed; a trial is read from disk when accessed."""

    def __init__(self, path: Path, offsets: Iterable[tuple[int, int]], skipped_bytes: int = 0) -> None:
        """Index a log.

        Args:
            path: file with lines as `line_of` writes them.
            offsets: seed of each trial, and the byte at which its line begins.
            skipped_bytes: size of a last line that holds no trial.
        """
        self._path = path
        self.skipped_bytes = skipped_bytes
        """Size of the last line if it is damaged or still being written, and its trial is missing; 0 if the
        log is complete.
        """
        self._offsets = [offset for _, offset in sorted(offsets)]

    def __len__(self) -> int:
        return len(self._offsets)

    @overload
    def __getitem__(self, at: int) -> Trial: ...
    @overload
    def __getitem__(self, at: slice) -> TrialFile: ...
    def __getitem__(self, at: int | slice) -> Trial | TrialFile:
        if isinstance(at, slice):
            part = TrialFile(self._path, ())
            part._offsets = self._offsets[at]
            return part
        with self._open() as file:
            return _read_at(file, self._offsets[at], self._path)

    def __iter__(self) -> Iterator[Trial]:
        if not self._offsets:
            return
        with self._open() as file:
            for offset in self._offsets:
                yield _read_at(file, offset, self._path)

    def _open(self) -> BinaryIO:
        try:
            return open_regular(self._path)
        except OSError as error:
            raise TrialLogError(self._path, f"can't be read: {error.strerror}") from None


class TrialLog:
    """Log file of a campaign's trials, a context manager that lets one process at a time append to it.

    It holds each seed once. A damaged last line, left by a crash, is removed when the log is opened, and its
    size is in `dropped_bytes`. Any other damage is an error.

    Attributes:
        dropped_bytes: size of the damaged last line that was removed; 0 if the log was whole.
    """

    def __init__(self, path: Path, sync: bool = True) -> None:
        """Open or create a log.

        Args:
            path: path of the log.
            sync: True to wait until trials are on the disk.

        Raises:
            CampaignAlive: another process writes the log.
            TrialLogError: the log cannot be opened, or a line is damaged.
        """
        self._path, self._sync = path, sync
        try:
            self._file = os.open(path, _FLAGS, 0o666)
        except OSError as error:
            raise TrialLogError(path, f"can't be opened: {error.strerror}") from None
        try:
            check_regular(self._file)
            self._lock()
            self._offsets, self._size, _ = read_offsets(path)
            self.dropped_bytes = os.fstat(self._file).st_size - self._size
            if self.dropped_bytes:
                os.ftruncate(self._file, self._size)
            if sync:
                os.fsync(self._file)
                sync_folder(path.parent)
        except OSError as error:
            os.close(self._file)
            raise TrialLogError(path, f"can't be continued: {error.strerror}") from None
        except HandcartError:
            os.close(self._file)
            raise

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise CampaignAlive(self._path) from None

    def __enter__(self) -> TrialLog:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        os.close(self._file)

    def __contains__(self, seed: object) -> bool:
        return seed in self._offsets

    def __len__(self) -> int:
        return len(self._offsets)

    def trials(self) -> TrialFile:
        """Return the trials in the log so far."""
        return TrialFile(self._path, self._offsets.items())

    def append(self, trials: Sequence[Trial]) -> None:
        """Write trials that have ended; when this returns, they are on disk.

        Raises:
            TrialLogError: a trial cannot be written; those before it are in the log.
        """
        lines = [(trial.seed, line_of(trial)) for trial in trials if trial.seed not in self._offsets]
        content = b"".join(line for _, line in lines)
        try:
            if content and os.write(self._file, content) != len(content):
                os.ftruncate(self._file, self._size)
                raise TrialLogError(self._path, "can't be written: the disk is full")
            if content and self._sync:
                os.fdatasync(self._file)
        except OSError as error:
            raise TrialLogError(self._path, f"can't be written: {error.strerror}") from None
        for seed, line in lines:
            self._offsets[seed] = self._size
            self._size += len(line)


def line_of(trial: Trial) -> bytes:
    """Return the line of JSON that stores a trial in a log, with a checksum."""
    fields: dict[str, Any] = {
        "seed": trial.seed,
        "status": trial.status,
        "summary": dict(trial.summary),
        "actions": [list(action) for action in trial.actions],
    }
    if trial.varied:
        fields["varied"] = dict(trial.varied)
    if trial.faults:
        fields["faults"] = list(trial.faults)
    body = orjson.dumps(fields, option=orjson.OPT_SERIALIZE_NUMPY)[:-1]
    return b'%b,"crc":"%08x"}\n' % (body, zlib.crc32(body))


def trial_of(line: bytes) -> Trial | None:
    """Return the trial stored in a line of a log; None if the line is damaged."""
    line = line.rstrip(b"\n")
    body = line[:-_TAIL]
    if line[-_TAIL:] != b',"crc":"%08x"}' % zlib.crc32(body):
        return None
    fields = orjson.loads(line)
    ends = [ActionEnd(*action) for action in fields["actions"]]
    return Trial(
        fields["seed"],
        fields["status"],
        fields["summary"],
        ends,
        varied=fields.get("varied", {}),
        faults=fields.get("faults", ()),
    )


class LineOffsets(NamedTuple):
    """Places of the trials in a log, in bytes from its beginning."""

    by_seed: dict[int, int]
    """Begin of each trial's line."""
    end: int
    """End of the last complete line."""
    skipped_bytes: int
    """Size of a last line that is damaged or incomplete; 0 if there is none."""


def read_offsets(path: Path) -> LineOffsets:
    """Return the places of the trials in a log.

    Raises:
        TrialLogError: the log cannot be read, or a line before the last one is damaged.
    """
    offsets: dict[int, int] = {}
    offset, torn = 0, 0
    try:
        with open_regular(path) as file:
            for number, line in enumerate(file, start=1):
                if torn:
                    wrong = f"line {number - 1} at byte {offset} isn't what was written"
                    raise TrialLogError(path, wrong)
                trial = trial_of(line) if line.endswith(b"\n") else None
                torn = len(line) if trial is None else 0
                if trial is not None:
                    if trial.seed in offsets:
                        raise TrialLogError(path, f"line {number}: the seed {trial.seed} is there twice")
                    offsets[trial.seed] = offset
                    offset += len(line)
    except OSError as error:
        raise TrialLogError(path, f"can't be read: {error.strerror}") from None
    return LineOffsets(offsets, offset, torn)


def _read_at(file: BinaryIO, offset: int, path: Path) -> Trial:
    file.seek(offset)
    trial = trial_of(file.readline(MAX_LINE))
    if trial is None:
        raise TrialLogError(path, f"the line at byte {offset} isn't what was written")
    return trial
