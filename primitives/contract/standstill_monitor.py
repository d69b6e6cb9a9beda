"""A base that is driven and doesn't move."""

from __future__ import annotations

import math

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured

STANDSTILL_TIMEOUT_S = 10.0
MIN_MOTION = (0.005, math.radians(0.3))  # [m], [rad]: less is not motion


class StandstillMonitor:
    """Monitor that detects a base that does not move although it is commanded to drive.

    A base that is held back before an obstacle, to prevent a collision, is not reported.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._place, self._driven = robot.pose, 0.0

    def check(self) -> None:
        """Raise `Discrepancy` if the base was commanded to drive for `STANDSTILL_TIMEOUT_S`, but has not
        moved.

        To be called once a period. Motion of less than `MIN_MOTION` does not count.
        """
        robot = self._robot
        moved = (
            robot.pose.distance(self._place) > MIN_MOTION[0] or robot.pose.turn(self._place) > MIN_MOTION[1]
        )
        if moved or robot.held is not None:
            self._place, self._driven = robot.pose, 0.0
        elif any(robot.command):
            self._driven += robot.period
        if self._driven > STANDSTILL_TIMEOUT_S:
            stood = Measured("Base", "time driven without moving", self._driven, STANDSTILL_TIMEOUT_S, "s")
            raise Discrepancy(
                "the base doesn't move, though it is driven",
                measured=stood,
                check="standstill",
                cause=causes.NO_PROGRESS,
            )
