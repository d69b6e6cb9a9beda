"""Output streams that tolerate a closed pipe, a full disk or a missing descriptor."""

from __future__ import annotations

import errno
import io
import os
import sys
from contextlib import suppress
from typing import Any, TextIO


class Streams:
    """Context manager that discards output that cannot be written to stdout or stderr, and records the
    reason.

    So a command does not end because of a closed pipe, a full disk, or a descriptor that was closed before
    its start (row K14 of docs/reference/faults.md). Missing descriptors are opened on the null device, so
    that no file that the program opens later, such as a journal, becomes stdout for a library that writes to
    stdout.
    """

    def __enter__(self) -> Streams:
        missing = [number for number in (0, 1, 2) if not _is_open(number)]
        for _ in missing:
            os.open(os.devnull, os.O_RDWR)  # the lowest that is free
        if 0 in missing:
            sys.stdin = open(0, closefd=False)
        self._before = sys.stdout, sys.stderr
        self._files: dict[int, _Lenient] = {}
        if sys.stdout is sys.__stdout__:
            sys.stdout = self._lenient(1, sys.stdout, 1 in missing)
        if sys.stderr is sys.__stderr__:
            sys.stderr = self._lenient(2, sys.stderr, 2 in missing)
        return self

    def __exit__(self, *_: object) -> None:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        self._ours = sys.stdout, sys.stderr  # closing them would close nothing, but warn
        if self._before[0] is not None:
            sys.stdout = self._before[0]
        if self._before[1] is not None:
            sys.stderr = self._before[1]

    @property
    def lost(self) -> str:
        """Return why output to stdout was lost; empty if all was written."""
        error = self._error
        return "" if error is None else os.strerror(error)

    @property
    def _error(self) -> int | None:
        return self._files[1].failed if 1 in self._files else None

    def _lenient(self, number: int, stream: TextIO | None, missing: bool) -> TextIO:
        file = self._files[number] = _Lenient(number, missing)
        encoding = "utf-8" if stream is None else stream.encoding
        by_line = number == 2 or file.isatty()
        buffered = io.BufferedWriter(file)
        return io.TextIOWrapper(buffered, encoding, errors="backslashreplace", line_buffering=by_line)


class _Lenient(io.FileIO):
    """Descriptor that accepts all output, and records whether any of it was lost."""

    def __init__(self, number: int, missing: bool) -> None:
        super().__init__(number, "w", closefd=False)
        self._missing = missing
        self.failed: int | None = None

    def write(self, content: Any, /) -> int:
        try:
            if self._missing or self.failed is not None:
                raise OSError(self.failed or errno.EBADF, "")
            return super().write(content)
        except OSError as error:
            self.failed = error.errno
            return len(content)


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:
        return False
    return True
