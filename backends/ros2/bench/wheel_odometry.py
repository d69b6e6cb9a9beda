"""Odometry of a simulated base, as its driver computes it from the wheels."""

from __future__ import annotations

import math
from typing import ClassVar

from handcart.backends.capabilities.base import DriveCommand, WheelTravel
from handcart.backends.description.robot_file import Drive
from handcart.backends.plain_values import Kinds
from handcart.robotics.geometry.pose2 import Pose2


class WheelOdometry:
    """Odometry by the wheels of a simulated robot; its frame `odom` is the base frame at the start."""

    STATE: ClassVar[Kinds] = {"pose": Pose2, "_last": WheelTravel | None}

    def __init__(self, drive: Drive) -> None:
        """Begin at zero."""
        self._drive = drive
        self._last: WheelTravel | None = None
        self.pose = Pose2(0.0, 0.0, 0.0)

    def moved(self, travel: WheelTravel, seconds: float) -> tuple[Pose2, DriveCommand]:
        """Return the 2D pose odom_T_base at the end of a period, and the speeds in it.

        Args:
            travel: travel of the wheels until now, in [m].
            seconds: length of the period, in [s].
        """
        last = self._last or travel
        self._last = travel
        left, right = travel.left - last.left, travel.right - last.right
        sideways = travel.sideways - last.sideways
        forward, turn = 0.5 * (left + right), (right - left) / self._drive.tread_m
        half = 0.5 * turn
        chord = math.sin(half) / half if abs(half) > 1e-9 else 1.0
        cos, sin = math.cos(half), math.sin(half)
        step = Pose2(chord * (cos * forward - sin * sideways), chord * (sin * forward + cos * sideways), turn)
        self.pose = self.pose.compose(step)
        return self.pose, DriveCommand(forward / seconds, turn / seconds, sideways / seconds)
