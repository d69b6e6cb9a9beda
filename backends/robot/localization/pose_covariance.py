"""Covariances of a pose: its sigmas, and the part that does not repeat."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.covariances import remove_part

SCAN_REPEATABILITY = np.diag([0.004, 0.004, 0.0015]) ** 2  # [m², rad²]: scatter of scan matches at one place


def worst_sigmas(covariance: FloatArray) -> tuple[float, float]:
    """Return the sigma of a position along its worst direction in [m], and of the heading in [rad].

    Args:
        covariance: (3, 3) covariance of x, y in [m], in any frame, and heading in [rad].
    """
    (xx, _, _), (xy, yy, _), (_, _, turn) = covariance.tolist()
    worst = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
    return math.sqrt(max(0.0, worst)), math.sqrt(max(0.0, turn))


def repeatability_of(covariance: FloatArray, map_error: FloatArray) -> FloatArray:
    """Return the covariance (3, 3) of a pose relative to another pose that scans measured at the same place.

    The result is in the frame and units of `covariance`. It does not contain the map's error, which both
    poses share, and is never below the noise of scan matching.

    Args:
        covariance: (3, 3) covariance of the pose: x and y on the map in [m], heading in [rad].
        map_error: (3, 3) part of `covariance` that errors of the map cause, in the same frame and units.
    """
    return np.asarray(remove_part(covariance, map_error) + SCAN_REPEATABILITY)
