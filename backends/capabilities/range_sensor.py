"""The range sensor."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2

from .capability import Capability, Reading


class Scan(NamedTuple):
    """One turn of a range sensor."""

    angles: NDArray[np.float64]
    """(n,) in [rad], in the sensor frame, counter-clockwise from its x axis."""
    ranges: NDArray[np.float64]
    """(n,) in [m]; infinity where nothing came back."""
    base_T_sensor: Pose2
    """Where the sensor stands on the base."""

    def points(self) -> NDArray[np.float64]:
        """What was hit, (m, 2) in [m], in the base frame."""
        hit = np.isfinite(self.ranges)
        reach, angle = self.ranges[hit], self.angles[hit]
        return self.base_T_sensor.apply(np.column_stack([reach * np.cos(angle), reach * np.sin(angle)]))


class RangeSensor(Capability):
    """A scanning range sensor, its plane parallel to the floor."""

    READINGS: ClassVar = {"scan": Reading("range", ("ranges",), noisy=True)}
    FILE_KEY = "range_sensor"

    @abstractmethod
    def scan(self) -> Scan:
        """This period's scan."""

    def scan_later(self) -> Callable[[], Scan]:
        """Gives this period's scan, in whatever period it is called: for who needs it only if something
        comes of it. What is simulated may make it no sooner.
        """
        scan = self.scan()
        return lambda: scan
