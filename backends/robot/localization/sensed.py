"""Outdoor readings of one period."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.backends.capabilities.gps import Fix


class Sensed(NamedTuple):
    """Outdoor readings of the last period."""

    rates: NDArray[np.float64]
    """(3,) of the gyros, in [rad/s]."""
    accelerations: NDArray[np.float64]
    """(3,) in [m/s²]."""
    rolled: NDArray[np.float64]
    """(2,) by the left and right wheel, in [m]."""
    fix: Fix | None
    ranges: NDArray[np.float64] | None = None
    """(k,) to the beacons, in [m]; NaN of those that weren't heard."""
