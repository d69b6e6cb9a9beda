"""Detection of a base that something holds while its wheels turn, by comparing wheels and scans."""

from __future__ import annotations

from handcart.backends.capabilities.base import WheelTravel
from handcart.robotics.navigation.localization.localizer import Localizer
from handcart.robotics.navigation.locating.wheel_check import WheelCheck

from .lidar import Lidar, beams_of
from .lost import Lost

REST_PERIODS = 4  # periods at rest, after which the wheels report nothing more
MAX_SEARCH_S = 10.0  # after scans contradicted the wheels, until the pose counts as lost
HELD_REASON = "its wheels turned while something held it, and its scans do not show where it is since"


class HeldBase:
    """Detector of a base that an obstacle holds while its wheels turn.

    It compares the wheels' travel with the lidar's scans, and corrects the pose if they contradict each
    other.
    """

    def __init__(self, wheels: Localizer, lidar: Lidar | None, period: float) -> None:
        """Begin at rest; without a lidar the wheels are believed. The control period is in [s]."""
        self._wheels, self._lidar, self._period = wheels, lidar, period
        odometry = wheels.odometry
        self._check = WheelCheck(odometry.tread, odometry.errors, period)
        self._searched = 0

    @property
    def compares_scans(self) -> bool:
        """True if there is a lidar with whose scans the wheels' travel is compared."""
        return self._lidar is not None

    @property
    def is_settled(self) -> bool:
        """True if scans and wheels agree on the base's motion, or if the pose was found again after they
        contradicted each other.
        """
        return self._searched == 0 and not self._check.is_doubtful

    @property
    def searches(self) -> bool:
        """True from the moment when scans contradict the wheels' travel until a scan matches the map at some
        pose again.
        """
        return self._searched > 0

    @property
    def lost(self) -> Lost | None:
        """Reason why the pose is unknown; None while it is known or may still be found."""
        searched = self._searched * self._period
        if searched <= MAX_SEARCH_S:
            return None
        return Lost(
            HELD_REASON, "RangeSensor", "time since the wheels were denied", searched, MAX_SEARCH_S, "s"
        )

    def update(self, rolled: WheelTravel, still: int) -> bool:
        """Compare the wheels' travel in a period with the period's scan; return True if the pose was
        corrected.

        Args:
            rolled: travel of the wheels in the period, in [m].
            still: number of periods for which the base has been at rest.
        """
        if self._lidar is None:
            return False
        self._searched += self.searches
        if still >= REST_PERIODS:
            self._check.reset()
            return False
        if self._lidar.silence:
            self._check.reset()
            return False
        self._check.roll(*rolled)
        found = self._check.take(beams_of(self._lidar))
        if found is None:
            return False
        self._wheels.deny_wheels(*found)
        self._searched = max(1, self._searched)
        return True

    def note_pose(self, is_found: bool) -> None:
        """Record the corrected pose of this period; later scans are compared with the scan at this pose.

        Args:
            is_found: True if a scan shows where the base is. This ends the search for the pose that began
                when scans contradicted the wheels' travel.
        """
        self._check.note_pose(self._wheels.pose)
        if is_found and not self._check.is_contradicted:
            self._searched = 0

    def reset(self) -> None:
        """Forget the earlier scans and start monitoring again, because the pose was set from outside."""
        self._check.reset()
        self._searched = 0
