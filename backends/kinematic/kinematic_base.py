"""The wheels of the kinematic robot."""

from __future__ import annotations

from backends.base import Base, WheelTravel
from backends.limits import checked_drive
from backends.robot_file import RobotFile
from backends.scene.rolling import Rolling
from robotics.geometry.pose2 import Pose2


class KinematicBase(Base):
    """Two wheels that turn as commanded; true radii, tread and slip differ from the file's."""

    def __init__(self, robot: RobotFile, seed: int) -> None:
        self._drive, self._period, self._rolling = robot.drive, robot.period_s, Rolling(robot, seed)
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

    def advance(self, period: int) -> Pose2:
        """Turn the wheels for a period; gives how the base truly moves if nothing is in its way."""
        (speed, turn_rate), self._command = self._command, (0.0, 0.0)
        half = turn_rate * self._drive.tread_m / 2
        left, right = (speed - half) * self._period, (speed + half) * self._period
        self._travel = WheelTravel(self._travel.left + left, self._travel.right + right)
        return self._rolling.motion(left, right, period)
