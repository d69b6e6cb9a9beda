"""The wheels, by CAN."""

from __future__ import annotations

from backends.base import Base, WheelTravel
from backends.limits import checked_drive
from backends.robot_file import Drive

from .drive_pair import STILL, DrivePair, Speeds


class CanBase(Base):
    """Two wheels that their drives turn; these ramp to what is commanded at the accelerations of the file."""

    def __init__(self, drive: Drive, wheels: DrivePair) -> None:
        """Take over enabled drives."""
        self._drive, self._wheels = drive, wheels
        self._command = STILL

    def drive(self, speed: float, turn_rate: float) -> None:
        """See `Base`."""
        speed, turn_rate = checked_drive(self._drive, speed, turn_rate)
        half = turn_rate * self._drive.tread_m / 2
        self._command = Speeds(speed - half, speed + half)

    def wheel_travel(self) -> WheelTravel:
        """See `Base`."""
        return WheelTravel(self._wheels.left.travel, self._wheels.right.travel)

    def forget(self) -> None:
        """Forget the command."""
        self._command = STILL

    def advance(self) -> None:
        """Send the command, or zero where there is none, and let a period pass; raises `CanFault`."""
        command, self._command = self._command, STILL
        self._wheels.send(command)
        self._wheels.end_period()
