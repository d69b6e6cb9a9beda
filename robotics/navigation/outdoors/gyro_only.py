"""Wheels and gyros alone: what is left when no satellite is heard."""

from __future__ import annotations

from typing import ClassVar

from handcart.robotics.navigation.outdoors.field_localizer import Array
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter


class GyroOnly(GpsFilter):
    """Gyro odometry as Ohki et al. (2012) have it, with an honest covariance; fixes are not looked at."""

    TAKES_FIXES: ClassVar = False

    def _fix(self, position: Array, sigma: float | None) -> bool:
        return False
