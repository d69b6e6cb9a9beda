"""The wheels."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, NamedTuple

from .capability import Capability, Reading


class WheelTravel(NamedTuple):
    """Travel of the wheels since the backend was built, by their encoders and nominal radius."""

    left: float
    """[m]"""
    right: float
    """[m]"""

    def away(self, other: WheelTravel) -> float:
        """The farthest that either wheel has rolled since `other`, in [m]."""
        return max(abs(self.left - other.left), abs(self.right - other.right))


class Base(Capability):
    """A mobile base."""

    READINGS: ClassVar = {"wheel_travel": Reading("wheels")}
    COMMANDS = ("drive",)

    @abstractmethod
    def drive(self, speed: float, turn_rate: float) -> None:
        """Command the next period's forward speed in [m/s] and turn rate in [rad/s].

        Raises:
            CommandError: a value isn't finite or beyond the robot's limits.
        """

    @abstractmethod
    def wheel_travel(self) -> WheelTravel:
        """The encoders' reading."""
