"""The wheels of the kinematic robot."""

from __future__ import annotations

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.body.rolling import Rolling
from handcart.backends.simulation.commanded_base import CommandedBase
from handcart.robotics.geometry.pose2 import Pose2


class KinematicBase(CommandedBase):
    """Two wheels that turn as commanded; true radii, tread and slip differ from the file's."""

    def __init__(self, robot: RobotFile, seed: int) -> None:
        super().__init__(robot)
        self._rolling = Rolling(robot, seed)

    def advance(self, period: int) -> Pose2:
        """Turn the wheels for a period; gives how the base truly moves if nothing is in its way."""
        speed, turn_rate = self._take_command()
        half = turn_rate * self._drive.tread_m / 2
        left, right = (speed - half) * self._period, (speed + half) * self._period
        self._travel = WheelTravel(self._travel.left + left, self._travel.right + right)
        return self._rolling.motion(left, right, period)
