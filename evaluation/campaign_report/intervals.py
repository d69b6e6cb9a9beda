"""Intervals that hold the true value in 95 % of cases, whatever the distribution.

By `scipy.special`: `scipy.stats` takes longer to import than a thousand walks.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtr, bdtrik, ndtri

LEVEL = 0.95


def wilson(successes: int, count: int) -> tuple[float, float]:
    """Of a probability, by Wilson (1927); of no trials at all it is everything."""
    if not count:
        return 0.0, 1.0
    z, share = float(ndtri(0.5 + LEVEL / 2.0)), successes / count
    whole = 1.0 + z * z / count
    middle = (share + z * z / (2.0 * count)) / whole
    half = z / whole * math.sqrt(share * (1.0 - share) / count + z * z / (4.0 * count * count))
    return (0.0 if successes == 0 else middle - half), (1.0 if successes == count else middle + half)


def median_interval(values: NDArray[np.float64]) -> tuple[float, float] | None:
    """Of a median, by order statistics: exact, at least 95 %. None: fewer than 6 values bound none."""
    tail, count = (1.0 - LEVEL) / 2.0, len(values)
    rank = math.ceil(bdtrik(tail, count, 0.5)) if count else 0
    rank -= rank > 0 and bool(bdtr(rank - 1, count, 0.5) >= tail)
    if rank < 1:
        return None
    ordered = np.sort(values)
    return float(ordered[rank - 1]), float(ordered[-rank])
