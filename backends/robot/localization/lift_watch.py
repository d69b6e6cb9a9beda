"""A base that is lifted and set down elsewhere: its scans change at once, and its wheels do not turn."""

from __future__ import annotations

from handcart.backends.capabilities.base import WheelTravel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.locating.scan_jump import ScanJump

from .crowd import Crowd
from .lidar import Lidar, beams_of
from .lost import Lost, lifted_by

SLIDING_PERIODS = 60  # after a contact, in which the base may slide off what it ran into
LOOK_AGAIN = 10  # periods at rest between scans that are compared for a moved base


class LiftWatch:
    """Detector of a base that is lifted and set down elsewhere, by comparing each scan with the previous."""

    def __init__(self, tread: float) -> None:
        """Begin without scans; `tread` of the wheels in [m]."""
        self._tread, self._jump, self._people_before = tread, ScanJump(), False
        self._may_slide = 0  # periods left in which it may

    def take(self, lidar: Lidar, rolled: WheelTravel, still: int, crowd: Crowd, pose: Pose2) -> Lost | None:
        """Process this period's scan; return the reason why the pose is lost if the base was lifted,
        otherwise None.

        Args:
            lidar: first lidar of the robot.
            rolled: travel of the wheels in this period, in [m].
            still: number of periods for which the base has been at rest.
            crowd: people around the base, who change scans as well.
            pose: estimated map_T_base.
        """
        self._may_slide = max(0, self._may_slide - 1)
        self._jump.roll(rolled.left, rolled.right, self._tread, rolled.sideways)
        if still > 0 and still % LOOK_AGAIN != 0:
            return None
        if lidar.silence:
            self._jump.reset()  # a change across a gap in the scans is not a jump
            return None
        if not self._jump.is_doubtful:  # another place seems full of people
            self._people_before = crowd.is_near
        if self._jump.take(beams_of(lidar), still > 0, pose, self._may_slide > 0) and not self._people_before:
            return lifted_by(self._jump.share)
        return None

    def note_contact(self) -> None:
        """Record that the base ran into something: in the next 60 periods the base may slide, which changes
        scans.
        """
        self._may_slide = SLIDING_PERIODS

    def reset(self) -> None:
        """Discard all scans so far, so that the next scan is not compared with an earlier one."""
        self._jump.reset()
