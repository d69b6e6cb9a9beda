"""Expected motion of an axis whose drive follows its commands."""

from __future__ import annotations

from dataclasses import dataclass

from handcart.backends.can.bus.pdo_layout import CYCLIC_POSITION, CYCLIC_VELOCITY, PROFILE_POSITION

from .axis_limits import AxisLimits
from .profile import approach, ramp


@dataclass
class ExpectedMotion:
    """Simulated motion that an axis should make by its commands, for comparison with the measured motion.

    In profile modes it follows the ramps that the drive plans; in cyclic modes the drive applies a set-point
    one period after it was sent.
    """

    mode: int
    limits: AxisLimits
    position: float = 0.0
    """Position of the axis, in [m] or [rad]."""
    velocity: float = 0.0
    """Velocity of the axis, in [m/s] or [rad/s]."""
    way: float = 0.0
    """Travel in the last period [m] or [rad]."""
    speed: float = 0.0
    """Speed in the last period [m/s] or [rad/s]."""
    _next: float = 0.0
    """Cyclic set-point that becomes valid with the next SYNC, in [m] or [rad], or [m/s] for a wheel."""

    def stand_at(self, position: float) -> None:
        """Set the expected motion to rest at a position in [m] or [rad]."""
        self.position, self.velocity = position, 0.0
        self._next = 0.0 if self.mode == CYCLIC_VELOCITY else position

    def advance(self, target: float, top: float, period: float) -> None:
        """Advance the expected motion by one period.

        Args:
            target: speed of a wheel in [m/s], otherwise a position in [m] or [rad].
            top: largest speed while the axis moves to a position, in [m/s] or [rad/s].
            period: control period, in [s].
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
