"""Where the base is, by its wheels and by scans that are matched with the map."""

from __future__ import annotations

import math

from handcart.backends.backend import Backend
from handcart.robotics.navigation.localization.localizer import ScanLocalizer

from .localization import Localization

SCAN_SIGMA = (0.004, 0.0015)  # [m], [rad]: spread of scan matches about one place


class ScanLocalization(Localization):
    """Wheels carry the pose on, scans correct it."""

    def __init__(self, backend: Backend, matching: ScanLocalizer) -> None:
        """Of a robot that stands, and looks round at once."""
        super().__init__(backend, matching)
        self._matching = matching
        assert self._range_sensor is not None, "scans come from a range sensor"
        matching.correct(self._range_sensor.scan().points())

    @property
    def sigma(self) -> tuple[float, float]:
        """See `Localization`: the map's own error is the same in both poses. A lost robot knows nothing; if
        the last scan wasn't believed, it is all that has been added up since."""
        if self.lost:
            return math.inf, math.inf
        return SCAN_SIGMA if self._matching.sure else super().sigma

    @property
    def dead_reckoned(self) -> bool:
        """See `Localization`."""
        return False

    @property
    def lost(self) -> bool:
        """See `Localization`."""
        return self._matching.lost

    @property
    def explained(self) -> float:
        """See `Localization`."""
        match = self._matching.last_match
        return super().explained if match is None else match.inliers
