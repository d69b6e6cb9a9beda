"""Ranges of a base that hardly moves, averaged over scans, so that it does not creep along with the noise."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from handcart.backends.capabilities.scan import Scan
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

SAME_POSE_M, SAME_POSE_RAD = 0.001, 0.005  # of motion, within which the beams are the same
CREEPING_M = 0.004  # of motion between two scans, through which the average is carried
SAME_SURFACE_M = 0.04  # between a range and its average; more is another surface, and the range itself counts
MAX_GAP_SPACINGS = 2.5  # between two ranges of which the range between them is known
MIN_WEIGHT = 0.1  # of the latest scan: a slowly approaching obstacle must not be averaged away


class AveragedScan:
    """Running average of a lidar's ranges, beam by beam, while the base moves less than a few millimetres
    from scan to scan.

    Without averaging, the ranges' noise would make the base creep when an obstacle stops it. The average is
    carried through slow motion and turns in place, because a held base that turns to and fro would creep,
    too.
    """

    def __init__(self, pose: Callable[[], Pose2], turns_freely: bool = True) -> None:
        """Average while `pose`, which returns the base's pose without jumps, stays about the same.

        A base that does not turn freely (`turns_freely`), because its corners need room, begins again with
        each turn.
        """
        self._pose, self._turns_freely = pose, turns_freely
        self.restart()

    def restart(self) -> None:
        """Discard all scans averaged so far."""
        self._scan: Scan | None = None
        self._average: FloatArray = np.empty(0)
        self._count = 0
        self._at = Pose2(0.0, 0.0, 0.0)

    def take(self, scan: Scan) -> Scan:
        """Add a scan to the running average, and return the scan with averaged ranges (n,), in [m].

        The same scan is added only once. A range that differs by `SAME_SURFACE_M` or more from the average of
        its beam is returned unchanged.
        """
        pose = self._pose()
        apart = pose.distance(self._at) > CREEPING_M
        apart |= not self._turns_freely and pose.turn(self._at) > SAME_POSE_RAD
        if apart or self._count == 0 or len(scan.ranges) != len(self._average):
            self._average, self._count, self._at, self._scan = scan.ranges, 1, pose, scan
            return scan
        if scan is not self._scan:
            moved = pose.distance(self._at) > SAME_POSE_M or pose.turn(self._at) > SAME_POSE_RAD
            if self._turns_freely and moved:
                self._average, self._at = _carried(self._average, scan, pose.relative_to(self._at)), pose
            self._count, self._scan = self._count + 1, scan
            ranges, average = scan.ranges.copy(), self._average
            both = np.isfinite(ranges) & np.isfinite(average)
            off = ranges[both] - average[both]
            averaged = average[both] + max(1.0 / self._count, MIN_WEIGHT) * off
            ranges[both] = np.where(np.abs(off) < SAME_SURFACE_M, averaged, ranges[both])
            self._average = ranges
        return scan._replace(ranges=self._average)


def _carried(ranges: FloatArray, scan: Scan, motion: Pose2) -> FloatArray:
    """Return the ranges (n,) in [m] of a base that has moved, by those before; NaN where they are unknown.

    Args:
        ranges: (n,) ranges before the motion, in [m].
        scan: scan with the angles of the beams.
        motion: pose of the base in its frame before the motion.
    """
    seen = np.flatnonzero(np.isfinite(ranges))
    if len(seen) < 2:
        return np.full(len(ranges), np.nan)
    sensor = scan.base_T_sensor
    moved = motion.compose(sensor).relative_to(sensor)
    rays = np.column_stack([np.cos(scan.angles[seen]), np.sin(scan.angles[seen])])
    x, y = moved.inverse().apply(ranges[seen, None] * rays).T
    bearings, lengths = np.arctan2(y, x), np.hypot(x, y)
    order = np.argsort(bearings)
    bearings, lengths = bearings[order], lengths[order]
    bearings = np.concatenate([bearings[-1:] - 2.0 * np.pi, bearings, bearings[:1] + 2.0 * np.pi])
    lengths = np.concatenate([lengths[-1:], lengths, lengths[:1]])
    wanted = np.arctan2(np.sin(scan.angles), np.cos(scan.angles))
    after = np.searchsorted(bearings, wanted).clip(1, len(bearings) - 1)
    gap, step = np.diff(bearings)[after - 1], np.abs(np.diff(lengths))[after - 1]
    spacing = np.ptp(scan.angles) / (len(scan.angles) - 1)
    is_known = (gap < MAX_GAP_SPACINGS * spacing) & (step < SAME_SURFACE_M)
    return np.where(is_known, np.interp(wanted, bearings, lengths), np.nan)
