"""Limits of a drive, and commands that stay within them."""

from __future__ import annotations

import math
from typing import NamedTuple

BRAKING_SHARE = 0.5  # share of the acceleration that braking is planned with; the rest is for late commands
# [1/s]: close to the end speed falls in proportion to what is left, so that nothing overshoots
END_APPROACH_RATE = 4.0

MIN_LATERAL_SPEED_M_S = 1e-3  # below which no turn is limited by the lateral acceleration


class DriveLimits(NamedTuple):
    """Limits of the base's speed, turn rate and accelerations, which commands to it have to keep."""

    speed: float = 0.5
    """Maximum speed in [m/s]."""
    turn_rate: float = 1.2
    """Maximum turn rate in [rad/s]."""
    acceleration: float = 0.6
    """Maximum acceleration in [m/s²]."""
    turn_acceleration: float = 2.5
    """Maximum angular acceleration in [rad/s²]."""
    lateral_acceleration: float = 1.0
    """Maximum of speed times turn rate, in [m/s²]."""
    sideways: float = 0.0
    """Maximum speed sideways in [m/s]; 0 of a base that cannot drive sideways."""

    def turn_rate_at(self, speed: float) -> float:
        """Return the maximum turn rate, in [rad/s], allowed at a speed in [m/s]."""
        return min(self.turn_rate, self.lateral_acceleration / max(abs(speed), MIN_LATERAL_SPEED_M_S))


def rate_to_stop(rest: float, most: float, acceleration: float) -> float:
    """Return the largest speed from which a base or joint can still stop at the end of a remaining distance.

    Args:
        rest: remaining distance, in [m] or [rad]; the speed has the same sign.
        most: largest speed, in [m/s] or [rad/s].
        acceleration: largest acceleration, in [m/s²] or [rad/s²].
    """
    size = min(most, math.sqrt(2.0 * BRAKING_SHARE * acceleration * abs(rest)), END_APPROACH_RATE * abs(rest))
    return math.copysign(size, rest)


class Ramp:
    """Limiter that keeps commands of a base within limits of speed and acceleration, starting from the last
    command.
    """

    def __init__(self, limits: DriveLimits) -> None:
        """Start at rest."""
        self.limits = limits
        self.speed = 0.0
        self.turn_rate = 0.0

    @property
    def at_rest(self) -> bool:
        """True if the last command was below 1 mm/s and 2 mrad/s."""
        return abs(self.speed) < 1e-3 and abs(self.turn_rate) < 2e-3

    def reset(self) -> None:
        """Reset the last command to zero, because the base is at rest."""
        self.speed = self.turn_rate = 0.0

    def towards(self, speed: float, turn_rate: float, dt: float) -> tuple[float, ...]:
        """Return the allowed command nearest to the wanted one: speed and turn rate.

        Args:
            speed: wanted speed in [m/s], negative backwards.
            turn_rate: wanted turn rate in [rad/s], positive to the left.
            dt: time since the last command, in [s].
        """
        limits = self.limits
        speed = _clip(speed, limits.speed)
        turn_rate = _clip(turn_rate, limits.turn_rate)
        self.speed += _clip(speed - self.speed, limits.acceleration * dt)
        self.turn_rate += _clip(turn_rate - self.turn_rate, limits.turn_acceleration * dt)
        self.turn_rate = _clip(self.turn_rate, limits.turn_rate_at(self.speed))
        return self.speed, self.turn_rate


def _clip(value: float, most: float) -> float:
    return max(-most, min(most, value))
