"""The range sensor."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from .capability import Capability, Reading
from .scan import Scan as Scan


class RangeSensor(Capability):
    """A scanning range sensor, its plane parallel to the floor.

    A backend gives readings as the driver delivers them (zeros, NaN, -inf, the robot's own body). `Robot`
    reads them by the robot's file, and gives everybody else scans in which each beam has its `Validity`.
    """

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
