"""Tracking a moving reference with a differential drive.

Kanayama, Kimura, Miyazaki and Noguchi, "A stable tracking control method for an autonomous mobile robot"
(1990). `PathTracker` follows a route, whenever the robot gets there; this follows a reference in time.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from handcart.robotics.geometry.pose2 import Pose2


class Reference(NamedTuple):
    """Where the robot should be now, and how it should move there."""

    pose: Pose2
    speed: float
    """In [m/s]."""
    turn_rate: float = 0.0
    """In [rad/s]."""


class KanayamaGains(NamedTuple):
    """Those of the paper: stable if all are above zero; critically damped where Kθ² = 4 Ky."""

    along: float = 10.0
    """Kx, in [1/s]."""
    across: float = 64.0
    """Ky, in [1/m²]."""
    heading: float = 16.0
    """Kθ, in [1/m]."""


def kanayama(
    reference: Reference, pose: Pose2, gains: KanayamaGains = KanayamaGains()
) -> tuple[float, float]:
    """Speed in [m/s] and turn rate in [rad/s] that bring a robot at `pose` to the reference (eq. 8).

    It steers in proportion to the reference's speed: while that stands still only the error along the heading
    is driven out. Commands aren't limited.
    """
    error = reference.pose.relative_to(pose)
    speed = reference.speed * math.cos(error.theta) + gains.along * error.x
    steering = gains.across * error.y + gains.heading * math.sin(error.theta)
    return speed, reference.turn_rate + reference.speed * steering


class StraightRun:
    """A reference that sets out at rest, runs straight ahead, and comes to rest."""

    def __init__(self, start: Pose2, length: float, speed: float = 0.3, acceleration: float = 0.3) -> None:
        """From `start` over `length` [m], at most `speed` [m/s], with `acceleration` [m/s²] at both ends."""
        if min(length, speed, acceleration) <= 0.0:
            raise ValueError("length, speed and acceleration must be above zero")
        self._start, self._length, self._acceleration = start, length, acceleration
        self._speed = min(speed, math.sqrt(length * acceleration))
        self._ramp = self._speed / acceleration
        self.duration = length / self._speed + self._ramp
        """In [s]."""

    def at(self, time: float) -> Reference:
        """The reference at `time` [s] after the start; before and after it stands still."""
        time = min(max(time, 0.0), self.duration)
        left = self.duration - time
        if time < self._ramp:
            along, speed = 0.5 * self._acceleration * time**2, self._acceleration * time
        elif left < self._ramp:
            along, speed = self._length - 0.5 * self._acceleration * left**2, self._acceleration * left
        else:
            along, speed = self._speed * (time - 0.5 * self._ramp), self._speed
        return Reference(self._start.compose(Pose2(along, 0.0, 0.0)), speed)
