"""The wheels of the kinematic robot."""

from __future__ import annotations

import math

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.commanded_base import CommandedBase
from handcart.backends.simulation.keyed_noise import keyed
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


class Rolling:
    """Wheels whose true radii, tread and slip differ from the robot's file, by its `errors` and a seed."""

    def __init__(self, robot: RobotFile, seed: int) -> None:
        """Draw what stays the same for a run."""
        self._seed, errors = seed, robot.errors
        left, right, tread = keyed(seed, "wheels").standard_normal(3)
        self._left_scale = 1.0 + errors.wheel_radius_percent / 100 * left
        self._right_scale = 1.0 + errors.wheel_radius_percent / 100 * right
        self._true_tread = robot.drive.tread_m * (1.0 + errors.tread_percent / 100 * tread)
        self._slip = errors.slip_percent / 100

    def motion(self, left: float, right: float, period: int) -> Pose2:
        """Pose of the base after a period in that before it, if nothing is in its way.

        Args:
            left: rolled by the left wheel at its nominal radius, in [m].
            right: by the right one.
            period: its number, on which slip depends.
        """
        if left == 0.0 and right == 0.0:
            return Pose2(0.0, 0.0, 0.0)
        slips = self._slip * keyed(self._seed, "slip", period).standard_normal(2)
        left, right = left * self._left_scale * (1.0 - slips[0]), right * self._right_scale * (1.0 - slips[1])
        return _arc(float(left + right) / 2, float((right - left) / self._true_tread))


def _arc(length: float, turn: float) -> Pose2:
    if abs(turn) < 1e-9:
        return Pose2(length, 0.0, turn)
    return Pose2(length / turn * math.sin(turn), length / turn * (1.0 - math.cos(turn)), turn)
