"""Detect that a base that is commanded to drive does not move."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2

SHORTEST_WINDOW_S = 0.4  # drives and sensors lag behind a command by less
LONGEST_WINDOW_S = 0.9
MIN_COMMANDED_M = 0.04  # commanded in a window, to distinguish standstill from noise of the pose
MAX_PROGRESS = 0.25  # share of what was commanded: wheels that slip on a free floor get further
CONFIRMING_PERIODS = 3  # periods in a row


class _Period(NamedTuple):
    """One control period."""

    commanded: float
    """Distance ahead, in [m]; negative backwards."""
    rolled: float
    """Distance by the encoders, in [m]; negative backwards."""
    before: Pose2
    """Estimated map_T_base at its start."""
    now: Pose2
    """Estimated map_T_base at its end."""
    ahead: float
    """Distance that the base moved in `direction`, in [m]; negative against it."""
    direction: float
    """Direction in which the base is driven, relative to its heading, in [rad]."""


class Blocked(NamedTuple):
    """Evidence that a base does not move although its drive is commanded to: its pose, and the distances
    commanded, rolled by the wheels and moved by the base.
    """

    pose: Pose2
    """Estimated map_T_base where the base is blocked; it may have rebounded since."""
    heading: float
    """Heading of the base at the beginning of the judged window of `BlockedMotion`, in [rad]; wheels that
    keep driving turn the base on the spot.
    """
    forwards: bool
    """True if it was driven forwards."""
    commanded: float
    """Distance commanded in the window, in [m]."""
    rolled: float
    """Distance that the wheels rolled in the window by their encoders, in [m]."""
    moved: float
    """Distance that the base moved in the window in the driven direction, by all sensors, in [m]; negative
    where it rebounded."""
    direction: float = 0.0
    """Direction of travel relative to the heading, in [rad]; `pose` and `heading` include it."""

    @property
    def slips(self) -> bool:
        """True if the wheels turn although the base is blocked; otherwise the wheels are blocked or their
        drives are switched off.
        """
        return self.rolled > MAX_PROGRESS * self.commanded


class BlockedMotion:
    """Detector of a blocked base, which compares commanded and measured motion in a sliding window of time.

    The window is the shortest in which the base was commanded to move by `MIN_COMMANDED_M` in one direction.
    If that takes longer than `LONGEST_WINDOW_S`, nothing is reported, because such slow motion is below the
    noise of the pose.
    """

    def __init__(self, period: float, confirming: int = CONFIRMING_PERIODS) -> None:
        """Start with an empty window.

        Args:
            period: control period, in [s].
            confirming: number of periods in a row that have to show that the base is blocked.
        """
        self._confirming = confirming
        self._shortest = max(2, round(SHORTEST_WINDOW_S / period))
        self._periods: deque[_Period] = deque(maxlen=max(self._shortest, round(LONGEST_WINDOW_S / period)))
        self._length = period
        self._in_a_row = 0

    def clear(self) -> None:
        """Discard all motion that was recorded so far, so that a new window of time begins."""
        self._periods.clear()
        self._in_a_row = 0

    def update(
        self, speed: float, rolled: float, before: Pose2, now: Pose2, direction: float = 0.0
    ) -> Blocked | None:
        """Add a period's motion to the window of recent motion; return the evidence that the base is blocked,
        None if it is not.

        Args:
            speed: commanded speed in the direction of travel, in [m/s]; negative in the opposite direction; 0
                empties the window of recent motion.
            rolled: distance rolled by the wheels in the direction of travel, in [m]; negative in the opposite
                direction.
            before: estimated map_T_base before the period.
            now: estimated map_T_base after the period.
            direction: direction of travel relative to the heading, in [rad], positive to the left.
        """
        if speed == 0.0:
            self.clear()
            return None
        if direction != 0.0:
            before, now = (pose.compose(Pose2(0.0, 0.0, direction)) for pose in (before, now))
        commanded = speed * self._length
        if self._periods and commanded * self._periods[-1].commanded < 0.0:
            self.clear()
        ahead = now.relative_to(before).x
        self._periods.append(_Period(commanded, rolled, before, now, ahead, direction))
        found = self._judged()
        self._in_a_row = 0 if found is None else self._in_a_row + 1
        return found if self._in_a_row >= self._confirming else None

    def _judged(self) -> Blocked | None:
        commanded, rolled, ahead = 0.0, 0.0, 0.0
        for count, period in enumerate(reversed(self._periods), start=1):
            commanded += period.commanded
            rolled += period.rolled
            ahead += period.ahead
            if count < self._shortest or abs(commanded) < MIN_COMMANDED_M:
                continue
            sign = math.copysign(1.0, commanded)
            if sign * ahead > MAX_PROGRESS * abs(commanded):
                return None
            window = list(self._periods)[-count:]
            farthest = int(np.argmax(np.cumsum([sign * item.ahead for item in window])))
            return Blocked(
                window[farthest].now,
                period.before.theta,
                commanded > 0.0,
                abs(commanded),
                sign * rolled,
                sign * ahead,
                window[farthest].direction,
            )
        return None
