"""Limits that sums of uniform and normal errors keep as often as normal ones keep 3 sigma."""

from __future__ import annotations

import numpy as np

from .arrays import FloatArray

BEYOND_3_SIGMA = 0.0026998  # share of normally distributed errors
MIN_SIGMA_RATIO = 0.02  # of the bound: noise of less changes nothing
BISECTION_COUNT = 24
FREQUENCY_COUNT = 600  # at which the characteristic function is evaluated, up to 6 / sigma


def uniform_limits(bounds: FloatArray, sigmas: FloatArray) -> FloatArray:
    """Return 3-sigma limits (k,) for sums of uniformly distributed errors with normally distributed noise.

    The magnitude of a sum exceeds its limit with a probability of 0.27 %, like that of a normal error beyond
    3 sigma. The distribution of each sum is computed from its characteristic function (Gil-Pelaez, 1951).

    Args:
        bounds: (k, n) largest magnitude of each error of a sum, in any one unit.
        sigmas: (k,) standard deviation of the noise of each sum, in the same unit, as are the limits.
    """
    total = bounds.sum(axis=1)
    spread = np.maximum(np.maximum(sigmas, MIN_SIGMA_RATIO * total), 1e-12)
    at = (np.arange(FREQUENCY_COUNT) + 0.5) * (6.0 / FREQUENCY_COUNT) / spread[:, None]
    values = np.exp(-0.5 * (at * spread[:, None]) ** 2)
    for item in bounds.T:
        values = values * np.sinc(at * item[:, None] / np.pi)
    step = (6.0 / FREQUENCY_COUNT) / spread
    low, high = np.zeros(len(total)), total + 4.0 * spread
    for _ in range(BISECTION_COUNT):
        middle = 0.5 * (low + high)
        within = (np.sin(at * middle[:, None]) / at * values).sum(axis=1) * step * (2.0 / np.pi)
        too_low = 1.0 - within > BEYOND_3_SIGMA
        low, high = np.where(too_low, middle, low), np.where(too_low, high, middle)
    return np.asarray(high)
