"""The wheels, by CAN."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.can.drives.axis import Axis
from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.description.robot_file import Drive
from handcart.backends.limits import checked_drive


class CanBase(Base):
    """Base on two driven wheels, whose drives ramp to the commanded speed at the accelerations of the robot's
    file.
    """

    def __init__(self, drive: Drive, left: Axis, right: Axis) -> None:
        """Take over the wheels' drives."""
        self._drive, self._left, self._right = drive, left, right
        self._command = (0.0, 0.0)

    @override
    def drive(self, speed: float, turn_rate: float) -> None:
        speed, turn_rate = checked_drive(self._drive, speed, turn_rate)
        half = turn_rate * self._drive.tread_m / 2
        self._command = speed - half, speed + half

    @override
    def wheel_travel(self) -> WheelTravel:
        return WheelTravel(self._left.travel, self._right.travel)

    def set_travel(self, travel: WheelTravel) -> None:
        """Set how far the wheels have rolled so far, in [m]; the motion that the encoders measure later is
        added.
        """
        self._left.travel, self._right.travel = travel.left, travel.right

    def forget(self) -> None:
        """Discard the commanded speeds of the wheels, so that the base stops."""
        self._command = (0.0, 0.0)

    def pass_on(self) -> None:
        """Send the command of this period to the drives; without a new command, send zero speed."""
        (left, right), self._command = self._command, (0.0, 0.0)
        self._left.command(left)
        self._right.command(right)
