"""What all simulated wheels share."""

from __future__ import annotations

from typing import ClassVar

from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.limits import checked_drive
from handcart.backends.plain_values import Kinds


class CommandedBase(Base):
    """Wheels that are simulated: a command counts for the period that comes, and only for it."""

    STATE: ClassVar[Kinds] = {"_command": tuple[float, float], "_travel": WheelTravel}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, robot: RobotFile) -> None:
        self._drive, self._period = robot.drive, robot.period_s
        self._command = (0.0, 0.0)
        self._travel = WheelTravel(0.0, 0.0)

    def drive(self, speed: float, turn_rate: float) -> None:
        """See `Base`."""
        self._command = checked_drive(self._drive, speed, turn_rate)

    def wheel_travel(self) -> WheelTravel:
        """See `Base`."""
        return self._travel

    def halt(self) -> None:
        """Forget the command."""
        self._command = (0.0, 0.0)

    def _take_command(self) -> tuple[float, float]:
        """Speed in [m/s] and turn rate in [rad/s] of the period that begins."""
        command, self._command = self._command, (0.0, 0.0)
        return command
