"""Heading and tilt of a base, by its inertial sensors."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from handcart.robotics.geometry.pose2 import wrap
from handcart.robotics.numerics.arrays import FloatArray

BIAS_TIME = 5.0  # over which a gyro's bias is averaged at rest [s]
TILT_TIME = 0.5  # over which the direction of gravity is averaged [s]
MAX_REST_TURN_RATE = 0.002  # [rad/s] besides its bias: a faster turn is not rest


class Attitude:
    """Estimator of a base's attitude by an inertial sensor, yaw by the gyro, roll and pitch by gravity.

    The gyro's bias is estimated at rest. Yaw starts at 0 and is not wrapped, because only its differences are
    used. Roll and pitch are assumed to be small, and are exact only while the base isn't accelerated.
    """

    STATE: ClassVar = {
        "yaw": float,
        "moved": float,
        "_bias": float,
        "_known": float,
        "_felt": FloatArray,
    }
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self) -> None:
        self.yaw = 0.0
        """[rad], counted from the start."""
        self.moved = 0.0
        """Duration over which rates were added up to `yaw`, in [s]."""
        self._bias = 0.0
        self._known = 0.0
        self._felt = np.array([0.0, 0.0, 1.0])

    def update(self, rates: FloatArray, accelerations: FloatArray, period: float, at_rest: bool) -> None:
        """Update the attitude with a period's readings.

        Args:
            rates: (3,) turn rates about the base's axes, in [rad/s].
            accelerations: (3,) specific force along the base's axes, gravity included, in [m/s²].
            period: duration of the period, in [s].
            at_rest: True if neither wheels nor arm were commanded to move.
        """
        rate = float(rates[2])
        steady = at_rest and abs(rate - self._bias) < max(
            MAX_REST_TURN_RATE, 1.0 if self._known == 0.0 else 0.0
        )
        if steady:
            self._known = min(self._known + period, BIAS_TIME)
            self._bias += period / self._known * (rate - self._bias)
        if not steady:
            self.moved += period
            self.yaw += (rate - self._bias) * period
        self._felt = self._felt + min(1.0, period / TILT_TIME) * (accelerations - self._felt)

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch of the base, in [rad]."""
        x, y, z = self._felt
        return math.atan2(y, z), wrap(math.atan2(-x, math.hypot(y, z)))


def yaw_sigma(walk: float, moved: float) -> float:
    """Return the standard deviation, in [rad], of the difference between two values of `Attitude.yaw`.

    The result includes the error of the gyro's bias, which is estimated at rest before the motion.

    Args:
        walk: the gyro's angle random walk, in [rad/√s].
        moved: duration, between the two values, over which turn rates were integrated, in [s].
    """
    return walk * math.sqrt(moved + moved**2 / BIAS_TIME)
