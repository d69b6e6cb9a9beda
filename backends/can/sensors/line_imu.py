"""An inertial unit on a serial port."""

from __future__ import annotations

import time

import numpy as np

from handcart.backends.capabilities.imu import Imu
from handcart.backends.description.can_sensor_spec import LineSource
from handcart.backends.live.live_sensor import Clock
from handcart.robotics.numerics.arrays import FloatArray

from .line_sensor import LineSensor

_MOST = 100.0  # [rad/s], [m/s²]: no robot turns or falls like that


class LineImu(LineSensor, Imu):
    """IMU that sends lines `$IMU`, at a higher or lower rate than the control's; its axes are the base's."""

    KIND = "IMU"

    def __init__(self, source: LineSource, clock: Clock = time.monotonic) -> None:
        """Open the sensor's port; raise `NoSensor` if it can't be opened."""
        super().__init__("the inertial unit", source, clock)
        self._mean = np.zeros(6)

    def rates(self) -> FloatArray:
        """Return the mean angular velocities (3,) about the base's axes x, y and z, in [rad/s].

        Raises:
            StaleSensor: no fresh reading has arrived.
        """
        self.check_fresh()
        return self._mean[:3].copy()

    def accelerations(self) -> FloatArray:
        """Return the mean accelerations (3,) along the base's x, y and z, in [m/s²]; +9.81 along z at rest.

        Raises:
            StaleSensor: no fresh reading has arrived.
        """
        self.check_fresh()
        return self._mean[3:].copy()

    def _sound(self, values: FloatArray) -> bool:
        return len(values) == 6 and bool(np.isfinite(values).all()) and float(np.abs(values).max()) <= _MOST

    def _taken(self, lines: list[FloatArray]) -> None:
        self._mean = np.mean(lines, axis=0)
