"""Keeping a base on a straight way, at a given pace."""

from __future__ import annotations

from handcart.robotics.geometry.pose2 import Pose2

from .drive_limits import DriveLimits, Ramp

CATCH_UP_RATE = 1.0  # [1/s] by which it catches up with where it should be on its way
RETURN_LENGTH_M = 0.5  # [m] of way in which it comes back to it


class StraightWay:
    """Controller that drives a base along a straight line so that it keeps up with a point moving on that
    line.

    Lateral error and heading error decay over a distance of `RETURN_LENGTH_M`, critically damped, also in
    backward driving.
    """

    def __init__(self, start: Pose2, limits: DriveLimits) -> None:
        """Plan a straight way ahead from `start`, world_T_base, and back."""
        self._start, self._ramp = start, Ramp(limits)

    def command(self, pose: Pose2, along: float, speed: float, dt: float) -> tuple[float, float]:
        """Return speed in [m/s], negative backwards, and turn rate in [rad/s] for the next period.

        Args:
            pose: world_T_base.
            along: wanted position of the base on the line now, in [m] ahead of the start; negative behind the
                start.
            speed: speed with which the wanted position moves along the line, in [m/s].
            dt: control period, in [s].
        """
        here = pose.relative_to(self._start)
        turn = -(speed * here.y / RETURN_LENGTH_M + 2.0 * abs(speed) * here.theta) / RETURN_LENGTH_M
        along, turn, *_ = self._ramp.towards(speed + CATCH_UP_RATE * (along - here.x), turn, dt)
        return along, turn
