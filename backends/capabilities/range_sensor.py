"""The range sensor."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from .capability import Capability, Reading
from .scan import Scan as Scan


class RangeSensor(Capability):
    """A lidar whose plane is parallel to the floor.

    A backend returns readings as the driver delivers them (zeros, NaN, -inf, the robot's own body).
    `Robot` interprets them by the robot's file, and returns scans in which each beam has its `Validity`.
    """

    READINGS: ClassVar = {"scan": Reading("range", ("ranges",), noisy=True)}
    FILE_KEY = "range_sensor"

    @abstractmethod
    def scan(self) -> Scan:
        """This period's scan."""

    def scan_later(self) -> Callable[[], Scan]:
        """Return a function that returns this period's scan, in whatever period it is called.

        Callers that may not need the scan use this; a simulation may compute the scan only when it is
        called.
        """
        scan = self.scan()
        return lambda: scan
