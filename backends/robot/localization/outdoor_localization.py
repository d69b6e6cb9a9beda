"""Where the base is on open ground, by its wheels, gyros and a satellite receiver."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from handcart.backends.backend import Backend
from handcart.backends.capabilities.gps import Gps
from handcart.backends.capabilities.imu import Imu
from handcart.backends.plain_values import Kinds
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import Localizer
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.smoothing import Belief

from .localization import Localization


class OutdoorLocalization(Localization):
    """A filter of all of them; what a range sensor sees tells of no map."""

    def __init__(self, backend: Backend, wheels: Localizer, filtering: FieldLocalizer) -> None:
        """Of a robot that stands, and has gyros."""
        super().__init__(backend, wheels)
        self._filter, self._period = filtering, backend.period
        imu = backend.get(Imu)  # type: ignore[type-abstract]
        assert imu is not None, "outdoors gyros are asked"
        self._imu = imu
        self._gps = backend.get(Gps)  # type: ignore[type-abstract]

    @property
    def pose(self) -> Pose2:
        """See `Localization`."""
        return self._filter.pose

    @property
    def odometry_pose(self) -> Pose2:
        """See `Localization`: by wheels and gyros."""
        return self._filter.odometry.pose

    @property
    def covariance(self) -> NDArray[np.float64]:
        """See `Localization`."""
        return self._filter.covariance

    @property
    def tilt(self) -> tuple[float, float]:
        """See `Localization`."""
        return self._filter.tilt

    @property
    def dead_reckoned(self) -> bool:
        """See `Localization`."""
        return self._gps is None or not self._filter.TAKES_FIXES

    def mark(self) -> None:
        """See `Localization`."""
        self._filter.mark()

    def smoothed(self) -> list[Belief]:
        """See `Localization`."""
        return self._filter.smoothed()

    def _predict(self, left: float, right: float) -> None:
        super()._predict(left, right)
        rolled = np.array([left, right])
        self._filter.predict(self._imu.rates(), self._imu.accelerations(), rolled, self._period)
        fix = self._gps.fix() if self._gps else None
        if fix is not None:
            self._filter.fix(fix.position)

    def _correct(self) -> None:
        """A fix is taken when it comes."""

    def _parts(self) -> dict[str, tuple[object, Kinds]]:
        odometry = self._filter.odometry
        return {
            **super()._parts(),
            "filter": (self._filter, self._filter.STATE),
            "wheels and gyros": (odometry, odometry.STATE),
        }
