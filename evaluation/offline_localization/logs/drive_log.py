"""Recorded sensor readings of an outdoor drive."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from handcart.robotics.navigation.beacons.beacon_errors import BeaconErrors
from handcart.robotics.numerics.arrays import FloatArray, IntArray

MIN_PERIOD_SHARE = 0.8  # of a receiver's period: fixes are not exactly periodic


class BeaconLog(NamedTuple):
    """Recorded ranges to radio beacons, with the beacons' positions and the errors of the ranges."""

    errors: BeaconErrors
    """Positions of the beacons, and the errors of their ranges."""
    ranges: FloatArray
    """(n, k) ranges to k beacons, in [m]."""


class DriveLog(NamedTuple):
    """Log of a drive with sensor readings in order of time; NaN where a row has no new reading.

    The world frame has x east, y north; the base frame has x forward, y left, z up.
    """

    times: FloatArray
    """(n,) in [s], increasing."""
    rates: FloatArray
    """(n, 3) turn rates of the gyros, in [rad/s]."""
    accelerations: FloatArray
    """(n, 3) accelerations, in [m/s²]."""
    wheels: FloatArray
    """(n, 2) travel of the left and right wheel since the previous row, in [m]."""
    fixes: FloatArray
    """(n, 2) positions of the antenna, east and north in [m]."""
    sigmas: FloatArray
    """(n,) standard deviation of a fix per axis that the receiver states, in [m]; NaN if it states none."""
    reference: FloatArray
    """(n, 3) true pose of the base: x, y in [m], heading in [rad]; NaN where it is unknown."""
    start: tuple[float, float, float]
    """Pose of the base before the first row: x, y in [m], heading in [rad]; NaN where it is unknown."""
    antenna: tuple[float, float, float] | None
    """Position of the antenna in the base frame, in [m]; None: as in the robot's file."""
    steered: bool = False
    """True if `rates` come from steering or wheels, without a gyro."""
    beacons: BeaconLog | None = None
    """Ranges to beacons; None without beacons."""
    odometry_turns: FloatArray | None = None
    """(n,) turn rate by the wheels' odometry, in [rad/s]; NaN without a new reading; None without
    odometry.
    """
    notes: tuple[str, ...] = ()
    """Messages about tolerable faults of the log."""
    origin: tuple[float, float] | None = None
    """Latitude and longitude of the origin of a reference in degrees, in [deg]; None for others."""

    def thinned(self, period: float) -> DriveLog:
        """Return the log with fixes at least about `period` [s] apart: the errors of closer fixes are
        correlated.
        """
        fixes, latest = self.fixes.copy(), -np.inf
        for row in np.flatnonzero(np.isfinite(fixes).all(axis=1)):
            if self.times[row] < latest + MIN_PERIOD_SHARE * period:
                fixes[row] = np.nan
            else:
                latest = self.times[row]
        return self._replace(fixes=fixes)

    def one_row_a_time(self) -> DriveLog:
        """Return the log with rows of equal time merged.

        A merged row has the latest value of each reading, and the sum of the wheels' travel.
        """
        if (np.diff(self.times) > 0.0).all():
            return self
        starts = np.flatnonzero(np.diff(self.times, prepend=-np.inf) > 0.0)
        travel = np.add.reduceat(np.nan_to_num(self.wheels), starts)
        ends = np.append(starts[1:], len(self.times))
        latest: dict[str, Any] = {name: _latest(getattr(self, name), starts, ends) for name in _READINGS}
        if self.odometry_turns is not None:
            latest["odometry_turns"] = _latest(self.odometry_turns, starts, ends)
        if self.beacons is not None:
            each = [_latest(column, starts, ends) for column in self.beacons.ranges.T]
            latest["beacons"] = self.beacons._replace(ranges=np.stack(each, axis=1))
        return self._replace(times=self.times[starts], wheels=travel, **latest)


_READINGS = ("rates", "accelerations", "fixes", "sigmas", "reference")


def _latest(values: FloatArray, starts: IntArray, ends: IntArray) -> FloatArray:
    """Return the last known row of `values` in each group of rows; NaN if none is known.

    Args:
        values: (n,) or (n, m) readings in any unit; NaN without a new one.
        starts: (k,) first row of each group.
        ends: (k,) row after the last of each group.

    Returns:
        (k,) or (k, m).
    """
    known = np.isfinite(values) if values.ndim == 1 else np.isfinite(values).all(axis=1)
    rows = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))[ends - 1]
    found = values[rows]
    found[rows < starts] = np.nan
    return found
