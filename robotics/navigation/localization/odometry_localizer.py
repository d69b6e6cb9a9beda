"""Localizer by wheels, with scans at rest as evidence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.rest_poses import is_apart, pose_difference
from handcart.robotics.navigation.odometry.odometry import OdometryErrors
from handcart.robotics.navigation.scans.scan_matching import FEWEST_POINTS, LikelihoodField, match_scan
from handcart.robotics.numerics.arrays import FloatArray

from .localizer import (
    LEAST_INLIERS,
    MIN_SHARE_KEPT_AT_REST,
    SEARCH_COVARIANCE,
    Localizer,
)

DRIVING_WHEEL_TRAVEL_M = 0.02  # [m] of the wheels, after which a base is driving
UNCHECKED_WAY_M = 1e9  # farther than anything drives, and finite: checkpoints hold finite numbers
UNKNOWN_VARIANCE_M2 = 1e9  # more than any pose has, and finite as well
SLIPPED_SIGMAS = 4.0  # sigmas between a drive by its wheels and the scan after it that no chance explains
# share of the points explained before a drive; fewer after it, and the base is elsewhere
MIN_SHARE_KEPT_BY_DRIVE = 0.5


class OdometryLocalizer(Localizer):
    """Localizer that updates the pose by the wheels alone while the base drives.

    With a map, scans taken at rest are used for two checks: whether the base was moved while its wheels were
    still (`find_again`), and whether the pose is right after a drive (`check_drive`).

    Attributes:
        slips: number of drives after which a scan contradicted the wheels.
        astray: True if the scan after the last drive doesn't fit the map, although scans did before.
        explained: share of the points that fit the map, of the last scan that corrected the pose; 0 before
            the first.
    """

    STATE: ClassVar[Mapping[str, Any]] = {
        "_stands": Pose2 | None,
        "_rolled": float,
        "_driven": float,
        "_then": float,
        "slips": int,
        "astray": bool,
        "explained": float,
    }

    CORRECTS_BY_SCANS: ClassVar[bool] = False

    def __init__(
        self,
        start: Pose2,
        tread: float,
        errors: OdometryErrors = OdometryErrors(),
        covariance: FloatArray | None = None,
        field: LikelihoodField | None = None,
        sigma: float = 0.01,
    ) -> None:
        """Start like `Localizer`; `field` is that of the map, if any, `sigma` the noise of a range in [m]."""
        super().__init__(start, tread, errors, covariance)
        self._field, self._sigma = field, sigma
        self._stands: Pose2 | None = None
        self._rolled = 0.0  # [m] by the wheels since that scan
        self._driven = UNCHECKED_WAY_M  # since `check_drive`; at first the start is checked
        self._then = UNKNOWN_VARIANCE_M2  # variance along the worst direction after it
        self.slips, self.astray, self.explained = 0, False, 0.0

    @property
    def looks(self) -> bool:
        """True if the localizer has a map, with which it compares scans taken while the base is at rest."""
        return self._field is not None

    @property
    @override
    def field(self) -> LikelihoodField | None:
        return self._field

    @override
    def extend_map(self, field: LikelihoodField) -> None:
        self._field = field

    @override
    def change_map(self, field: LikelihoodField, pose: Pose2, covariance: FloatArray) -> None:
        super().change_map(field, pose, covariance)
        self._stands, self._rolled, self.astray, self.explained = None, 0.0, False, 0.0
        self._driven, self._then = UNCHECKED_WAY_M, UNKNOWN_VARIANCE_M2

    @override
    def predict(self, left: float, right: float, sideways: float = 0.0) -> None:
        before = self.pose
        super().predict(left, right, sideways)
        travelled = max(abs(left), abs(right), abs(sideways))
        self._rolled += travelled
        self._driven += travelled
        if self._rolled > DRIVING_WHEEL_TRAVEL_M:
            self._stands = None
        elif self._stands is not None:
            self._stands = self._stands.compose(self.pose.relative_to(before))

    @override
    def deny_wheels(self, pose: Pose2, covariance: FloatArray) -> None:
        super().deny_wheels(pose, covariance)
        self._stands = None
        self._driven = max(self._driven, 2.0 * DRIVING_WHEEL_TRAVEL_M)

    def correct(self, points: FloatArray) -> bool:
        """Ignore a scan, because only the wheels correct the pose while the base drives; return False.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
        """
        return False

    @property
    def unchecked(self) -> bool:
        """True if the base has driven since the pose was last compared with a scan, or if there was no
        comparison.

        False without a map.
        """
        return self._field is not None and self._driven > DRIVING_WHEEL_TRAVEL_M

    @property
    def added_sigma(self) -> float:
        """Standard deviation, in [m], that driving has added to the position since the pose was last compared
        with a scan at rest.

        The value is that along the direction in which it is largest. It is 0 if no scan at rest can reduce
        it: without a map, or while scans do not fit the map.
        """
        if not self.unchecked or self.astray or self.explained < LEAST_INLIERS:
            return 0.0
        return math.sqrt(max(0.0, _worst_variance(self.covariance) - self._then))

    def check_drive(self, points: FloatArray) -> None:
        """Correct the pose after a drive by a scan at rest, its end points (n, 2) in the base frame, in [m].

        If the poses by wheels and by scan differ by more than their uncertainty allows, the wheels slipped,
        and the pose is set to that of the scan. The pose is unchanged without a map, or if the share of the
        scan that fits the map is below `LEAST_INLIERS`.
        """
        if self._field is None:
            return
        if len(points) >= FEWEST_POINTS:
            self._correct_at_rest(self._field, points)
        self._driven, self._then = 0.0, _worst_variance(self.covariance)

    def _correct_at_rest(self, field: LikelihoodField, points: FloatArray) -> None:
        prior, best = (
            np.asarray(self.covariance + SEARCH_COVARIANCE),
            MIN_SHARE_KEPT_BY_DRIVE * self.explained,
        )
        match = match_scan(field, points, self.pose, prior, self._sigma)
        if match.inliers < MIN_SHARE_KEPT_AT_REST * self.explained:
            match = match_scan(field, points, self.pose, prior, self._sigma, anneal=True)
        if match.inliers < LEAST_INLIERS:
            self.astray = match.inliers < best
            return
        self.astray, self.explained = False, match.inliers
        off, own = pose_difference(self.pose, match.pose), self.covariance
        gain = np.linalg.solve(own + match.covariance, own).T
        if float(off @ np.linalg.solve(own + match.covariance, off)) > SLIPPED_SIGMAS**2:
            self.slips += 1
            self._odometry.reset(match.pose, match.covariance)
            return
        x, y, turn = (gain @ off).tolist()
        pose = Pose2(self.pose.x + x, self.pose.y + y, wrap(self.pose.theta + turn))
        self._odometry.correct(pose, (np.eye(3) - gain) @ own)

    def find_again(self, points: FloatArray) -> bool:
        """Return whether the base was moved while its wheels were at rest: its last two scans fit different
        places.

        The motion between these places is added to the pose.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
        """
        if self._field is None or len(points) < FEWEST_POINTS:
            return False
        before, near = self._stands, self._stands or self.pose
        covariance = np.asarray(self.covariance + SEARCH_COVARIANCE)
        match = match_scan(self._field, points, near, covariance, self._sigma)
        if match.inliers < LEAST_INLIERS:
            return False
        self._stands, self._rolled = match.pose, 0.0
        if before is None:
            return False
        apart = is_apart(before, match, 2.0 * match.spread, self._field, self.surface_error)
        if apart:
            moved = match.pose.relative_to(before)
            self._odometry.reset(self.pose.compose(moved), self.covariance)
        return apart


def _worst_variance(covariance: FloatArray) -> float:
    """Return the variance of a position along its worst direction, in [m²]."""
    return float(np.linalg.eigvalsh(covariance[:2, :2])[-1])
