"""Ranges of a base that hardly moves, averaged over scans, so that it does not creep along with the noise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handcart.backends.capabilities.scan import Scan
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

SAME_POSE_M, SAME_POSE_RAD = 0.004, 0.005  # of motion since the average began
SAME_SURFACE_M = 0.04  # between a range and its average; more is another surface, and the range itself counts
MIN_WEIGHT = 0.1  # of the latest scan: a slowly approaching obstacle must not be averaged away


class AveragedScan:
    """Running average of a lidar's ranges, beam by beam, while the base moves less than a few millimetres.

    Without averaging, the ranges' noise would make the base creep when an obstacle stops it.
    """

    def __init__(self, pose: Callable[[], Pose2]) -> None:
        """Average while `pose`, which returns the base's pose without jumps, stays about the same."""
        self._pose = pose
        self.restart()

    def restart(self) -> None:
        """Discard all scans averaged so far."""
        self._scan: Scan | None = None
        self._average: FloatArray = np.empty(0)
        self._count = 0
        self._began = Pose2(0.0, 0.0, 0.0)

    def take(self, scan: Scan) -> Scan:
        """Add a scan to the running average, and return the scan with averaged ranges (n,), in [m].

        The same scan is added only once. A range that differs by `SAME_SURFACE_M` or more from the average of
        its beam is returned unchanged.
        """
        pose = self._pose()
        apart = pose.distance(self._began) > SAME_POSE_M or pose.turn(self._began) > SAME_POSE_RAD
        if apart or self._count == 0 or len(scan.ranges) != len(self._average):
            self._average, self._count, self._began, self._scan = scan.ranges, 1, pose, scan
            return scan
        if scan is not self._scan:
            self._count, self._scan = self._count + 1, scan
            ranges, average = scan.ranges.copy(), self._average
            both = np.isfinite(ranges) & np.isfinite(average)
            off = ranges[both] - average[both]
            averaged = average[both] + max(1.0 / self._count, MIN_WEIGHT) * off
            ranges[both] = np.where(np.abs(off) < SAME_SURFACE_M, averaged, ranges[both])
            self._average = ranges
        return scan._replace(ranges=self._average)
