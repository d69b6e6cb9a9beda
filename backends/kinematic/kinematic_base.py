"""The wheels of the kinematic robot."""

from __future__ import annotations

import math

from backends.base import Base, WheelTravel
from backends.limits import checked_drive
from backends.robot_file import RobotFile
from backends.scene.keyed_noise import keyed
from robotics.geometry.pose2 import Pose2


class KinematicBase(Base):
    """Two wheels that turn as commanded; true radii, tread and slip differ from the file's."""

    def __init__(self, robot: RobotFile, seed: int) -> None:
        self._drive, self._period, self._seed = robot.drive, robot.period_s, seed
        errors = robot.errors
        left, right, tread = keyed(seed, "wheels").standard_normal(3)
        self._left_scale = 1.0 + errors.wheel_radius_percent / 100 * left
        self._right_scale = 1.0 + errors.wheel_radius_percent / 100 * right
        self._true_tread = robot.drive.tread_m * (1.0 + errors.tread_percent / 100 * tread)
        self._slip = errors.slip_percent / 100
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
        if speed == 0.0 and turn_rate == 0.0:
            return Pose2(0.0, 0.0, 0.0)
        half = turn_rate * self._drive.tread_m / 2
        left, right = (speed - half) * self._period, (speed + half) * self._period
        self._travel = WheelTravel(self._travel.left + left, self._travel.right + right)
        slips = self._slip * keyed(self._seed, "slip", period).standard_normal(2)
        left, right = left * self._left_scale * (1.0 - slips[0]), right * self._right_scale * (1.0 - slips[1])
        return _arc(float(left + right) / 2, float((right - left) / self._true_tread))


def _arc(length: float, turn: float) -> Pose2:
    if abs(turn) < 1e-9:
        return Pose2(length, 0.0, turn)
    return Pose2(length / turn * math.sin(turn), length / turn * (1.0 - math.cos(turn)), turn)
