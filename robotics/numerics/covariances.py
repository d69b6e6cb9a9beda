"""Covariances of which a part is known."""

from __future__ import annotations

import numpy as np

from .arrays import FloatArray


def remove_part(covariance: FloatArray, part: FloatArray) -> FloatArray:
    """Subtract an error's covariance from a covariance (3, 3) that contains the error, and return the rest.

    Negative variances of the rest are set to zero.

    Args:
        covariance: (3, 3) covariance of x, y in [m], in any frame, and heading in [rad].
        part: (3, 3) covariance to subtract, in the same frame and units.
    """
    rest = covariance - part
    if _is_positive(rest):
        return rest
    variances, axes = np.linalg.eigh(rest)
    return np.asarray((axes * np.maximum(variances, 0.0)) @ axes.T)


def _is_positive(matrix: FloatArray) -> bool:
    """Return whether a symmetric matrix (3, 3) has no variance of 0 or below: its leading minors."""
    (a, _, _), (b, c, _), (d, e, f) = matrix.tolist()
    minor = a * c - b * b
    return bool(a > 0.0 and minor > 0.0 and f * minor > a * e * e - 2.0 * b * d * e + c * d * d)
