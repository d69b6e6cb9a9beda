"""Outdoor readings of one period."""

from __future__ import annotations

from typing import NamedTuple

from handcart.backends.capabilities.gps import Fix
from handcart.robotics.numerics.arrays import FloatArray


class Sensed(NamedTuple):
    """Readings of wheels, IMU, satellite fix and beacons in one period, for outdoor localization."""

    rates: FloatArray
    """Turn rates (3,) of the gyros about the base's axes x, y and z, in [rad/s]."""
    accelerations: FloatArray
    """Readings (3,) of the accelerometers along the base's x, y and z, in [m/s²]; +9.81 along z at rest."""
    rolled: FloatArray
    """Travel (2,) of the left and right wheel in the period, in [m]."""
    fix: Fix | None
    ranges: FloatArray | None = None
    """Ranges (k,) to the beacons, in [m]; NaN for beacons that were not heard."""
