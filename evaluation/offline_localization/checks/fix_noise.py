"""Estimate of a log's fix errors, from their agreement with wheels and gyros."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import FieldNoise
from handcart.robotics.navigation.outdoors.gyro_odometry import GyroOdometry
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

WINDOW_S = 10.0  # in which the fixes are fitted to the odometry's track
MIN_FIXES = 6  # in a window
MIN_WINDOWS = 3
SLOW_RATIO = 2.25  # slow error over white error of an unknown receiver
SLOW_TIME_S = 100.0  # correlation time of the slow error
LEAST_M = 0.05  # of the white error
MAX_RATIO = 3.0  # between stated and observed error: beyond it the stated one is rejected


class SupposedNoise(NamedTuple):
    """Sensor noise to assume for a vehicle without a robot's file, and the log of the vehicle's drive without
    implausible accuracies of fixes.
    """

    noise: FieldNoise
    log: DriveLog
    """The log, without the stated accuracies if they are not credible."""
    notes: list[str]


def suppose_noise(log: DriveLog, given: FieldNoise) -> SupposedNoise:
    """Return the noise to assume for a vehicle, with a log of its drive.

    The receiver's errors are estimated from the fixes if the accuracies that the log states are missing or
    not credible.

    Args:
        log: log with all fixes.
        given: noise assumed for any vehicle.
    """
    stated = log.sigmas[np.isfinite(log.fixes).all(axis=1) & (log.sigmas > 0.0)]
    seen = white_error(log.thinned(given.gps_period), given.gps_period)
    if seen is None:
        if len(stated):
            return SupposedNoise(given, log, [])
        words = f"the log states no accuracy of the fixes: {given.gps_white:.1f} m is supposed"
        return SupposedNoise(
            given, log, [f"{words}; `gps_sigma` in the log or --robot with `gps: white_m` tells it"]
        )
    noise = given._replace(gps_white=seen, gps_drift=SLOW_RATIO * seen, gps_drift_time=SLOW_TIME_S)
    believed = f"{seen:.2f} m is what wheels and gyros leave of them within {WINDOW_S:.0f} s, an axis"
    if not len(stated):
        words = f"the log states no accuracy of the fixes: {believed}"
        return SupposedNoise(noise, log, [f"{words}; {noise.gps_drift:.2f} m of slow error is supposed"])
    usual = float(np.median(stated))
    if usual < seen / MAX_RATIO or usual > seen * MAX_RATIO:
        words = f"the receiver states {usual:.2f} m, {believed}; its statement is not believed"
        return SupposedNoise(noise, log._replace(sigmas=np.full_like(log.sigmas, math.nan)), [words])
    return SupposedNoise(noise, log, [])


def white_error(log: DriveLog, period: float) -> float | None:
    """Return the standard deviation of the fixes about the track by odometry.

    In each window of time the track is rotated and shifted to fit the fixes best (Umeyama, 1991), so that
    slow errors cancel.

    Args:
        log: log with fixes about `period` apart.
        period: time between fixes, in [s].

    Returns:
        Standard deviation of a fix per axis, in [m]; None if fewer than `MIN_WINDOWS` windows have
        `MIN_FIXES` fixes and motion of more than 1 m.
    """
    found = _left(*odometry_track(log), max(WINDOW_S, MIN_FIXES * period))
    return None if found is None else max(LEAST_M, found)


def odometry_track(log: DriveLog) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return positions by odometry alone at the times of a drive's fixes, and the fixes for comparison.

    Args:
        log: recorded readings.

    Returns:
        Times (m,) of the fixes in [s], positions (m, 2) by odometry in [m], in a frame that begins at the
        start, and the fixes (m, 2) in the log's frame, in [m].
    """
    odometry, ways, rows = GyroOdometry(Pose2(0.0, 0.0, 0.0)), list[tuple[float, float]](), list[int]()
    log = log.one_row_a_time()
    steps = np.diff(log.times, prepend=log.times[0])
    known: BoolArray = np.asarray(np.isfinite(log.fixes).all(axis=1))
    for row in range(len(log.times)):
        if row:
            odometry.update(log.rates[row], log.accelerations[row], log.wheels[row], float(steps[row]))
        if known[row]:
            rows.append(row)
            ways.append((odometry.pose.x, odometry.pose.y))
    return log.times[rows], np.array(ways).reshape(-1, 2), log.fixes[rows]


def _left(times: FloatArray, ways: FloatArray, fixes: FloatArray, window: float) -> float | None:
    """Return the error of fixes per axis that remains after fitting a track to them, as median over windows,
    in [m].

    Args:
        times: (n,) times of the fixes, in [s].
        ways: (n, 2) positions by odometry, in [m].
        fixes: (n, 2) positions by fixes, in [m].
        window: length of a window, in [s].

    Returns:
        None if there are too few windows.
    """
    found = []
    for begin in np.arange(times[0], times[-1] - 0.5 * window, 0.5 * window) if len(times) else ():
        inside = np.flatnonzero(np.logical_and(times >= begin, times < begin + window))
        if len(inside) >= MIN_FIXES and np.ptp(ways[inside], axis=0).max() > 1.0:
            found.append(_misfit(ways[inside], fixes[inside]))
    return float(np.median(found)) if len(found) >= MIN_WINDOWS else None


def _misfit(ways: FloatArray, fixes: FloatArray) -> float:
    """Return the error per axis, in [m], of fixes (n, 2) relative to a track (n, 2) that is rotated and
    shifted to fit.
    """
    a, b = ways - ways.mean(axis=0), fixes - fixes.mean(axis=0)
    turn = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    cos, sin = math.cos(turn), math.sin(turn)
    left = b - a @ np.array([[cos, sin], [-sin, cos]])
    return math.sqrt(float((left**2).sum()) / (2 * len(a) - 3))
