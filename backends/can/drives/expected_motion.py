"""What an axis should do by now, if its drive does what it is told."""

from __future__ import annotations

from dataclasses import dataclass

from handcart.backends.can.bus.pdo_layout import CYCLIC_POSITION, CYCLIC_VELOCITY, PROFILE_POSITION

from .axis_limits import AxisLimits
from .profile import approach, ramp


@dataclass
class ExpectedMotion:
    """The same ramps that the drive plans; a cyclic target counts one period later."""

    mode: int
    limits: AxisLimits
    position: float = 0.0
    """[m] or [rad]"""
    velocity: float = 0.0
    """[m/s] or [rad/s]"""
    way: float = 0.0
    """Of the last period, in [m] or [rad]."""
    speed: float = 0.0
    """In it, in [m/s] or [rad/s]."""
    _next: float = 0.0
    """The cyclic target that the next SYNC makes count."""

    def stand_at(self, position: float) -> None:
        """It stands."""
        self.position, self.velocity = position, 0.0
        self._next = 0.0 if self.mode == CYCLIC_VELOCITY else position

    def advance(self, target: float, top: float, period: float) -> None:
        """Let a period in [s] pass.

        Args:
            target: speed of a wheel, else position.
            top: speed on the way to a position.
            period: in [s].
        """
        before, rate = self.position, self.limits.acceleration
        if self.mode == PROFILE_POSITION:
            left, self.velocity = approach(target - self.position, self.velocity, top, (rate, rate), period)
            self.position = target - left
        elif self.mode == CYCLIC_POSITION:
            self.velocity = (self._next - self.position) / period
            self.position, self._next = self._next, target
        elif self.mode == CYCLIC_VELOCITY:
            self.velocity, self._next = self._next, target
            self.position += self.velocity * period
        else:
            way, self.velocity = ramp(self.velocity, target, rate, period)
            self.position += way
        self.way = self.position - before
        self.speed = self.way / period
