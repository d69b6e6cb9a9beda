"""Outdoor readings of one period."""

from __future__ import annotations

from typing import NamedTuple

from handcart.backends.capabilities.gps import Fix
from handcart.robotics.numerics.arrays import FloatArray


class Sensed(NamedTuple):
    """Outdoor readings of the last period."""

    rates: FloatArray
    """(3,) of the gyros, in [rad/s]."""
    accelerations: FloatArray
    """(3,) in [m/s²]."""
    rolled: FloatArray
    """(2,) by the left and right wheel, in [m]."""
    fix: Fix | None
    ranges: FloatArray | None = None
    """(k,) to the beacons, in [m]; NaN of those that weren't heard."""
