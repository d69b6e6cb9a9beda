"""Ranges of a lidar at other angles than those of its beams."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.far import FarArray
from handcart.robotics.numerics.arrays import FloatArray

SAME_SURFACE_SHARE = 0.1
"""Difference of neighbouring ranges, as a share of the nearer one, up to which both are of one surface."""


def ranges_at(first: float, step: float, ranges: FarArray, wanted: FloatArray) -> FarArray:
    """Return the ranges of a scan at other angles.

    Between two beams that hit one surface, ranges are interpolated, otherwise that of the nearest beam is
    returned, so that no return is invented between two surfaces.

    Args:
        first: angle of the first beam, in [rad].
        step: angle from each beam to the next, above 0, in [rad].
        ranges: (n,) in [m]; infinity, NaN and other values without a return are kept.
        wanted: (m,) angles in [rad].

    Returns:
        Ranges (m,) in [m]; NaN at angles more than half a step from all beams.
    """
    count, turn = len(ranges), math.tau / step
    place = np.mod(wanted - first, math.tau) / step
    place = np.where(place > turn - 0.5, place - turn, place)
    nearest = np.rint(place).astype(np.int64)
    inside = nearest < count
    found = np.where(inside, ranges[np.clip(nearest, 0, count - 1)], math.nan)
    low = np.clip(np.floor(place).astype(np.int64), 0, max(0, count - 2))
    near, far = ranges[low], ranges[np.minimum(low + 1, count - 1)]
    share = place - low
    with np.errstate(invalid="ignore"):
        together = np.abs(near - far) <= SAME_SURFACE_SHARE * np.minimum(near, far)
    together &= inside & (share >= 0.0) & (share <= 1.0) & np.isfinite(near) & np.isfinite(far)
    mixed = np.where(together, near, 0.0) * (1.0 - share) + np.where(together, far, 0.0) * share
    return np.where(together, mixed, found)
