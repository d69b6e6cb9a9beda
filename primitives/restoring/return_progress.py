"""Limits on the time that a drive back may take without getting on."""

from __future__ import annotations

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured

PROGRESS_M = 0.01  # of the way back: less is no progress
STUCK_RETURN_S = 60.0  # without progress, though nothing holds the base
HELD_RETURN_S = 600.0  # without progress, with the time that obstacles or people hold the base


class ReturnProgress:
    """Monitor that ends a drive back on which the base does not get on; asked in each period of the drive.

    Pauses of the drive do not count.
    """

    def __init__(self, robot: Robot, held_s: float = HELD_RETURN_S) -> None:
        """Begin a drive back.

        Args:
            robot: robot on its way back.
            held_s: time without progress, with the time that obstacles or people hold the base, in [s].
        """
        self._robot, self._held_s, self._progress = robot, held_s, 0.0
        self._driven_s = self._waited_s = 0.0

    @property
    def driven_s(self) -> float:
        """Time without progress in which nothing held the base, in [s]."""
        return self._driven_s

    def is_over(self, progress: float = 0.0) -> bool:
        """Count a period, and return whether the base has not got on for too long.

        Args:
            progress: length of the way back that the base has covered, in [m].
        """
        robot = self._robot
        if progress > self._progress + PROGRESS_M:
            self._progress, self._driven_s, self._waited_s = progress, 0.0, 0.0
        if robot.held is not None or robot.base.share_for_people < 1.0:
            self._waited_s += robot.period
        else:
            self._driven_s += robot.period
        return self._driven_s > STUCK_RETURN_S or self._driven_s + self._waited_s > self._held_s

    def check(self, progress: float) -> None:
        """Raise `Discrepancy` if the base has not got on for `STUCK_RETURN_S`, or for `HELD_RETURN_S` where
        obstacles or people held it.

        Args:
            progress: length of the way back that the base has covered, in [m].
        """
        robot = self._robot
        if not self.is_over(progress):
            return
        passed = self._driven_s + self._waited_s
        limit = STUCK_RETURN_S if self._driven_s > STUCK_RETURN_S else self._held_s
        stood = Measured("Base", "time without getting on", passed, limit, "s")
        why = "" if robot.held is None else f": {robot.held.words}"
        raise Discrepancy(
            f"the base doesn't get on on its way back{why}", measured=stood, cause=causes.NO_PROGRESS
        )
