"""The gripper, by CAN."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.can.drives.axis import Axis
from handcart.backends.can.drives.axis_limits import FULL_TORQUE
from handcart.backends.commanded_parts import CommandedGripper
from handcart.backends.description.robot_file import GripperSpec

_PRESSES = 0.5  # share of its greatest torque
_BLOCKED = 0.2  # of top speed: slower fingers don't move
_AWAY = 1e-3  # [m]


class CanGripper(CommandedGripper):
    """Gripper with one CiA 402 drive, which moves the fingers to a width with limited torque.

    Fingers that an object stops keep pressing on it. Pressing is detected if the resting drive has half of
    its largest torque (6077h), or, for a drive that reports no torque, if the fingers rest wider open than
    commanded.
    """

    def __init__(self, spec: GripperSpec, axis: Axis) -> None:
        """Take over the fingers' drive."""
        self._spec, self._axis = spec, axis
        self._command = 0.0

    def begin(self) -> None:
        """Set the commanded opening of the fingers to the measured one, before the drive is enabled."""
        self._command = min(max(0.0, self._axis.position), self._spec.opening_mm / 1e3)

    def holds(self, width: float) -> None:
        """Take an opening of the fingers, in [m], as the last commanded one, without sending it."""
        self._command = width

    @override
    def width(self) -> float:
        return max(0.0, self._axis.position)

    @override
    def closed_on_something(self) -> bool:
        most = self._axis.limits.torque / FULL_TORQUE
        stands = abs(self._axis.velocity) <= _BLOCKED * self._axis.limits.speed
        if not self._axis.tells_torque:
            expected = self._axis.expected
            return stands and expected.velocity == 0.0 and self.width() - expected.position > _AWAY
        return stands and self._axis.torque <= -_PRESSES * most

    def halt(self) -> None:
        """Make the gripper hold: fingers that press on an object continue to press, moving fingers stop."""
        if not self.closed_on_something():
            self._command = min(self.width(), self._spec.opening_mm / 1e3)

    def pass_on(self) -> None:
        """Send the commanded opening to the gripper's drive."""
        self._axis.command(self._command)
