"""Localization on open ground, by wheels, gyros and a satellite receiver."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.capabilities.beacons import Beacons
from handcart.backends.capabilities.gps import Gps
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.plain_values import Kinds
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import Localizer
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.numerics.arrays import FloatArray

from .localization import Localization
from .lost import Lost
from .sensed import Sensed

MAX_TRAVEL_WITHOUT_GYRO_M = 0.15  # [m] of wheel travel that the gyros may miss


class OutdoorLocalization(Localization):
    """Localization outdoors by a filter of wheels, IMU, satellite receiver and beacons, without a map."""

    STATE: ClassVar[Kinds] = {**Localization.STATE, "_felt": FloatArray, "_felt_at": WheelTravel}
    POSE_JUMPS: ClassVar[bool] = True

    def __init__(
        self,
        backend: Backend,
        wheels: Localizer,
        filtering: FieldLocalizer,
        lidar: RangeSensor | None = None,
    ) -> None:
        """Begin with a robot at rest that has gyros.

        Args:
            backend: backend of the robot.
            wheels: estimator by the wheels alone.
            filtering: filter of all outdoor sensors.
            lidar: lidar with interpreted scans, which show whether something holds or moves the base; None
                without one.
        """
        super().__init__(backend, wheels, lidar)
        self._filter, self._period = filtering, backend.period
        imu = backend.get(Imu)  # type: ignore[type-abstract]
        assert imu is not None, "outdoors gyros are asked"
        self._imu = imu
        self._gps = backend.get(Gps)  # type: ignore[type-abstract]
        self._beacons = backend.get(Beacons)  # type: ignore[type-abstract]
        self._sensed = Sensed(np.zeros(3), np.zeros(3), np.zeros(2), None)
        self._felt, self._felt_at = np.zeros(6), self.travel
        self._here: Pose2 | None = None
        self._rolled_to: Pose2 | None = None
        """Cache of the filter's pose map_T_base, which is read many times in a period."""
        self.set_origin()

    @property
    @override
    def pose(self) -> Pose2:
        if self._here is None:
            self._here = self._filter.pose
        return self._here

    @property
    def odometry_pose(self) -> Pose2:
        """2D pose of the base by wheels and gyros alone; it never jumps, and its frame is not the map's."""
        if self._rolled_to is None:
            self._rolled_to = self._filter.odometry.pose
        return self._rolled_to

    @override
    def set_origin(self) -> None:
        self._filter.set_origin()

    @property
    def displacement(self) -> Belief | None:
        """Motion of the base since `set_origin`, in the base frame at that time; None if unknown.

        Mean (3,) and covariance (3, 3) of the motion ahead and to the left, in [m], and of the turn to the
        left, in [rad]. The covariance has no errors that are common to all satellite fixes.
        """
        return self._filter.displacement

    @property
    @override
    def covariance(self) -> FloatArray:
        return self._filter.covariance

    @property
    @override
    def particles(self) -> FloatArray | None:
        return self._filter.particles

    @property
    def repeatability(self) -> FloatArray:
        """Covariance (3, 3) of the pose relative to another pose estimated at the same place.

        x and y in the world in [m], heading in [rad]. While the heading is unknown, the result is the
        covariance of the motion by wheels and gyros since `set_origin`, in the base frame at that time.
        """
        return self.covariance if self.heading_known else self._filter.displacement.covariance

    @property
    @override
    def tilt(self) -> tuple[float, float]:
        return self._filter.tilt

    @property
    @override
    def source(self) -> str:
        if self._gps is not None and self._filter.TAKES_FIXES:
            return "Gps"
        return "Beacons" if self._beacons is not None and self._filter.TAKES_RANGES else "Imu"

    @property
    @override
    def dead_reckoned(self) -> bool:
        return self.source == "Imu"

    @property
    def lost(self) -> Lost | None:
        """Reason why the pose is unknown; None while it is known.

        The pose is unknown if the wheels have rolled more than 0.15 m without a new reading of the gyros,
        because wheels alone do not measure the heading well.
        """
        rolled = self.travel.away(self._felt_at)
        if rolled <= MAX_TRAVEL_WITHOUT_GYRO_M:
            return None
        why = "its gyros read nothing, or the same again and again"
        return Lost(
            why,
            "Imu",
            "way since a gyro read anything new",
            1e3 * rolled,
            1e3 * MAX_TRAVEL_WITHOUT_GYRO_M,
            "mm",
        )

    @property
    @override
    def heading_known(self) -> bool:
        return self._filter.heading_known

    @property
    @override
    def doubt(self) -> Lost | None:
        found = self._filter.inconsistency
        if self.lost is not None or found is None:
            return self.lost
        what = "ranges" if self._filter.TAKES_RANGES else "fixes"
        why = f"the {what} of the last minute contradict what is claimed"
        return Lost(why, self.source, found.what, found.value, found.limit)

    @property
    @override
    def sensed(self) -> Sensed:
        return self._sensed

    @override
    def mark(self) -> None:
        self._filter.mark()
        self._here = None

    @override
    def smoothed(self) -> list[Belief]:
        return self._filter.smoothed()

    def _predict(self, left: float, right: float, sideways: float) -> None:
        if self._wheels.looks:
            super()._predict(left, right, sideways)
        self._here = self._rolled_to = None
        rolled = np.array([left, right])
        rates, accelerations = self._imu.rates(), self._imu.accelerations()
        felt = np.concatenate([rates, accelerations])
        if np.isfinite(rates).all() and not np.array_equal(felt, self._felt):
            self._felt, self._felt_at = felt, self.travel
        self._filter.predict(rates, accelerations, rolled, self._period)
        fix = self._gps.fix() if self._gps else None
        ranges = self._beacons.ranges() if self._beacons else None
        distances = None if ranges is None else ranges.distances
        self._sensed = Sensed(rates, accelerations, rolled, fix, distances)
        if fix is not None:
            self._filter.fix(fix.position)
        if distances is not None:
            self._filter.ranges(distances)

    def _correct(self) -> None:
        """Correct by a fix if one arrived."""

    @override
    def set_state(self, state: object) -> None:
        super().set_state(state)
        self._filter.forget_derived()
        self._here = self._rolled_to = None

    def _parts(self) -> dict[str, tuple[object, Kinds]]:
        odometry = self._filter.odometry
        return {
            **super()._parts(),
            "filter": (self._filter, self._filter.STATE),
            "wheels and gyros": (odometry, odometry.STATE),
            **{f"filter {k}": (part, part.STATE) for k, part in enumerate(self._filter.parts, start=1)},
        }
