"""Recordings of the traffic between the program and a robot, kept next to the journal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path


class Recording(ABC):
    """Recording of raw traffic with a robot, such as CAN frames, in a run's folder."""

    suffix: str
    """Suffix of the files that `keep` writes."""
    lost: str | None = None
    """Reason why recording ended early; None while it works."""

    @abstractmethod
    def open(self, folder: Path) -> None:
        """Record all traffic into a folder, including the traffic before this call."""

    @abstractmethod
    def look(self, time: float) -> None:
        """Record the traffic of a period that ended at `time`, in [s] of the robot's clock.

        The data are handed to the operating system, so that a killed process loses none of them.
        """

    @abstractmethod
    def mark(self) -> None:
        """Remember the last seconds of traffic; the next `keep` writes them, too."""

    @abstractmethod
    def keep(self, stem: Path) -> None:
        """Write the last seconds, and those before `mark`, into a file whose name begins with `stem`."""

    @abstractmethod
    def close(self) -> None:
        """Close the files; a second call does nothing."""
