"""From counts to metres and radians."""

from __future__ import annotations

from dataclasses import dataclass

_LONGEST = 2**31


@dataclass(frozen=True)
class AxisUnits:
    """Counts never leave `backends/can`."""

    scale: float
    """Counts for a metre or a radian, signed."""
    zero: int = 0
    """Counts at zero."""

    def counts(self, position: float) -> int:
        """Of a position."""
        return round(position * self.scale) + self.zero

    def position(self, counts: float) -> float:
        """Of counts, in [m] or [rad]."""
        return (counts - self.zero) / self.scale

    def rate(self, value: float) -> int:
        """Counts/s or counts/s² for a speed or an acceleration, with its sign."""
        return round(value * self.scale)

    def size(self, value: float) -> int:
        """The same without a sign."""
        return abs(self.rate(value))

    def speed(self, counts: float) -> float:
        """Of counts/s."""
        return counts / self.scale


def unwrapped(counts: int, before: int) -> int:
    """By how much counts of 32 bits have changed."""
    return (counts - before + _LONGEST) % (2 * _LONGEST) - _LONGEST
