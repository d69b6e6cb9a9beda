"""Localization by wheels, with scans at rest as evidence."""

from __future__ import annotations

import math
from typing import ClassVar

from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import DriveCommand
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.plain_values import Kinds
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import LEAST_INLIERS
from handcart.robotics.navigation.localization.odometry_localizer import OdometryLocalizer

from .held_base import HeldBase
from .lidar import Lidar
from .localization import Localization
from .lost import Lost, lost_by_stale_lidar

REST_PERIODS = 4  # periods at rest after which a scan shows whether the wheels' pose is right
# [m] of commanded travel alone that is added while the encoders read the same
MAX_COMMANDED_TRAVEL_M = 0.03


class WheelLocalization(Localization):
    """Localization by the wheels; with a map and a lidar, scans of the base at rest correct it.

    Scans show whether the base was moved while its wheels were at rest, and check the pose by the wheels
    after each drive. If no pose close to that of the wheels explains the scan, the base is lost.

    If the encoders' readings do not change while the base is commanded to drive, either the wheels or the
    encoders are stuck. The two cannot be distinguished, so the pose is unknown.
    """

    STATE: ClassVar[Kinds] = {**Localization.STATE, "_unanswered": float}

    def __init__(self, backend: Backend, wheels: OdometryLocalizer, lidar: RangeSensor | None = None) -> None:
        """Begin with a robot at rest.

        Args:
            backend: backend of the robot.
            wheels: estimator by the wheels, with the field of the map if one is given.
            lidar: lidar with interpreted scans; None without one.
        """
        super().__init__(backend, wheels, lidar)
        self._reckoning = wheels
        self.map_field = wheels.field
        self._unanswered = 0.0
        if isinstance(lidar, Lidar):
            self.held_base = HeldBase(wheels, lidar, backend.period)

    @property
    @override
    def source(self) -> str:
        return "Base"

    @property
    @override
    def dead_reckoned(self) -> bool:
        return True

    @property
    @override
    def lost(self) -> Lost | None:
        if self.lifted is not None:
            return self.lifted
        if self._reckoning.astray:
            share = "share of the scan that the map explains"
            why = "after the drive its scan fits the map nowhere near where its wheels say"
            return Lost(why, "RangeSensor", share, self._reckoning.explained, LEAST_INLIERS)
        if self._unanswered <= MAX_COMMANDED_TRAVEL_M:
            return lost_by_stale_lidar(self.stale_s) or self.held_base.lost
        why = "its wheels are driven, and read the same again and again"
        way = "way driven since the wheels read anything new"
        return Lost(why, "Base", way, 1e3 * self._unanswered, 1e3 * MAX_COMMANDED_TRAVEL_M, "mm")

    @property
    @override
    def slips(self) -> int:
        return self._reckoning.slips

    @property
    @override
    def added_sigma(self) -> float:
        return self._reckoning.added_sigma

    def look_again(self, rolled: Pose2 = Pose2(0.0, 0.0, 0.0)) -> None:
        """Find the pose again if a scan shows that the base was moved while its wheels were at rest.

        When the base comes to rest after a drive, the pose by the wheels is first compared with a scan.

        Args:
            rolled: pose of the base by the wheels in the base frame when it came to rest; zero if the wheels
                did not turn.
        """
        if self._needs_check and self._range_sensor is not None and self.stale_s == 0.0:
            self._reckoning.check_drive(self._fresh_points())
        super().look_again(rolled)

    @property
    def _needs_check(self) -> bool:
        """True if the base is at rest after a drive, and no scan has been compared with the map since."""
        return self.still >= REST_PERIODS and self._reckoning.unchecked

    @property
    @override
    def _is_found(self) -> bool:
        return self.still >= REST_PERIODS and not (self._reckoning.unchecked or self._reckoning.astray)

    def _correct(self) -> None:
        if self.still == REST_PERIODS or self._needs_check:
            self.look_again()
        super()._correct()

    @override
    def update(self, driven: DriveCommand) -> None:
        before = self.travel
        super().update(driven)
        turned = 0.5 * self._wheels.odometry.tread * abs(driven.turn_rate)
        way = (math.hypot(driven.speed, driven.sideways) + turned) * self._period
        self._unanswered = self._unanswered + way if self.travel == before else 0.0
