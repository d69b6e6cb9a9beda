"""Stops at which a base that drives by its wheels alone measures its pose."""

from __future__ import annotations

from handcart.backends.robot.localization.localization import Localization

REST_SIGMA = 0.006  # [m] that the drive may add to the pose
LAST_SIGMA, LAST_WAY = 0.002, 0.5  # [m] the same on the last stretch, and how long that is


class LooksAtRest:
    """Decision whether a base stops during a drive, so that its pose is corrected by scans at rest.

    The base has to stop when the position error that driving added since the last scan at rest exceeds a
    standard deviation of 6 mm, or 2 mm in the last 0.5 m of the drive.
    """

    def __init__(self, localization: Localization) -> None:
        """Create the stops of a drive that begins now."""
        self._localization = localization
        self._due = False

    def due(self, remaining: float) -> bool:
        """Return whether the base should stop for a scan now; called once a control period.

        The result is True if the error that the drive has added to the pose has a sigma above `REST_SIGMA`,
        or above `LAST_SIGMA` if less than `LAST_WAY` remains. It stays True until a scan at rest has removed
        this error.

        Args:
            remaining: distance to the end of the drive, in [m].
        """
        added = self._localization.added_sigma
        limit = LAST_SIGMA if remaining < LAST_WAY else REST_SIGMA
        self._due = added > 0.0 and (self._due or added > limit)
        return self._due
