"""Errors of many placements: their spread, as in the field test, and relative to their covariances."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


def aligned_spread(errors: FloatArray, targets: FloatArray) -> FloatArray:
    """Return the standard deviations (2,) of placement errors in x and y, in [m].

    Defined as by Ohki et al. (2012): axes turned so that the first and the last deployed point lie in the
    direction of their targets, errors relative to their mean. So they are precision, not accuracy.

    Args:
        errors: (n, 2) deployed points less their targets, in [m].
        targets: (n, 2) in the same frame, in [m].
    """
    laid = targets + errors
    (ax, ay), (bx, by) = laid[-1] - laid[0], targets[-1] - targets[0]
    turn = math.atan2(by, bx) - math.atan2(ay, ax)
    cos, sin = math.cos(turn), math.sin(turn)
    away: FloatArray = laid @ np.array([[cos, sin], [-sin, cos]]) - targets
    return np.asarray(away.std(axis=0, ddof=1))


def nees(errors: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return the normalized squared errors (n,), without unit: 2 on average if the covariances are honest.

    Args:
        errors: (n, 2) in [m].
        covariances: (n, 2, 2) in [m²].
    """
    return np.asarray(np.einsum("ni,nij,nj->n", errors, np.linalg.inv(covariances), errors))
