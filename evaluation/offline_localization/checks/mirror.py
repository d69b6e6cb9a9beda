"""Detection of fixes with exchanged axes: they are the mirror image of the odometry's track."""

from __future__ import annotations

import numpy as np

from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.robotics.numerics.arrays import FloatArray

from .fix_noise import odometry_track

WINDOW_S = 90.0
MIN_FIXES = 10  # in a window
MIN_WIDTH_M = 4.0  # of the track's narrower side, to show in which direction it bends
MAX_MISFIT_SHARE = 0.1  # of the fixes' squared spread
MIN_VOTE_SHARE = 0.8  # of the windows
MIRROR_TEXT = (
    "the fixes are the mirror image of the way by wheels and gyros: latitude and longitude (east and north) "
    "are exchanged, or the gyro turns the other way"
)


def check_mirror(log: DriveLog, period: float) -> str:
    """Return a message if the fixes of a log are a mirror image of its odometry; otherwise an empty text.

    The text is also empty if the track is too straight to decide.

    Args:
        log: log with all fixes.
        period: approximate time between the fixes that are used, in [s].
    """
    times, ways, fixes = odometry_track(log.thinned(period))
    votes = []
    for begin in np.arange(times[0], times[-1], 0.5 * WINDOW_S) if len(times) else ():
        inside = (times >= begin) & (times < begin + WINDOW_S)
        if inside.sum() >= MIN_FIXES:
            votes += _vote(ways[inside], fixes[inside])
    return MIRROR_TEXT if votes and float(np.mean(votes)) >= MIN_VOTE_SHARE else ""


def _vote(ways: FloatArray, fixes: FloatArray) -> list[bool]:
    """Return whether a window's fixes are mirrored, as the only element; empty if the window does not show
    it.

    Args:
        ways: (n, 2) positions by odometry, in [m].
        fixes: (n, 2) positions by fixes, in [m].
    """
    a, b = ways - ways.mean(axis=0), fixes - fixes.mean(axis=0)
    if np.linalg.svd(a, compute_uv=False)[1] / np.sqrt(len(a)) < 0.5 * MIN_WIDTH_M:
        return []
    turned, *_ = np.linalg.lstsq(a, b, rcond=None)
    left = float(((b - a @ turned) ** 2).sum() / (b**2).sum())
    return [float(np.linalg.det(turned)) < 0.0] if left < MAX_MISFIT_SHARE else []
