"""Detect that one wheel of a base, or both, does not move as commanded, also during turns on the spot."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.geometry.pose2 import Pose2

from .blocked_motion import Blocked, BlockedMotion

CONFIRMING_PERIODS = 7  # in a row: an obstacle ahead is found first, with its place
START_POSE = Pose2(0.0, 0.0, 0.0)


class BlockedWheel(NamedTuple):
    """Evidence that a base is blocked at one wheel or both, although the wheels are commanded to move."""

    side: str
    """`left`, `right` or `both`."""
    pose: Pose2
    """Estimated map_T_base after the period in which the wheel was found to be blocked."""
    evidence: Blocked
    """Commanded, rolled and actual travel of a blocked wheel.

    Its `pose` is not on the map: x is the travel of the base at the wheel in one period; `heading` is 0.
    """


class BlockedWheels:
    """Detector of a base blocked at a wheel, which compares each wheel's command with the base's motion
    there.

    The motion is taken from the estimated pose. While a base is commanded to turn on the spot, its distance
    ahead is 0 whether it is blocked or not, so each wheel is compared alone. A base that is blocked at one
    side turns around that side.
    """

    def __init__(self, period: float, tread: float) -> None:
        """Start without any periods.

        Args:
            period: control period, in [s].
            tread: distance of the wheels, in [m].
        """
        self._period, self._tread = period, tread
        self._sides = {side: BlockedMotion(period, CONFIRMING_PERIODS) for side in ("left", "right")}

    def clear(self) -> None:
        """Discard all motion that was recorded so far, so that a new window of time begins."""
        for side in self._sides.values():
            side.clear()

    def update(
        self, command: tuple[float, float], rolled: tuple[float, float], before: Pose2, now: Pose2
    ) -> BlockedWheel | None:
        """Add the motion of one control period to the recorded motion of earlier periods, and return a wheel
        at which the base moved much less than commanded (see `BlockedMotion`); None if there is none.

        Args:
            command: commanded speed ahead in [m/s] and turn rate in [rad/s].
            rolled: distance rolled in the period by the left and by the right wheel, by their encoders, in
                [m].
            before: estimated map_T_base before the period.
            now: estimated map_T_base after the period.
        """
        if command[0] == command[1] == 0.0:
            self.clear()
            return None
        motion, half = now.relative_to(before), 0.5 * self._tread
        found = {}
        for (name, side), sign, way in zip(self._sides.items(), (-1.0, 1.0), rolled, strict=True):
            moved = Pose2(motion.x + sign * half * motion.theta, 0.0, 0.0)
            speed = command[0] + sign * half * command[1]
            if (blocked := side.update(speed, way, START_POSE, moved)) is not None:
                found[name] = blocked
        if not found:
            return None
        worst = max(found.values(), key=lambda item: abs(item.commanded))
        self.clear()
        return BlockedWheel("both" if len(found) > 1 else next(iter(found)), now, worst)
