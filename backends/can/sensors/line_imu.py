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
    """IMU on a serial port or socket that sends its readings as lines `$IMU`; its axes are those of the base.

    Several lines or none may arrive in a control period.
    """

    KIND = "IMU"

    def __init__(self, source: LineSource, clock: Clock = time.monotonic) -> None:
        """Open the sensor's port; raise `NoSensor` if it cannot be opened."""
        super().__init__("the inertial unit", source, clock)
        self._mean = np.zeros(6)

    def rates(self) -> FloatArray:
        """Return the angular velocities (3,) about the base's axes x, y and z, in [rad/s].

        They are the mean of the readings that arrived in one control period.

        Raises:
            StaleSensor: the last reading is older than the robot's file allows.
        """
        self.check_fresh()
        return self._mean[:3].copy()

    def accelerations(self) -> FloatArray:
        """Return the accelerations (3,) along the base's x, y and z, in [m/s²]; +9.81 along z at rest.

        They are the mean of the readings that arrived in one control period.

        Raises:
            StaleSensor: the last reading is older than the robot's file allows.
        """
        self.check_fresh()
        return self._mean[3:].copy()

    def _sound(self, values: FloatArray) -> bool:
        return len(values) == 6 and bool(np.isfinite(values).all()) and float(np.abs(values).max()) <= _MOST

    def _taken(self, lines: list[FloatArray]) -> None:
        self._mean = np.mean(lines, axis=0)
