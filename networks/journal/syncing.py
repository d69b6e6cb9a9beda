"""Bringing a file to the disk, at once or beside what else is done."""

from __future__ import annotations

import os
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Literal

Sync = Literal["never", "always", "beside"]
"""Policy for bringing records to the disk. A killed process loses none of them, a power cut does.

`never`: when the system likes, used in simulated runs. `always`: each append waits until the record is on the
disk. `beside`: a thread brings records to the disk, and the caller asks whether they are there before it
continues: the control loop never waits.
"""


class DiskSync:
    """Writer of a file's data from the operating system's buffers to the disk, at once or in a thread.

    After a failure it never tries again (row D8 of faults.md).
    """

    def __init__(self, file: int, sync: Sync) -> None:
        """Create a sync of an open file; `never` needs none."""
        self._file, self._sync = file, sync
        self._pool = ThreadPoolExecutor(1, "journal") if sync == "beside" else None
        self._latest: Future[None] | None = None
        self._failed = False

    def ask(self) -> None:
        """Request that all data written so far are brought to the disk; raises `OSError` if this or an
        earlier request failed.
        """
        if self._pool is not None:
            self.done  # noqa: B018  raises what went wrong before
            self._latest = self._pool.submit(self._flush)
        elif self._sync == "always":
            self._flush()

    @property
    def done(self) -> bool:
        """True if all requested writes are on the disk; raises `OSError` if one failed."""
        if self._latest is None:
            return True
        if not self._latest.done():
            return False
        self._latest.result()
        return True

    def close(self) -> None:
        """Wait for pending writes, without reporting errors. A second call does nothing."""
        if self._pool is not None:
            self._pool.shutdown()

    def _flush(self) -> None:
        if self._failed:  # pages count as clean after a failure, so a second try would succeed falsely
            raise OSError(5, os.strerror(5))
        try:
            os.fdatasync(self._file)
        except OSError:
            self._failed = True
            raise
