"""Watch over the progress of a driven base, by all its sensors."""

from __future__ import annotations

import math

from handcart.backends.capabilities.base import DriveCommand, WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.blocked_motion import Blocked, BlockedMotion
from handcart.robotics.navigation.following.blocked_wheels import BlockedWheel, BlockedWheels
from handcart.robotics.navigation.locating.moved_scan import rolled_motion

from .localization.localization import Localization

ROUGH_SIGMA_M = 0.1  # of a position: corrections of a less certain pose are not motion


class ProgressWatch:
    """Detector of a blocked base or wheel, by comparing commands with the estimated motion every period.

    Attributes:
        blocked: evidence of the last period that the base is blocked in its direction of travel; None if it
            is not.
        blocked_wheel: evidence that one wheel is blocked, for example in a turn on the spot; None without
            evidence, or if `blocked` is set.
    """

    def __init__(self, spec: RobotFile, period: float, localization: Localization) -> None:
        """Begin at rest.

        Args:
            spec: robot file.
            period: control period, in [s].
            localization: estimator of the base's motion.
        """
        self._localization, self._is_car = localization, spec.drive.kind == "ackermann"
        self._motion, self._wheels = BlockedMotion(period), BlockedWheels(period, spec.drive.tread_m)
        self._tread, self._is_rough = spec.drive.tread_m, False
        self.blocked: Blocked | None = None
        self.blocked_wheel: BlockedWheel | None = None

    def update(self, command: DriveCommand, travel: WheelTravel, before: Pose2) -> None:
        """Compare the command of the last period with the motion in it; update `blocked` and `blocked_wheel`.

        Args:
            command: command of the base in the period.
            travel: travel of the wheels since the start, as measured before the period, in [m].
            before: pose by odometry before the period, as in `Localization.odometry_pose`.
        """
        rolled, way = self._localization.travel, command.direction
        left, right = rolled.left - travel.left, rolled.right - travel.right
        sideways = rolled.sideways - travel.sideways
        now = self._localization.odometry_pose
        was_rough, self._is_rough = self._is_rough, self._is_rough_now()
        if was_rough:
            now = before.compose(rolled_motion(left, right, sideways, self._tread))
        along = 0.5 * (left + right) * math.cos(way) + sideways * math.sin(way)
        self.blocked = self._motion.update(command.along, along, before, now, way)
        if self.blocked is not None:
            self._motion.clear()
            self._wheels.clear()
        self.blocked_wheel = None
        if self._is_car or command.sideways != 0.0 or not self._localization.held_base.compares_scans:
            self._wheels.clear()
            return
        if self.blocked is None:
            wheels = command.speed, command.turn_rate
            self.blocked_wheel = self._wheels.update(wheels, (left, right), before, now)

    def _is_rough_now(self) -> bool:
        """Return whether the pose is so unsure that scans may correct it by more than the base moves."""
        covariance = self._localization.covariance
        return bool(covariance[0, 0] + covariance[1, 1] > ROUGH_SIGMA_M**2)
