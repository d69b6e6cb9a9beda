"""People around a base that localizes itself: their points are not walls, and they hide some walls."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from handcart.backends.capabilities.scan import Scan
from handcart.backends.plain_values import Kinds
from handcart.robotics.far import FarArray
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import (
    NUDGE_COVARIANCE,
    SEARCH_COVARIANCE,
)
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.rest_comparison import disagreement, share_moved
from handcart.robotics.navigation.scans.scan_matching import match_scan
from handcart.robotics.numerics.arrays import FloatArray

MIN_KEPT_SHARE = 0.3  # of a scan's points that must be left beside people
MIN_INLIER_SHARE = 0.7  # of points that the map explains, below which the pose is looked for farther away
CLEAR_DIFFERENCE = 0.02  # of two disagreements, from which a motion explains the scan better
SMALL_MOTION_M, SMALL_TURN_RAD = 0.04, 0.02  # up to which beams still see the same surfaces
RANGE_SIGMA_M = 0.01  # of a range; only sets how many beams are needed
NO_DISCS = np.empty((0, 3))


class Crowd:
    """Filter of lidar scans near people, for localization.

    It removes points on people, and finds out whether people hide the walls from a base at rest.
    """

    STATE: ClassVar[Kinds] = {"_ranges": FarArray, "_is_near": bool}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self) -> None:
        """Start without people."""
        self._discs = NO_DISCS
        self._ranges = np.empty(0)
        """Ranges (n,) of the scan with which the base came to rest, in [m]."""
        self._is_near = False

    @property
    def is_near(self) -> bool:
        """True if a person was near the base at any time since the base last moved."""
        return self._is_near

    def put(self, discs: FloatArray) -> None:
        """Set the people whose points are left out of the next scan.

        Args:
            discs: (k, 3) people as x and y on the map and radius, in [m].
        """
        self._discs = discs
        self._is_near = self._is_near or len(discs) > 0

    def passed(self) -> None:
        """Forget the people's positions at the end of a period."""
        self._discs = NO_DISCS

    def moved(self) -> None:
        """Forget people who came near while the base was at rest (set `is_near` False), because it moves."""
        self._is_near = False

    def came_to_rest(self, scan: Scan) -> None:
        """Store the scan that was taken when the base came to rest, for comparison with later scans."""
        self._ranges = scan.ranges.copy()

    def without(self, points: FloatArray, pose: Pose2) -> FloatArray:
        """Return the points (m, 2) of a scan that are not on people, in the base frame, in [m]; all points if
        at most the share `MIN_KEPT_SHARE` of them would be left.

        Args:
            points: (n, 2) in the base frame, in [m].
            pose: map_T_base.
        """
        if not len(self._discs):
            return points
        there = pose.apply(points)[:, None] - self._discs[None, :, :2]
        kept = (np.hypot(there[..., 0], there[..., 1]) > self._discs[None, :, 2]).all(axis=1)
        return points[kept] if kept.sum() > MIN_KEPT_SHARE * len(points) else points

    def hides_walls(self, scan: Scan, pose: Pose2, field: LikelihoodField | None, rolled: Pose2) -> bool:
        """Return True if people who hide walls explain why the scan of a base at rest does not fit the map.

        False if the base was moved, which is the other explanation.

        The few walls that are still visible may be drawn on the map with errors, so that matching this scan
        to the map shows a motion that did not happen. The check compares this scan with the scan taken when
        the base came to rest: if the two scans agree better without that motion than with it, the base has
        not moved. For a small motion the ranges of the same beams are compared.

        Args:
            scan: scan of this period.
            pose: believed map_T_base.
            field: likelihood field of the map; None without a map.
            rolled: pose of the base by the wheels in the base frame at rest; zero if the wheels did not turn.
        """
        if not self._is_near or field is None or self._ranges.shape != scan.ranges.shape:
            return False
        now = self.without(scan.points(), pose)
        then = rolled.inverse().apply(scan._replace(ranges=self._ranges).points())
        match = match_scan(field, now, pose, NUDGE_COVARIANCE)
        if match.inliers < MIN_INLIER_SHARE:
            match = match_scan(field, now, pose, SEARCH_COVARIANCE, anneal=True)
        motion = match.pose.relative_to(pose)
        if math.hypot(motion.x, motion.y) < SMALL_MOTION_M and abs(motion.theta) < SMALL_TURN_RAD:
            before = _beam_ends(scan, self._ranges, pose, self._discs)
            after, sensor = _beam_ends(scan, scan.ranges, pose, self._discs), np.array(scan.base_T_sensor[:2])
            share = share_moved(before, after, sensor, rolled, motion, RANGE_SIGMA_M)
            if share is not None:
                return share < 0.5
        there = motion.apply(now)
        return disagreement(then, now) <= disagreement(then, there) + CLEAR_DIFFERENCE


def _beam_ends(scan: Scan, ranges: FloatArray, pose: Pose2, discs: FloatArray) -> FloatArray:
    """Return the ends of all beams (n, 2) in the base frame, in [m]; NaN without an echo, or on people.

    Args:
        scan: scan of this period, with n beams.
        ranges: (n,) ranges of the same beams, of this scan or an earlier one, in [m].
        pose: map_T_base.
        discs: (k, 3) people as x, y on the map and radius, in [m].
    """
    lengths = np.where(np.isfinite(ranges), ranges, np.nan)
    rays = np.column_stack([np.cos(scan.angles), np.sin(scan.angles)])
    ends = scan.base_T_sensor.apply(lengths[:, None] * rays)
    off = pose.apply(ends)[:, None] - discs[None, :, :2]
    on_people = np.any(np.hypot(off[..., 0], off[..., 1]) <= discs[None, :, 2], axis=1)
    return np.asarray(np.where(np.reshape(on_people, (-1, 1)), np.nan, ends))
