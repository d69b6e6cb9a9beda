"""Figures of merit of many placements: as the field test had them, and as they should be had."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


def aligned_spread(errors: FloatArray, targets: FloatArray) -> FloatArray:
    """Return the standard deviations (2,) in x and y of errors (n, 2) of targets (n, 2), in [m].

    Defined as by Ohki et al. (2012): axes turned so that the first and the last deployed point lie in the
    direction of their targets, errors relative to their mean. So they are precision, not accuracy.
    """
    laid = targets + errors
    (ax, ay), (bx, by) = laid[-1] - laid[0], targets[-1] - targets[0]
    turn = math.atan2(by, bx) - math.atan2(ay, ax)
    cos, sin = math.cos(turn), math.sin(turn)
    away: FloatArray = laid @ np.array([[cos, sin], [-sin, cos]]) - targets
    return np.asarray(away.std(axis=0, ddof=1))


def nees(errors: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return (n,) squared errors (n, 2) in units of their covariances (n, 2, 2): 2 on average if honest."""
    return np.asarray(np.einsum("ni,nij,nj->n", errors, np.linalg.inv(covariances), errors))
