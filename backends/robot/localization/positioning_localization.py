"""Localization by wheels and an indoor positioning system."""

from __future__ import annotations

import numpy as np
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.positioning import Positioning
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.robotics.navigation.localization.positioning_localizer import PositioningLocalizer

from .localization import Localization


class PositioningLocalization(Localization):
    """Localization by wheels, corrected by the readings of an indoor positioning system.

    At rest, readings at another place show that the base was moved.
    """

    def __init__(
        self, backend: Backend, filtering: PositioningLocalizer, lidar: RangeSensor | None = None
    ) -> None:
        """Begin with a robot at rest.

        Args:
            backend: backend of the robot, which has a positioning system.
            filtering: filter of wheels and readings.
            lidar: lidar with interpreted scans; None without one.
        """
        super().__init__(backend, filtering, lidar)
        self._filter, self._period = filtering, backend.period
        positioning = backend.get(Positioning)  # type: ignore[type-abstract]
        assert positioning is not None, "readings come from a positioning system"
        self._positioning = positioning

    @property
    @override
    def source(self) -> str:
        return "Positioning"

    @property
    @override
    def dead_reckoned(self) -> bool:
        return False

    def _correct(self) -> None:
        reading = self._positioning.reading()
        if reading is None or not np.isfinite((*reading.pose, reading.age)).all():
            return  # skip an invalid reading
        periods = round(reading.age / self._period)
        if self._filter.take(reading.number, reading.pose, periods) and self.still > periods:
            self._displaced()
