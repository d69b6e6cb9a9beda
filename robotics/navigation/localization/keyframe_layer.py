"""Local map of the robot's own scans, for localization where the given map explains too little.

Scans are added only after some motion (keyframes): a robot that matches each scan with the one before follows
its own noise. The covariance of a pose found among keyframes is that of the matched keyframe, carried over
to the present pose, plus the noise of the match: the uncertainty of the start stays, and each keyframe
adds to it.
"""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.scan_matching import match_scan
from handcart.robotics.numerics.arrays import FloatArray, IntArray

CELL_M = 0.04  # of the local map
WINDOW_M = 16.0  # side of the local map about the robot
MOVED_WINDOW_M = 2.0  # by which the robot has to leave its middle until it is drawn again
NEW_KEYFRAME_M, NEW_KEYFRAME_RAD = 0.3, math.radians(20.0)  # from all others, from which a scan is a keyframe
OVERLAP_M = 1.0  # within which a keyframe shows about the same as the present scan
MAX_KEYFRAMES = 150
KEYFRAME_POINTS = 240  # of a scan that are kept
MIN_POINTS = 20
MIN_INLIERS = 0.6  # share of a scan that the keyframes must explain
RELATIVE_COVARIANCE = np.diag([0.03, 0.03, 0.02]) ** 2  # [m², rad²] of the motion by wheels between two scans


class LayerMatch(NamedTuple):
    """Pose of a scan that was matched with earlier keyframes of the drive, with covariance and quality."""

    pose: Pose2
    """map_T_base."""
    covariance: FloatArray
    """(3, 3) of x, y on the map in [m] and heading in [rad], including that of the matched keyframe."""
    inliers: float
    """Share of the points that the keyframes explain, 0 to 1."""


class KeyframeLayer:
    """Map of the current drive, made of keyframes (scans with poses and covariances), to match later scans
    with.
    """

    STATE: ClassVar = {
        "_poses": FloatArray,
        "_covariances": FloatArray,
        "_points": FloatArray,
        "_owners": IntArray,
    }
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self) -> None:
        """Start without keyframes."""
        self.clear()

    def clear(self) -> None:
        """Remove all keyframes, so that scans match nothing until new ones are added."""
        self._poses, self._covariances = np.empty((0, 3)), np.empty((0, 9))
        self._points, self._owners = np.empty((0, 2)), np.empty(0, dtype=np.int64)
        self._field: LikelihoodField | None = None
        self._middle = (0.0, 0.0)

    @property
    def empty(self) -> bool:
        """True if no keyframe is stored."""
        return len(self._poses) == 0

    def take(self, points: FloatArray, pose: Pose2, covariance: FloatArray) -> bool:
        """Add a scan as a keyframe if its pose is new; return whether it was added.

        A pose is new if it differs from the poses of all keyframes by at least 0.3 m or 20 degrees.

        A scan with fewer than 20 points is not added.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
            pose: map_T_base.
            covariance: (3, 3) of the pose: x, y on the map in [m], heading in [rad].
        """
        if len(points) < MIN_POINTS or self._has_near(pose):
            return False
        some = points[np.linspace(0, len(points) - 1, min(len(points), KEYFRAME_POINTS)).astype(np.int64)]
        number = 1 + int(self._owners.max(initial=-1))
        self._poses = np.vstack([self._poses, pose])
        self._covariances = np.vstack([self._covariances, covariance.reshape(1, 9)])
        self._points = np.vstack([self._points, pose.apply(some)])
        self._owners = np.concatenate([self._owners, np.full(len(some), number)])
        if len(self._poses) > MAX_KEYFRAMES:
            self._drop_oldest()
        self._field = None
        return True

    def match(self, points: FloatArray, prior: Pose2, sigma: float) -> LayerMatch | None:
        """Return the pose at which a scan fits the keyframes best.

        The result is None if no keyframe is near, or if less than the share `MIN_INLIERS` of the scan's
        points fits.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
            prior: map_T_base, expected from the last pose and the motion of the wheels since then.
            sigma: noise of a range, in [m].
        """
        if len(points) < MIN_POINTS or self.empty:
            return None
        field = self._local_field(prior)
        found = match_scan(field, points, prior, RELATIVE_COVARIANCE, sigma)
        if found.inliers < MIN_INLIERS:
            return None
        anchored = self._anchored(found.pose)
        return (
            None if anchored is None else LayerMatch(found.pose, anchored + found.covariance, found.inliers)
        )

    def _has_near(self, pose: Pose2) -> bool:
        x, y, theta = pose
        return any(
            math.hypot(near_x - x, near_y - y) < NEW_KEYFRAME_M and abs(wrap(turn - theta)) < NEW_KEYFRAME_RAD
            for near_x, near_y, turn in reversed(self._poses.tolist())
        )

    def _anchored(self, pose: Pose2) -> FloatArray | None:
        """Return the least covariance (3, 3) of a near keyframe, carried over to a pose; None without one."""
        away = np.hypot(*(self._poses[:, :2] - pose[:2]).T)
        best: FloatArray | None = None
        for number in np.flatnonzero(away < OVERLAP_M):
            x, y, _ = self._poses[number].tolist()
            carry = np.array([[1.0, 0.0, y - pose.y], [0.0, 1.0, pose.x - x], [0.0, 0.0, 1.0]])
            carried = carry @ self._covariances[number].reshape(3, 3) @ carry.T
            if best is None or np.trace(carried) < np.trace(best):
                best = carried
        return best

    def _drop_oldest(self) -> None:
        oldest = self._owners.min()
        self._poses, self._covariances = self._poses[1:], self._covariances[1:]
        kept = self._owners != oldest
        self._points, self._owners = self._points[kept], self._owners[kept]

    def _local_field(self, here: Pose2) -> LikelihoodField:
        if self._field is None or math.dist(here[:2], self._middle) > MOVED_WINDOW_M:
            self._middle = (here.x, here.y)
            count = round(WINDOW_M / CELL_M)
            nothing = np.zeros((count, count), dtype=np.bool_)
            corner = here.x - WINDOW_M / 2, here.y - WINDOW_M / 2
            grid = GridMap(nothing, nothing, CELL_M, *corner)
            self._field = LikelihoodField(grid.with_points(self._points), is_drawn=True)
        return self._field


def differs(one: Pose2, other: Pose2, distance: float, turn: float) -> bool:
    """Return whether two poses lie apart by more than a distance in [m] or a turn in [rad]."""
    return one.distance(other) > distance or abs(wrap(one.theta - other.theta)) > turn
