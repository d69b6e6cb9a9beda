"""Keep roll and pitch of a vehicle that never stands from drifting away with its gyros' biases."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.evaluation.replay.drive_log import DriveLog

WINDOW_S = 30.0  # over which a vehicle's roll and pitch come back to what they were
Array = NDArray[np.float64]


def without_tilt_drift(log: DriveLog) -> DriveLog:
    """Take out of the gyros about x and y what is left of them on average over half a minute.

    Odometry knows these biases only from a stand. A vehicle that never stands would be reckoned to tip over
    within minutes. No vehicle goes on rolling one way, so the average is the bias.
    """
    rates = log.rates.copy()
    for axis in (0, 1):
        rows = np.flatnonzero(np.isfinite(rates[:, axis]))
        if len(rows) > 1:
            rates[rows, axis] -= _moving_mean(log.times[rows], rates[rows, axis])
    return log._replace(rates=rates)


def _moving_mean(times: Array, values: Array) -> Array:
    """Return (n,) the mean of values (n,) within half of `WINDOW_S` before and after each."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    first = np.searchsorted(times, times - 0.5 * WINDOW_S, side="left")
    last = np.searchsorted(times, times + 0.5 * WINDOW_S, side="right")
    return np.asarray((sums[last] - sums[first]) / (last - first))
