"""Localization by an indoor positioning system and the wheels."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import chain
from typing import Any, ClassVar

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.localizer import Localizer
from handcart.robotics.navigation.odometry.odometry import OdometryErrors
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.small_solve import lapack_solved

KEPT_PERIODS = 64  # periods of wheel travel: readings may be as late
MAX_SQUARED_MAHALANOBIS = 25.0  # squared Mahalanobis distance beyond which a reading isn't explained
IN_A_ROW = 3  # of them: a single reading may be broken
REST_DRIFT_COVARIANCE = np.diag([2e-5, 2e-5, 1e-5]) ** 2  # [m², rad²] a reading: a standing base creeps
_IDENTITY = np.eye(3)


class PositioningLocalizer(Localizer):
    """Kalman filter that moves the pose by the wheels and corrects it by readings of a positioning system.

    A late reading is first moved by the wheels' motion since its time. At rest the readings are averaged.
    Three readings in a row more than 5 standard deviations (Mahalanobis distance) from the expected pose mean
    that the base was moved: its pose is set to the last reading.
    """

    STATE: ClassVar[Mapping[str, Any]] = {
        "_number": int,
        "_poses": tuple[Pose2, ...],
        "_shifts": tuple[tuple[Pose2, ...], ...],
        "_strange": int,
    }

    CORRECTS_BY_SCANS: ClassVar[bool] = False

    def __init__(
        self,
        start: Pose2,
        tread: float,
        sigma: tuple[float, float],
        errors: OdometryErrors = OdometryErrors(),
        covariance: FloatArray | None = None,
    ) -> None:
        """Start at a pose.

        Args:
            start: map_T_base.
            tread: distance of the wheels, in [m].
            sigma: of a reading's position along each axis, in [m], and of its heading, in [rad].
            errors: of the wheels.
            covariance: (3, 3) of the start, in [m, m, rad]; certain if None.
        """
        super().__init__(start, tread, errors, covariance)
        self._noise = np.diag([sigma[0], sigma[0], sigma[1]]) ** 2 + REST_DRIFT_COVARIANCE
        self._number, self._strange = 0, 0
        self._poses: tuple[Pose2, ...] = (start,)  # as they were believed first
        self._shifts: tuple[tuple[Pose2, ...], ...] = ((),)  # in each of their periods: of all until then

    def predict(self, left: float, right: float, sideways: float = 0.0) -> None:
        """Predict the motion from the wheels' travel; to be called once a period.

        Args:
            left: travel of the left wheels, in [m].
            right: travel of the right wheels, in [m].
            sideways: travel to the left of a base that drives sideways, in [m].
        """
        super().predict(left, right, sideways)
        self._poses = (*self._poses[-KEPT_PERIODS:], self.pose)
        self._shifts = (*self._shifts[-KEPT_PERIODS:], ())

    def correct(self, points: FloatArray) -> bool:
        """Ignore a scan, because only readings of the positioning system correct the pose; return False.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
        """
        return False

    def take(self, number: int, measured: Pose2, periods: int) -> bool:
        """Correct the pose by a reading; return True if this and earlier readings show that somebody moved
        the base.

        If it was moved, the pose is set to the reading. A single reading far from the expected pose is
        ignored.

        Args:
            number: number of the reading; a repeated number is ignored.
            measured: map_T_base by the reading.
            periods: age of the reading, in periods.
        """
        if number == self._number:
            return False
        self._number = number
        before = self.pose
        now = measured.compose(before.relative_to(self._remembered(periods)))
        prior = self.covariance + REST_DRIFT_COVARIANCE
        off = np.array([now.x - before.x, now.y - before.y, wrap(now.theta - before.theta)])
        spread = prior + self._noise
        if float(off @ lapack_solved(spread, off)) > MAX_SQUARED_MAHALANOBIS:
            return self._not_explained(now)
        self._strange = 0
        gain = lapack_solved(spread, prior).T
        dx, dy, turn = (gain @ off).tolist()
        pose = Pose2(before.x + dx, before.y + dy, wrap(before.theta + turn))
        kept = _IDENTITY - gain
        self._odometry.correct(pose, kept @ prior, kept)
        self._shift()
        return False

    def _not_explained(self, now: Pose2) -> bool:
        self._strange += 1
        if self._strange < IN_A_ROW:
            return False
        self._strange = 0
        self._odometry.reset(now, self._noise)
        self._shift()
        return True

    def _shift(self) -> None:
        """Move the remembered poses so that they end at the corrected pose; the travel since then is
        unchanged.
        """
        moved = self.pose.compose(self._remembered(0).inverse())
        self._shifts = (*self._shifts[:-1], (*self._shifts[-1], moved))

    def _remembered(self, periods: int) -> Pose2:
        """Return map_T_base of `periods` periods ago, with all corrections since."""
        at = max(0, len(self._poses) - 1 - periods)
        pose = self._poses[at]
        for moved in chain.from_iterable(self._shifts[at:]):
            pose = moved.compose(pose)
        return pose
