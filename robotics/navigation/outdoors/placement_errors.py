"""Errors of many placements: their spread, as in the field test, and relative to their covariances."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


def aligned_spread(errors: FloatArray, targets: FloatArray) -> FloatArray:
    """Return the standard deviations (2,) of placement errors in x and y, in [m], as Ohki et al. (2012)
    define them.

    The placed points are first turned so that the line from the first to the last of them has the direction
    of the line between their targets. Errors are then taken relative to their mean. So the result is
    precision, not accuracy.

    Args:
        errors: (n, 2) placed points less their targets, along x and y of any one frame, in [m].
        targets: (n, 2) in the same frame, in [m].
    """
    laid = targets + errors
    (ax, ay), (bx, by) = laid[-1] - laid[0], targets[-1] - targets[0]
    turn = math.atan2(by, bx) - math.atan2(ay, ax)
    cos, sin = math.cos(turn), math.sin(turn)
    away: FloatArray = laid @ np.array([[cos, sin], [-sin, cos]]) - targets
    return np.asarray(away.std(axis=0, ddof=1))


def nees(errors: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return the squared errors (n,) normalized by their covariances, without unit.

    The results are 2 on average if the covariances are right.

    Args:
        errors: (n, 2) errors in x and y of any one frame, in [m].
        covariances: (n, 2, 2) estimated covariance of each error along the same axes, in [m²].
    """
    return np.asarray(np.einsum("ni,nij,nj->n", errors, np.linalg.inv(covariances), errors))
