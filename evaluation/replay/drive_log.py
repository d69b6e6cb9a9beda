"""What a robot's sensors read on a drive outdoors, as it was recorded."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.navigation.beacons.beacon_errors import BeaconErrors

NEARLY = 0.8  # of a receiver's period: fixes don't come to the millisecond
Array = NDArray[np.float64]


class BeaconLog(NamedTuple):
    """What radio beacons told."""

    errors: BeaconErrors
    """Where they are, and how wrong."""
    ranges: Array
    """(n, k) in [m]."""


class DriveLog(NamedTuple):
    """Readings in the order of time; NaN where nothing new came.

    World is x east, y north; base is x forward, y left, z up.
    """

    times: Array
    """(n,) in [s], rising."""
    rates: Array
    """(n, 3) of the gyros, in [rad/s]."""
    accelerations: Array
    """(n, 3) in [m/s²]."""
    wheels: Array
    """(n, 2) travel of the left and right wheel since the row before, in [m]."""
    fixes: Array
    """(n, 2) of the antenna, east and north in [m]."""
    sigmas: Array
    """(n,) what the receiver says of a fix, an axis, in [m]; NaN where it doesn't."""
    reference: Array
    """(n, 3) where the base really was: x, y in [m], heading in [rad]; NaN where that isn't known."""
    start: tuple[float, float, float]
    """x, y in [m], heading in [rad] of the base before the first row; NaN where nobody knows."""
    antenna: tuple[float, float, float] | None
    """In the base frame, in [m]; None: as the robot's file says."""
    steered: bool = False
    """Whether `rates` are those of a steering angle: there is no gyro."""
    beacons: BeaconLog | None = None
    """None where there were none."""
    odometry_turns: Array | None = None
    """(n,) turn rate by the wheels' odometry, in [rad/s]; NaN where nothing new came; None without one."""
    notes: tuple[str, ...] = ()
    """What is wrong with the log and can be lived with, in words."""

    def thinned(self, period: float) -> DriveLog:
        """With fixes about `period` [s] apart at least: those in between mostly err alike."""
        fixes, latest = self.fixes.copy(), -np.inf
        for row in np.flatnonzero(np.isfinite(fixes).all(axis=1)):
            if self.times[row] < latest + NEARLY * period:
                fixes[row] = np.nan
            else:
                latest = self.times[row]
        return self._replace(fixes=fixes)

    def one_row_a_time(self) -> DriveLog:
        """Rows of the same time put together: the latest of each reading, and all of the travel."""
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


def _latest(values: Array, starts: NDArray[np.int64], ends: NDArray[np.int64]) -> Array:
    """The last row between each start and end that tells anything; NaN where none does."""
    known = np.isfinite(values) if values.ndim == 1 else np.isfinite(values).all(axis=1)
    rows = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))[ends - 1]
    found = values[rows]
    found[rows < starts] = np.nan
    return found
