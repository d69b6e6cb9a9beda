"""An inertial unit, by `sensor_msgs/Imu`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.imu import Imu
from handcart.robotics.numerics.arrays import FloatArray

from .wire.topic_sensor import TopicSensor


class RosImu(TopicSensor, Imu):
    """IMU whose readings are received from a ROS topic; its axes are those of the base.

    The readings of a control period are averaged.
    """

    KIND = "sensor_msgs/Imu"

    @override
    def rates(self) -> FloatArray:
        """Return the turn rates (3,) about the base's axes, in [rad/s], as mean of the messages of a period.

        Raises:
            StaleSensor: the last message is too old.
        """
        self.check_fresh()
        rates: FloatArray = self._mean[:3].copy()
        return rates

    @override
    def accelerations(self) -> FloatArray:
        """Return the mean accelerations (3,) along the base's axes, in [m/s²]; +9.81 along z at rest.

        Raises:
            StaleSensor: the last message is older than the robot's file allows.
        """
        self.check_fresh()
        accelerations: FloatArray = self._mean[3:].copy()
        return accelerations

    @override
    def _wrong(self, message: Any) -> str:
        return "" if all(map(math.isfinite, _numbers(message))) else "a reading is not finite"

    @override
    def _read(self, messages: list[Any]) -> None:
        self._mean = np.mean([_numbers(message) for message in messages], axis=0)


def _numbers(message: Any) -> list[float]:
    both = message.angular_velocity, message.linear_acceleration
    return [float(getattr(item, axis)) for item in both for axis in ("x", "y", "z")]
