"""Detection of wheels whose travel errs more than assumed, if scans determine it."""

from __future__ import annotations

import math
from typing import ClassVar

TEST_EVERY_M = 0.5
MAX_WAY_M = 10.0  # after which a new window begins
WRONG_SIGMAS = 3.0  # sigmas beyond which what is claimed is wrong


class WayMonitor:
    """Detector of a scale error of the wheels' travel, from the sum of the forward corrections by scans.

    The sum over a window of travel, 10 m at most, is compared with its expected spread (Mehra, 1970). The
    filter alone hardly notices such an error, because it takes each single correction for the map's error.
    """

    STATE: ClassVar = {"_missed": float, "_way": float, "_claimed": float, "_next": float}

    def __init__(self) -> None:
        """Start a window."""
        self._missed, self._way, self._claimed, self._next = 0.0, 0.0, 0.0, TEST_EVERY_M

    def roll(self, way: float, variance: float) -> None:
        """Add travel in [m], negative backwards, and its `variance` by assumed slip, in [m²], to the sums of
        the present window, a stretch of travel after which the wheels' scale is tested.
        """
        self._way += way
        self._claimed += variance

    def begin(self) -> None:
        """Discard the sums of travel and of corrections by scans, and start a new window of travel."""
        self._missed, self._way, self._claimed, self._next = 0.0, 0.0, 0.0, TEST_EVERY_M

    def take(self, missed: float, map_sigma: float, scale_variance: float) -> float:
        """Add a correction of the position by a scan; return the size of the wheels' relative scale error.

        The result is 0 as long as the error is below 3 standard deviations. A larger error is returned
        without its sign, and a new window of travel begins.

        Args:
            missed: position by the scan less position by the wheels, along the heading, in [m].
            map_sigma: standard deviation of the map's error at one place, in [m].
            scale_variance: assumed relative variance of the length of travel.
        """
        self._missed += missed
        way = abs(self._way)
        if way < self._next:
            return 0.0
        self._next += TEST_EVERY_M
        claimed = 2.0 * map_sigma**2 + self._claimed + scale_variance * way**2
        found = abs(self._missed) / way if abs(self._missed) > WRONG_SIGMAS * math.sqrt(claimed) else 0.0
        if found or way > MAX_WAY_M:
            self.begin()
        return found
