"""One run at a time on a real robot, and none after one that a person has to see to."""

from __future__ import annotations

import fcntl
import os
import re
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

from handcart.backends.backend import Backend
from handcart.files.errors import InputError
from handcart.files.printable import printable
from handcart.files.state_folder import state_folder
from handcart.networks.journal.journal_record import JournalError
from handcart.networks.journal.retracing import NeedsOperator
from handcart.networks.journal.waiting import waiting
from handcart.networks.run_files.run_folder import JOURNAL_FILE, NoRun, read_run_journal

_FLAGS = os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW


class RobotBusy(InputError):
    """Error, because another process has reserved the robot for its own run."""


class NoClaimFolder(InputError):
    """Error, because the folder cannot be used in which runs reserve (claim) real robots."""


class RobotClaim:
    """Exclusive claim of a real robot by this process, with the path of its run in a small file.

    A run waits for a person if its journal shows that it gave up, or was broken off during an action. Until a
    person has acknowledged the run, every further claim of the robot is refused (row N13 of faults.md), so
    that a service that starts runs again and again moves nothing.

    The claim is a context manager. Its end releases the robot, and clears the path in the file unless the run
    waits for a person.
    """

    def __init__(self, backend: Backend, folder: Path, own: Path | None = None) -> None:
        """Claim the robot behind a backend.

        Args:
            backend: the backend, which identifies the robot.
            folder: folder with one file for each robot; made if it is missing.
            own: the run to resume, if the claim is for a resume: that run may wait.

        Raises:
            RobotBusy: another process has it.
            NeedsOperator: its last run waits for a person.
            NoClaimFolder: the folder cannot be used.
        """
        name = re.sub(r"[^\w.-]", "_", f"{backend.name}-{backend.address}".strip("-"))
        self.path = folder / name
        """Holds the path of the run's folder; empty where nothing waits."""
        self._run: Path | None = None
        try:
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._file = os.open(self.path, _FLAGS, 0o600)
        except OSError as error:
            raise NoClaimFolder(
                f"{self.path} can't be opened: {error.strerror}; allowed: a folder of yours"
            ) from None
        try:
            self._lock()
            self._refuse_what_waits(own)
        except BaseException:
            os.close(self._file)
            raise

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            words = f"the robot {self.path.name} is in another run: {self._noted() or 'not named yet'}"
            raise RobotBusy(printable(f"{words}; allowed: one at a time")) from None

    def _refuse_what_waits(self, own: Path | None) -> None:
        run = self._noted()
        if run is None or (own is not None and run == own.resolve()):
            return
        if not os.path.lexists(run / JOURNAL_FILE):
            how = f"if it may move: rm {self.path}"
            raise NeedsOperator(f"the robot's last run, {run}, is not over, and its journal is gone; {how}")
        open_ends = waiting(read_run_journal(run))
        if open_ends:
            number, reason = next(iter(open_ends.items()))
            how = f"when all is safe: handcart ack {run} {number}"
            raise NeedsOperator(f"the robot's last run, {run}, waits for a person: {reason}; {how}")

    def begin(self, run: Path) -> None:
        """Write the path of the run that uses the robot from now on to the disk.

        Raises:
            JournalError: the disk refuses the path; nothing has moved.
        """
        self._run = run.resolve()
        try:
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, f"{self._run}\n".encode(), 0)
            os.fsync(self._file)
        except OSError as error:
            raise JournalError(self.path, f"can't be written: {error.strerror}") from None

    def close(self) -> None:
        """Release the robot. A second call does nothing."""
        if self._file < 0:
            return
        if self._run is not None and not self._waits(self._run):
            os.ftruncate(self._file, 0)
        os.close(self._file)
        self._file = -1

    def __enter__(self) -> RobotClaim:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _waits(self, run: Path) -> bool:
        if not (run / JOURNAL_FILE).exists():  # this process has made none, or somebody deleted the run
            return not run.is_dir()
        try:
            return bool(waiting(read_run_journal(run)))
        except (JournalError, NoRun):
            return True

    def _noted(self) -> Path | None:
        text = os.pread(self._file, 4096, 0).decode(errors="replace").strip()
        return Path(text) if text else None


def claims_folder() -> Path:
    """Return the folder with a file for each real robot, which shows the run that has claimed the robot."""
    return state_folder() / "robots"


def claimed(backend: Backend, own: Path | None = None) -> AbstractContextManager[RobotClaim | None]:
    """Return a context manager that claims the robot of a backend for this process.

    A simulated robot is not claimed; the context's value is then None.

    Args:
        backend: the backend, which identifies the robot.
        own: folder of the run to resume, which is the only run that may claim the robot although it waits for
            a person; None for a new run.
    """
    return nullcontext() if backend.simulated else RobotClaim(backend, claims_folder(), own)
