"""Recordings of the traffic between the program and a robot, kept next to the journal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path


class Recording(ABC):
    """Keeps raw traffic with a robot, such as CAN frames, in a run's folder.

    A disk that takes no more never stops a robot: then `lost` says why nothing more is kept.
    """

    suffix: str
    """Suffix of the files that `keep` writes."""
    lost: str | None = None
    """Why nothing more is kept; None while all goes well."""

    @abstractmethod
    def open(self, folder: Path) -> None:
        """Keep everything in this folder, with what has passed up to now."""

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
        """Write the last seconds, and those before the mark, into a file: `stem` and the suffix.

        Its stamps are the robot's time.
        """

    @abstractmethod
    def close(self) -> None:
        """Let go of the files. A second call does nothing."""
