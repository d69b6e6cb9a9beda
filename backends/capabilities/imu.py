"""The inertial measurement unit."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from handcart.robotics.numerics.arrays import FloatArray

from .capability import Capability, Reading


class Imu(Capability):
    """Three gyros and three accelerometers, their axes along those of the base: x forward, y left, z up."""

    READINGS: ClassVar = {"rates": Reading("imu", noisy=True), "accelerations": Reading("imu", noisy=True)}

    @abstractmethod
    def rates(self) -> FloatArray:
        """Return the turn rates (3,) about the IMU's axes, in [rad/s]: the mean over this period, with the
        gyros' bias.
        """

    @abstractmethod
    def accelerations(self) -> FloatArray:
        """Return the accelerometers' reading (3,) along the IMU's axes, in [m/s²].

        For an IMU at rest and level, the reading is (0, 0, +9.81).
        """
