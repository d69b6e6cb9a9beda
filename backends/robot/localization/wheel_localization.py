"""Where the base is, by its wheels alone."""

from __future__ import annotations

from .localization import Localization


class WheelLocalization(Localization):
    """With a map and a range sensor, scans only tell whether the base was moved while its wheels stood."""

    @property
    def dead_reckoned(self) -> bool:
        """See `Localization`."""
        return True
