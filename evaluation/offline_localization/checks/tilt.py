"""Removal of the drift in roll and pitch of a vehicle that never stops."""

from __future__ import annotations

import numpy as np

from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.robotics.numerics.arrays import FloatArray

WINDOW_S = 30.0  # within which roll and pitch of a vehicle return to their mean


def without_tilt_drift(log: DriveLog) -> DriveLog:
    """Return a log in which the bias is subtracted from the rates of the x and y gyros.

    The bias is estimated as the moving average of the rates over half a minute. Odometry estimates gyro
    biases only at a standstill; for a vehicle that never stops, the computed roll and pitch would drift
    without limit. No vehicle keeps rolling to one side, so the average is the bias.
    """
    rates = log.rates.copy()
    for axis in (0, 1):
        rows = np.flatnonzero(np.isfinite(rates[:, axis]))
        if len(rows) > 1:
            rates[rows, axis] -= _moving_mean(log.times[rows], rates[rows, axis])
    return log._replace(rates=rates)


def _moving_mean(times: FloatArray, values: FloatArray) -> FloatArray:
    """Return the mean (n,) of values (n,) within half of `WINDOW_S` before and after each of times (n,), in
    [s].
    """
    sums = np.concatenate([[0.0], np.cumsum(values)])
    first = np.searchsorted(times, times - 0.5 * WINDOW_S, side="left")
    last = np.searchsorted(times, times + 0.5 * WINDOW_S, side="right")
    return np.asarray((sums[last] - sums[first]) / (last - first))
