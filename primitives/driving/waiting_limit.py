"""Limit on the waiting of a drive that does not get nearer to its goal."""

from __future__ import annotations

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured

WAITING_LIMIT_S = 300.0  # in total, of waits that each may be short
WAITING_LIMIT_RATIO = 2.0  # of the time that a drive waits for one obstacle, if that is more
GETTING_NEARER_M = 0.1  # by which the rest of the way has to shrink


class WaitingLimit:
    """Sum of the waits of a drive since it last got nearer to its goal, with a limit.

    A wait ends as soon as something changes: a person leaves, a new scan comes. Without this limit, a drive
    in which something always changes would wait again and again without end.
    """

    def __init__(self, name: str, wait_s: float) -> None:
        """Begin a drive to the place `name` that waits for one obstacle for up to `wait_s`, in [s]."""
        self._name, self._limit_s = name, max(WAITING_LIMIT_S, WAITING_LIMIT_RATIO * wait_s)
        self._nearest, self._waited_s = np.inf, 0.0

    def note(self, robot: Robot, remaining: float, waits: bool) -> None:
        """Note a period of the drive.

        Args:
            robot: the robot.
            remaining: length of the rest of the way, in [m].
            waits: True if the base waits in this period.

        Raises:
            Discrepancy: the base has waited for longer than the limit without getting nearer.
        """
        if remaining < self._nearest - GETTING_NEARER_M:
            self._nearest, self._waited_s = remaining, 0.0
        if not waits:
            return
        self._waited_s += robot.period
        if self._waited_s > self._limit_s:
            waited = Measured("Base", "waits without getting nearer", self._waited_s, self._limit_s, "s")
            raise Discrepancy(
                f"the base doesn't get nearer to {self._name}: it has to wait again and again",
                measured=waited,
                cause=causes.BLOCKED,
            )
