"""What passes between the program and a robot, kept beside the journal."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path


class Recording(ABC):
    """Keeps raw traffic with a robot, such as CAN frames, in a run's folder.

    A disk that takes no more never stops a robot: then `lost` says why nothing more is kept.
    """

    suffix: str
    """How the names of the files end that `keep` writes."""
    lost: str | None = None
    """Why nothing more is kept; None while all goes well."""

    @abstractmethod
    def open(self, folder: Path) -> None:
        """Keep everything in this folder, with what has passed up to now."""

    @abstractmethod
    def look(self, time: float) -> None:
        """A period has passed; it is `time` in [s] by the robot.

        What has passed is handed to the system: a process that is killed then loses none of it.
        """

    @abstractmethod
    def mark(self) -> None:
        """Hold on to the last seconds up to now, for the next `keep`."""

    @abstractmethod
    def keep(self, stem: Path) -> None:
        """Write the last seconds, and those before the mark, into a file: `stem` and the suffix.

        Its stamps are the robot's time.
        """

    @abstractmethod
    def close(self) -> None:
        """Let go of the files. A second call does nothing."""
