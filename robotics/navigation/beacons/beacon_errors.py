"""How wrong ranges to radio beacons are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class BeaconErrors(NamedTuple):
    """One-sigma errors of ranges (ultra-wideband radio, say), and where beacons and tag are."""

    places: NDArray[np.float64]
    """(k, 3) of the beacons: world's x, y, and height above the ground, in [m]."""
    tag: tuple[float, float, float]
    """Of the robot's own radio in the base frame, in [m]."""
    white: float = 0.1
    """Of each range, in [m]."""
    bias: float = 0.3
    """By which all ranges to one beacon are too long or too short: another of each beacon, in [m]."""
    scale: float = 0.01
    """By which all ranges are too long or too short, relative: the same of all beacons."""
    bias_walk: float = 0.01
    """Random walk of that, in [m/√s]: with none, claims are far too good where a bias isn't constant."""
