"""Pose of a robot among things that its map does not show, by its own keyframes and the rest of the map.

A scan that the map explains too little of does not make the robot lost if the robot's own keyframes explain
it and it contradicts no wall: beams end before what the map shows, they do not pass through.
"""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.scan_matching import CELL_BIAS, ScanMatch, match_scan
from handcart.robotics.navigation.scans.start_search import map_ranges
from handcart.robotics.numerics.arrays import FloatArray

from .keyframe_layer import KeyframeLayer, LayerMatch, differs

THROUGH_M = 0.3  # beyond a wall of the map, where a beam has passed through it
MAX_THROUGH_SHARE = 0.2  # of the beams that may: objects on the map may have been removed
MIN_PARTIAL_POINTS = 25  # that the map has to explain for a correction by part of a scan
MIN_PARTIAL_SHARE = 0.1
PARTIAL_SIGMA_M, PARTIAL_SIGMA_RAD = 0.06, 0.02  # of a pose that part of a scan may correct: walls look alike
PARTIAL_SIGMAS = 3.0  # by which that may move the pose at most
SHIFT_M, SHIFT_RAD = 0.05, 0.02  # by which a correction by the map makes the keyframes useless


class UnmappedSurroundings:
    """Localizer for scans that do not fit the map, by keyframes of the drive (earlier scans with poses)."""

    def __init__(self, field: LikelihoodField, sigma: float) -> None:
        """Begin without keyframes; `field` is that of the map, `sigma` the noise of a range in [m]."""
        self._field, self._sigma = field, sigma
        self.layer = KeyframeLayer()
        """Keyframes so far."""

    def locate(self, points: FloatArray, prior: Pose2) -> LayerMatch | None:
        """Return the pose at which a scan fits earlier scans of unmapped surroundings.

        The result is None if the scan fits nowhere, or the map contradicts the pose.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
            prior: map_T_base, expected from the last pose and the motion of the wheels since then.
        """
        found = self.layer.match(points, prior, self._sigma)
        return None if found is None or self.contradicts(points, found.pose) else found

    def contradicts(self, points: FloatArray, pose: Pose2) -> bool:
        """Return whether so many beams of a scan pass through walls of the map that the pose must be wrong.

        Up to the share `MAX_THROUGH_SHARE` of the beams may pass through walls, because objects on the map
        may have been removed.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
            pose: map_T_base.
        """
        ranges = np.hypot(points[:, 0], points[:, 1])
        angles = np.arctan2(points[:, 1], points[:, 0])
        walls = map_ranges(self._field, pose, angles, float(ranges.max(initial=0.0)))
        return float((ranges > walls + THROUGH_M).mean()) > MAX_THROUGH_SHARE if len(points) else False

    def corrected_by_map(
        self, points: FloatArray, found: LayerMatch, map_error: FloatArray
    ) -> ScanMatch | None:
        """Correct the pose of `found` by the part of a scan that fits the map; return None if that fails.

        It fails if the pose is more uncertain than `PARTIAL_SIGMA_M` and `PARTIAL_SIGMA_RAD`, if less than
        `MIN_PARTIAL_SHARE` or `MIN_PARTIAL_POINTS` fit the map, or if that part contradicts the pose.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
            found: pose at which the scan fits the keyframes.
            map_error: (3, 3) factor W with rows for x, y on the map in [m] and heading in [rad]; W Wᵀ is the
                part of the covariance of `found` that comes from the map's error.
        """
        worst = float(np.linalg.eigvalsh(found.covariance[:2, :2])[-1])
        if worst > PARTIAL_SIGMA_M**2 or found.covariance[2, 2] > PARTIAL_SIGMA_RAD**2:
            return None
        match = match_scan(
            self._field, points, found.pose, found.covariance, self._sigma, map_error=map_error
        )
        if match.inliers < max(MIN_PARTIAL_SHARE, MIN_PARTIAL_POINTS / max(1, len(match.residuals))):
            return None
        x, y, turn = np.subtract(match.pose, found.pose).tolist()
        off = np.array([x, y, wrap(turn)])
        cells = (CELL_BIAS * self._field.map.resolution) ** 2 * np.eye(3)
        allowed = found.covariance + cells
        return match if float(off @ np.linalg.solve(allowed, off)) < PARTIAL_SIGMAS**2 else None

    def take(self, points: FloatArray, before: Pose2, pose: Pose2, covariance: FloatArray) -> None:
        """Add a scan as a keyframe at its final pose.

        If the scan has corrected the pose by more than `SHIFT_M` or `SHIFT_RAD`, all earlier keyframes are
        removed.

        Args:
            points: (n, 2) end points in the base frame, in [m].
            before: map_T_base before the scan corrected it.
            pose: map_T_base.
            covariance: (3, 3) of the pose: x, y on the map in [m], heading in [rad].
        """
        if differs(before, pose, SHIFT_M, SHIFT_RAD):
            self.layer.clear()
        self.layer.take(points, pose, covariance)
