"""Possible changes of the fixes' slow error since the last fix, and the likelihood of a fix after each."""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.robotics.navigation.outdoors.field_model import GPS_X, GPS_Y
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled


class Sky(NamedTuple):
    """Possible GNSS condition at a fix (the error of fixes is unchanged, or has jumped) with its
    likelihood.
    """

    transition: FloatArray | None
    """Transition (13, 13) of the states; None if the error did not change."""
    spread: FloatArray
    """Covariance (13, 13) of the states after the change, in SI units."""
    residual: FloatArray
    """(2,) fix less forecast, in [m]."""
    whole: FloatArray
    """Expected covariance (2, 2) of the residual, in [m²]."""
    log_likelihood: float
    """Log-likelihood of the fix together with the error's change."""

    @classmethod
    def of(
        cls,
        transition: FloatArray | None,
        spread: FloatArray,
        rows: FloatArray,
        residual: FloatArray,
        variance: float,
        log_share: float,
    ) -> Sky:
        """Return a possible GNSS condition, in which the error of fixes is unchanged or has jumped, with its
        likelihood.

        Args:
            transition: (13, 13) transition matrix of the states by the jump of the error; None: no jump.
            spread: (13, 13) covariance of the states of `FieldModel` after the jump, in SI units.
            rows: (2, 13) derivative of a fix by the states, in SI units.
            residual: (2,) fix less its forecast, along x and y of the field's frame, in [m].
            variance: variance of the fix along each axis, in [m²].
            log_share: logarithm of the condition's probability; 0 if it is added to the likelihood later.
        """
        whole, log_likelihood = _innovation(spread, rows, residual, variance)
        return cls(transition, spread, residual, whole, log_share + log_likelihood)


@compiled
def leapt(covariance: FloatArray, jump: float) -> FloatArray:
    """Return the covariance (13, 13) of the states after a jump of the GNSS error to an unknown value.

    Args:
        covariance: (13, 13) of the states of `FieldModel` before the jump, in SI units.
        jump: standard deviation of the jump along each axis of the field's frame, in [m].
    """
    out = covariance.copy()
    for state in (GPS_X, GPS_Y):
        out[state, :] = 0.0
        out[:, state] = 0.0
        out[state, state] = jump * jump
    return out


@compiled
def log_normal(residual: FloatArray, covariance: FloatArray) -> float:
    """Return the logarithm of the normal density of a residual, with mean zero and given covariance.

    Args:
        residual: (2,) residual along x and y of any one frame, in [m].
        covariance: (2, 2) of the residual along the same axes, in [m²].

    Raises:
        ValueError: the covariance is not positive definite.
    """
    a, b, c = covariance[0, 0], covariance[1, 0], covariance[1, 1]
    size = a * c - b * b
    if not size > 0.0:
        raise ValueError("no covariance: its determinant isn't positive")
    first, second = residual
    square = (c * first * first - 2.0 * b * first * second + a * second * second) / size
    return float(-0.5 * (math.log(4.0 * math.pi**2 * size) + square))


@compiled
def _innovation(
    spread: FloatArray, rows: FloatArray, residual: FloatArray, variance: float
) -> tuple[FloatArray, float]:
    """Covariance (2, 2) of a fix's residual, and the logarithm of how likely it is."""
    whole = rows @ spread @ rows.T
    whole[0, 0] += variance
    whole[1, 1] += variance
    return whole, log_normal(residual, whole)
