"""Recordings of the traffic between the program and a robot, kept next to the journal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path


class Recording(ABC):
    """Recording of raw traffic with a robot, such as CAN frames, in a run's folder."""

    suffix: str
    """Suffix of the files that `keep` writes."""
    lost: str | None = None
    """Why nothing more is kept; None while all goes well."""

    @abstractmethod
    def open(self, folder: Path) -> None:
        """Record everything in a folder, including what has passed up to now."""

    @abstractmethod
    def look(self, time: float) -> None:
        """Record a period that ended at `time`, in [s] of the robot.

        The data are handed to the operating system, so that a killed process loses none of them.
        """

    @abstractmethod
    def mark(self) -> None:
        """Hold the last seconds for the next `keep`."""

    @abstractmethod
    def keep(self, stem: Path) -> None:
        """Write the last seconds, and those before the mark, into a file whose name begins with `stem`."""

    @abstractmethod
    def close(self) -> None:
        """Close the files; a second call does nothing."""
