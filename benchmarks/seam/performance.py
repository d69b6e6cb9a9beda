"""Performance of a placement at a point of the path: from 0 (at a limit) to 1.

The limits are lengths. With v the tool's speed and F the force that it pushes with, a joint has low = v /
(its speed limit) and high = (its torque limit) / F, in [m]: b_min and b_max of Shin (2005).
"""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


def printed_performance(largest: FloatArray, low: float, high: float) -> FloatArray:
    """Eq. 6 of Shin (2005) as printed, of the largest of |k^T J|; 0 outside [low, high]."""
    size, mean = 0.5 * (high - low), 0.5 * (high + low)
    inside = (largest >= low) & (largest <= high)
    return np.where(inside, (size - np.abs(largest - mean)) / size, 0.0)


def performance(elements: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Eq. 6 with limits of each joint's own: (...) of |k^T J| (..., n) and limits (n,).

    Some joint must be above its low limit, each below its high one. With equal limits it is eq. 6.
    """
    size = 0.5 * (high - low)
    fast = np.max((elements - low) / size, axis=-1)
    strong = np.min((high - elements) / size, axis=-1)
    return np.asarray(np.clip(np.minimum(fast, strong), 0.0, 1.0))


def speed_margin(top_speed: FloatArray, speed: float) -> FloatArray:
    """Return 1 - v/(top speed), at least 0: the arm's exact reserve of speed.

    With equal limits it is 1 - b_min/g, g = 1/max|J^-1 k|.
    """
    with np.errstate(divide="ignore"):
        return np.maximum(1.0 - speed / top_speed, 0.0)


def sure_performance(
    elements: FloatArray, low: FloatArray, high: FloatArray, top_speed: FloatArray, speed: float
) -> FloatArray:
    """min(eq. 6, speed margin): above zero only where the arm really follows the path at `speed`, in [m/s].

    Eq. 6 alone is 1 along the whole reachable chord of a straight path, up to where the arm is stretched.
    """
    return np.minimum(performance(elements, low, high), speed_margin(top_speed, speed))
