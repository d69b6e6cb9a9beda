"""Pauses in a motion of the base, such as a wait for a person."""

from __future__ import annotations

from handcart.backends.robot.robot import Robot

PAUSE_PERIODS = 1.5  # between two commands of a motion, from which it was paused


class Pauses:
    """Detector of pauses of a motion, in which the base came to rest; asked before each command.

    The motion's controller does not know of the pause, and would continue with the last speed.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot, self._last = robot, robot.time

    def has_ended(self) -> bool:
        """Return whether the motion was paused since the last call."""
        last, self._last = self._last, self._robot.time
        return self._last > last + PAUSE_PERIODS * self._robot.period
