"""Distribution-free intervals that hold the true value in 95 % of cases.

They are computed by their formulas, because importing scipy.stats takes as long as a campaign on the
network.
"""

from __future__ import annotations

import numpy as np
from scipy.special import bdtr, ndtri

from handcart.robotics.numerics.arrays import FloatArray

CONFIDENCE_LEVEL = 0.95


def wilson(successes: int, count: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a probability, by Wilson's score interval (1927).

    It is (0, 1) without trials.
    """
    if not count:
        return 0.0, 1.0
    share, z = successes / count, float(ndtri(0.5 + CONFIDENCE_LEVEL / 2.0))
    middle = (2.0 * count * share + z**2) / (2.0 * (count + z**2))
    beside = z / (2.0 * (count + z**2)) * float(np.sqrt(4.0 * count * share * (1.0 - share) + z**2))
    low = 0.0 if successes == 0 else middle - beside
    return low, 1.0 if successes == count else middle + beside


def median_interval(values: FloatArray) -> tuple[float, float] | None:
    """Return an exact interval of the median of values (n,), by order statistics.

    The median is in it with a probability of at least 95 %. None with fewer than 6 values. The ends are in
    the unit of the values.
    """
    below = bdtr(np.arange(len(values) + 1.0), len(values), 0.5)
    rank = int(np.searchsorted(below, (1.0 - CONFIDENCE_LEVEL) / 2.0))
    if rank < 1:
        return None
    ordered = np.sort(values)
    return float(ordered[rank - 1]), float(ordered[-rank])
