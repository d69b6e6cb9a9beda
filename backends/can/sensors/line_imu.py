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
        """Open its port; raises `NoSensor`."""
        super().__init__("the inertial unit", source, clock)
        self._mean = np.zeros(6)

    def rates(self) -> FloatArray:
        """Return the angular velocities (3,) in [rad/s], in the IMU's axes; see `Imu`.

        Raises:
            StaleSensor: no fresh reading has arrived.
        """
        self.check_fresh()
        return self._mean[:3].copy()

    def accelerations(self) -> FloatArray:
        """Return the accelerations (3,) in [m/s²], in the IMU's axes; see `Imu`.

        Raises:
            StaleSensor: no fresh reading has arrived.
        """
        self.check_fresh()
        return self._mean[3:].copy()

    def _sound(self, values: FloatArray) -> bool:
        return len(values) == 6 and bool(np.isfinite(values).all()) and float(np.abs(values).max()) <= _MOST

    def _taken(self, lines: list[FloatArray]) -> None:
        self._mean = np.mean(lines, axis=0)
