"""The range sensor."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from .capability import Capability, Reading
from .scan import Scan as Scan


class RangeSensor(Capability):
    """Lidar: a scanning range sensor with its plane parallel to the floor.

    A backend returns readings as the driver delivers them (zeros, NaN, -inf, the robot's own body).
    `Robot` interprets them by the robot's file, and returns scans in which each beam has its `Validity`.
    """

    READINGS: ClassVar = {"scan": Reading("range", ("ranges",), noisy=True)}

    @abstractmethod
    def scan(self) -> Scan:
        """Return the lidar's scan of the current control period.

        Calls return the same object until the next scan: callers detect a new one by its identity.
        """

    def scan_later(self) -> Callable[[], Scan]:
        """Return a function that returns this period's scan whenever it is called.

        If a caller may not need the scan, a simulation can compute it only when the function is called.
        """
        scan = self.scan()
        return lambda: scan
