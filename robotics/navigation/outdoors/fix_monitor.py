"""Test of fixes against a filter: one alone, and many in a row."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

MAX_SQUARED_SIGMAS = 25.0  # squared sigmas, two degrees of freedom: 4 in a million good ones are beyond
RECOVERED_SQUARED_SIGMAS = 9.0  # squared sigmas of a mean that is good again
MAX_TESTED_FIXES = 24  # fixes in a row that are tested together
RECOVERY_FIX_COUNT = 5  # fixes in a row that must be good before one is believed again


class FixMonitor:
    """Detector of implausible GNSS fixes, by a filter's innovations (fixes minus their predictions).

    Single fixes and sums of fixes are tested. If signals are reflected, each fix may be shifted by less than
    the error of a single fix. Each fix then passes the test, but their sum does not, because the innovations
    of a correct filter have zero mean. Once a test has failed, all fixes are rejected, until several in a row
    agree with the filter's prediction.
    """

    STATE: ClassVar = {"_sums": list[FloatArray], "_doubted": list[FloatArray], "doubting": bool}
    """Attributes that change, with their types."""

    def __init__(self) -> None:
        """Start without a fix."""
        self._sums: list[FloatArray] = []  # normalised innovations (2,) of believed fixes
        self._doubted: list[FloatArray] = []  # residuals (2,) in [m]
        self.doubting = False
        """True while fixes are rejected until proved right."""

    def suspects(self, residual: FloatArray, covariance: FloatArray) -> int:
        """Test a fix; return how many of the latest fixes are implausible, counted back from this fix.

        If several are implausible, they are discarded, and all fixes have to be rejected until `cleared`
        returns True.

        Args:
            residual: (2,) this fix minus its prediction, along x and y of the field's frame, in [m].
            covariance: (2, 2) expected covariance of the residual, in [m²].

        Returns:
            0 if none is implausible; 1 if this fix is implausible by itself; otherwise the length of the run
                of fixes, up to this fix, whose summed residuals are the least plausible.
        """
        white = whitened(residual, covariance)
        if float(white @ white) > MAX_SQUARED_SIGMAS:
            return 1
        self._sums.append(white)
        del self._sums[:-MAX_TESTED_FIXES]
        sums = np.cumsum(np.array(self._sums)[::-1], axis=0)
        worst = (sums**2).sum(axis=1) / np.arange(1, len(sums) + 1)
        if worst.max() <= MAX_SQUARED_SIGMAS:
            return 0
        count = int(np.argmax(worst)) + 1
        del self._sums[len(self._sums) - count :]
        self.doubting = True
        self._doubted = []
        return count

    def cleared(self, residual: FloatArray, forecast: FloatArray, variance: float) -> bool:
        """Test a fix while all fixes are rejected; return True if fixes are plausible again, which resets the
        monitor.

        Args:
            residual: (2,) fix minus its prediction, along x and y of the field's frame, in [m].
            forecast: (2, 2) covariance of the prediction, whose error is common to all these fixes, in [m²].
            variance: variance of a fix's white noise along each axis, in [m²].
        """
        self._doubted.append(residual)
        del self._doubted[:-RECOVERY_FIX_COUNT]
        if len(self._doubted) < RECOVERY_FIX_COUNT:
            return False
        mean = np.mean(self._doubted, axis=0)
        whole = forecast + variance * np.eye(2)
        singles = [float(one @ np.linalg.solve(whole, one)) for one in self._doubted]
        together = float(mean @ np.linalg.solve(forecast + variance / RECOVERY_FIX_COUNT * np.eye(2), mean))
        if max(singles) > MAX_SQUARED_SIGMAS or together > RECOVERED_SQUARED_SIGMAS:
            return False
        self.reset()
        return True

    def reset(self) -> None:
        """Discard what is stored about earlier fixes, and accept fixes again."""
        self.doubting = False
        self._sums, self._doubted = [], []


def whitened(residual: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return a residual (2,) divided by the lower Cholesky factor of its covariance; the result has the
    identity as covariance.

    Args:
        residual: (2,) residual of a fix, along x and y of the field's frame, in [m].
        covariance: (2, 2) of the residual along the same axes, in [m²].
    """
    a = math.sqrt(covariance[0, 0])
    b = covariance[1, 0] / a
    c = math.sqrt(covariance[1, 1] - b * b)
    first = residual[0] / a
    return np.array([first, (residual[1] - b * first) / c])
