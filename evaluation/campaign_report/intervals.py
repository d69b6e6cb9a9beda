"""Intervals that hold the true value in 95 % of cases, whatever the distribution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binom, binomtest

LEVEL = 0.95


def wilson(successes: int, count: int) -> tuple[float, float]:
    """Of a probability, by Wilson (1927); of no trials at all it is everything."""
    if not count:
        return 0.0, 1.0
    interval = binomtest(successes, count).proportion_ci(LEVEL, method="wilson")
    return float(interval.low), float(interval.high)


def median_interval(values: NDArray[np.float64]) -> tuple[float, float] | None:
    """Of a median, by order statistics: exact, at least 95 %. None: fewer than 6 values bound none."""
    rank = int(binom.ppf((1.0 - LEVEL) / 2.0, len(values), 0.5))
    if rank < 1:
        return None
    ordered = np.sort(values)
    return float(ordered[rank - 1]), float(ordered[-rank])
