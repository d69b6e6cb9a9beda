"""Accuracy of a least-squares result whose measurements have errors in groups."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.numerics.arrays import FloatArray

_WORST_CONDITION = 1e12
_POSE = 6  # maximum independent numbers of a group: a pose has six


def clustered_sigmas(
    jacobian: FloatArray, residuals: FloatArray, groups: NDArray[np.integer], best: float = 0.0
) -> FloatArray:
    """Return standard deviations of parameters found by least squares.

    Measurements from one posture of an arm share the error of that posture: they form a group. The residuals
    of a group are summed before they are squared, as in the clustered "sandwich" estimate of Liang and Zeger
    (1986). In the number of observations, a group counts as at most six, because a pose has six numbers.

    Args:
        jacobian: (n, k) derivative of the residuals by the parameters, at the result.
        residuals: (n,) all in the same unit, of any kind.
        groups: (n,) number of each residual's group, from 0.
        best: lower bound of the residuals' root mean square, in their unit.

    Returns:
        (k,) in the units of the parameters; infinite for parameters that the measurements do not
            determine.
    """
    parameters = jacobian.shape[1]
    scales = np.linalg.norm(jacobian, axis=0)
    observations = float(np.minimum(np.bincount(groups), _POSE).sum())
    if (scales == 0.0).any() or observations <= parameters:
        return np.where((scales == 0.0) | (observations <= parameters), np.inf, 0.0)
    scaled = jacobian / scales
    normal = scaled.T @ scaled
    if np.linalg.cond(normal) > _WORST_CONDITION:
        return np.full(parameters, np.inf)
    scores = np.zeros((int(groups.max()) + 1, parameters))
    np.add.at(scores, groups, scaled * residuals[:, None])
    middle = scores.T @ scores * observations / (observations - parameters) + best**2 * normal
    outer = np.linalg.inv(normal)
    return np.asarray(np.sqrt(np.diag(outer @ middle @ outer)) / scales)
