"""Recordings of the traffic between the program and a robot, kept next to the journal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path


class Recording(ABC):
    """Interface of a recorder that writes the raw traffic with a robot, such as CAN frames, into a run's
    folder.
    """

    suffix: str
    """Suffix of the files that `keep` writes."""
    lost: str | None = None
    """Reason why recording ended early; None while it works."""

    @abstractmethod
    def open(self, folder: Path) -> None:
        """Start to write the raw messages to and from the robot into a folder, including those before this
        call.
        """

    @abstractmethod
    def look(self, time: float) -> None:
        """Record the messages exchanged with the robot in the period that ended at `time`, in [s] of the
        robot's clock.

        The data are flushed to the operating system, so that nothing is lost if the process is killed.
        """

    @abstractmethod
    def mark(self) -> None:
        """Mark the last seconds of traffic, for example at a fault; the next call of `keep` writes them into
        its file.
        """

    @abstractmethod
    def keep(self, stem: Path) -> None:
        """Write an extract of the recorded traffic into a file whose name begins with `stem`.

        The extract consists of the last seconds before this call, and of the last seconds before the latest
        call of `mark`, such as at a fault.
        """

    @abstractmethod
    def close(self) -> None:
        """Stop recording and close the recording's files; a second call does nothing."""
