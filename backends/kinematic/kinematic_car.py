"""The wheels of a kinematic robot that steers like a car."""

from __future__ import annotations

from typing import ClassVar

from backends.base import Base, WheelTravel
from backends.limits import checked_drive
from backends.robot_file import RobotFile
from backends.scene.rough_ride import RoughRide
from robotics.geometry.pose2 import Pose2


class KinematicCar(Base):
    """Rear wheels that turn as commanded, front wheels that turn into their steering at its speed.

    Wheel travel is that of the rear wheels. On the spot nothing is steered; a curvature is the turn rate by
    the speed.
    """

    STATE: ClassVar = ("_command", "_travel", "_bend")

    def __init__(self, robot: RobotFile, ride: RoughRide) -> None:
        self._drive, self._period, self._ride = robot.drive, robot.period_s, ride
        self._command = (0.0, 0.0)
        self._travel = WheelTravel(0.0, 0.0)
        self._bend = 0.0

    def drive(self, speed: float, turn_rate: float) -> None:
        """See `Base`."""
        self._command = checked_drive(self._drive, speed, turn_rate)

    def wheel_travel(self) -> WheelTravel:
        """See `Base`."""
        return self._travel

    def halt(self) -> None:
        """Forget the command."""
        self._command = (0.0, 0.0)

    def advance(self, period: int) -> Pose2:
        """Turn the wheels for a period; gives how the base truly moves if nothing is in its way."""
        (speed, turn_rate), self._command = self._command, (0.0, 0.0)
        if speed != 0.0:
            most = self._drive.steering_per_m_s * self._period
            self._bend += max(-most, min(most, turn_rate / speed - self._bend))
        rolled, half = speed * self._period, 0.5 * self._bend * self._drive.tread_m
        left, right = self._travel
        self._travel = WheelTravel(left + rolled * (1.0 - half), right + rolled * (1.0 + half))
        return self._ride.motion(rolled, self._bend, period)
